//! Which physical effect is missing?
//!
//! `diagnose` tests every effect of the catalogue as a hypothesis about a log, by simulation where
//! a regression can't (delays, pauses, limits, timing), and ends in one of three verdicts. The
//! method in short:
//!
//! 1. `clock`: do the cycles last as long as the log says?
//! 2. `actuator`: which stage between sent and executed velocity is missing?
//! 3. `sampling`: does the sensor round or repeat its readings?
//! 4. `wrench`: which physical load or sensor error explains the wrench, predicted from the
//!    simulated, noise-free motion?
//! 5. `body`: does the rig's model of the spacecraft differ from the user's?
//! 6. `structure`: is what remains noise?
//!
//! Where the recorded velocity is the difference of poses, the clock is in both of them. Then
//! `rivals` goes through 1 to 4 once more with an error of the clock in the place of the stage of
//! the actuator that it looks like.
//!
//! An effect counts only if it is significant on the log that it was fitted on, keeps its promise
//! on unseen data with the same parameters, and has a sign that physics allows. Nominal parameters
//! may move within their tolerances in every hypothesis.

mod actuator;
mod body;
mod clock;
mod engine;
mod equivalent;
mod error_reduction;
mod finding;
mod named;
pub(crate) mod optimise;
mod outcome;
mod ranking;
mod regions;
mod rivals;
mod rounding;
mod sampling;
mod sentence;
mod stage_results;
mod structure;
mod timed_logs;
mod wrench;

pub use finding::*;
pub(crate) use outcome::levels;

use crate::compare::compare;
use crate::model::Model;
use crate::model::prediction::Prediction;
use crate::recording::Recording;
use anyhow::{bail, ensure};
pub use engine::Pair;
use engine::{Question, WrenchFinding};
use softdock_app::record::CycleRecord;
use std::time::Instant;

/// Share of a log that is held back where no unseen log is given.
const HELD_BACK: f64 = 0.4;

/// A diagnosis with what its report draws.
#[derive(Clone, Debug)]
pub struct Report {
    /// What was found.
    pub diagnosis: Diagnosis,
    /// The model with the named effects.
    pub after: Model,
    /// Prediction of the judged log with the model as given.
    pub before_prediction: Prediction,
    /// The same with the named effects.
    pub after_prediction: Prediction,
}

/// Diagnoses what a model lacks, on the log `train`, and judges on `test`; without it the end of
/// `train` is held back. `progress` is told the share that is done, and what is being done.
///
/// # Errors
///
/// Logs that cannot be predicted at all: fewer than two cycles, unreadable settings, no rising
/// time.
pub fn diagnose(
    model: &Model,
    train: &Recording,
    test: Option<&Recording>,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Report> {
    ask(model, train, test, &Question::default(), progress)
}

/// Fits one effect, beside those that the model has already. `forced`: also if the data hardly
/// shows it.
///
/// # Errors
///
/// Those of [`diagnose`]; an effect that is in the model already, on which these logs say nothing,
/// whose sign physics forbids, or that does not help on unseen data.
pub fn fit_effect(
    model: &Model,
    id: &str,
    train: &Recording,
    test: Option<&Recording>,
    forced: bool,
) -> anyhow::Result<Report> {
    ensure!(
        !engine::has(model, id),
        "`{id}` is in the model already; `softdock fit` fits it anew"
    );
    let question = Question {
        only: Some(id),
        forced,
    };
    let report = ask(model, train, test, &question, &|_, _| {})?;
    if report.diagnosis.effects.iter().any(|e| e == id) {
        return Ok(report);
    }
    let tried = report.diagnosis.ranked.first();
    match tried.map(|r| (&r.refused, r)) {
        Some((Some(reason), _)) => bail!("`{id}` is not added: {reason}"),
        Some((None, ranked)) => bail!(
            "`{id}` is not added: χ² falls by {:.0} on the log of the fit and by {:.0} on unseen \
             data, which is not significant; take a log that excites it (softdock effects show {id})",
            ranked.gain_train,
            ranked.gain_test
        ),
        None => bail!(
            "`{id}` cannot be determined from this log: it has nothing for the effect to act on, or \
             shows nothing of it; see softdock effects show {id}"
        ),
    }
}

fn ask(
    model: &Model,
    train: &Recording,
    test: Option<&Recording>,
    question: &Question<'_>,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Report> {
    let started = Instant::now();
    let halves;
    let recordings = match test {
        Some(test) => Pair { train, test },
        None => {
            halves = held_back(train);
            if moves_enough(&halves) {
                Pair {
                    train: &halves.train,
                    test: &halves.test,
                }
            } else {
                Pair { train, test: train }
            }
        }
    };
    let stages = engine::run(model, &recordings, question, progress)?;
    progress(0.95, "drawing the conclusion");
    let outcome = outcome::conclude(model, &recordings, &stages, test.is_some(), question)?;
    let mut diagnosis = outcome.diagnosis;
    if diagnosis.verdict == Verdict::Named && stages.wrench.as_ref().is_some_and(much_is_left) {
        for (log, recording) in [
            ("the log of the fit", recordings.train),
            ("unseen data", recordings.test),
        ] {
            let rest = compare(&outcome.after, recording)?.sentence;
            diagnosis
                .notes
                .push(format!("What is left on {log}: {rest}"));
        }
    }
    diagnosis.seconds = started.elapsed().as_secs_f64();
    progress(1.0, "done");
    Ok(Report {
        diagnosis,
        after: outcome.after,
        before_prediction: stages.before.test,
        after_prediction: outcome.predictions.test,
    })
}

/// Whether more than details of its form is left of the reading.
fn much_is_left(found: &WrenchFinding) -> bool {
    let accepted = found.found.accepted.as_ref();
    accepted.is_some_and(|accepted| found.prepared.train.has_much_left(accepted))
}

/// Whether what is held back excites what the beginning does.
fn moves_enough(halves: &Pair<Recording>) -> bool {
    /// Least motion of the end, as a share of that of the beginning.
    const ENOUGH: f64 = 0.1;
    let sent = |c: &CycleRecord| c.trace.sent_velocity.iter().any(|v| *v != 0.0);
    let commanded = halves.train.cycles.iter().any(sent);
    let motion = |recording: &Recording| -> f64 {
        let changes = recording.cycles.windows(2).map(|pair| {
            let (a, b) = (&pair[0].trace, &pair[1].trace);
            let of =
                |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
            if commanded {
                of(&a.sent_velocity, &b.sent_velocity)
            } else {
                of(&a.pose, &b.pose)
            }
        });
        changes.filter(|c| c.is_finite()).sum()
    };
    motion(&halves.test) > ENOUGH * motion(&halves.train)
}

/// The beginning of a recording to fit on, and its end to judge on.
pub fn held_back(recording: &Recording) -> Pair<Recording> {
    let count = recording.cycles.len();
    let at = count - (count as f64 * HELD_BACK) as usize;
    let part = |range: std::ops::Range<usize>| Recording {
        header: recording.header.clone(),
        cycles: recording.cycles[range].to_vec(),
        truth: Vec::new(),
        cut: recording.cut.clone(),
    };
    Pair {
        train: part(0..at),
        test: part(at..count),
    }
}
