//! Diagnosis: which physical effect is missing in a model?
//!
//! `diagnose` tests every effect of the catalogue as a hypothesis about all logs together, by
//! simulation where a regression can't (delays, pauses, limits, timing), and ends in one of five
//! verdicts. The method in short:
//!
//! 1. `clock`: do the cycles last as long as the log says?
//! 2. `actuator`: which stage between sent and executed velocity is missing?
//! 3. `wrench::sampling`: does the sensor round or repeat its readings?
//! 4. `wrench`: which physical load or sensor error explains the wrench, predicted from the
//!    simulated, noise-free motion?
//! 5. `body`: does the rig's model of the spacecraft differ from the user's?
//! 6. `prediction_error`: how much of the error on unseen data goes, and with which parameters most?
//! 7. `noise`: is what remains noise?
//! 8. `answer`: the verdict, rivals that the logs allow as well, and notes.
//!
//! Where the recorded velocity is the difference of poses, an error of the clock shows in both. Then `stages`, which runs 1 to 5
//! in this order, goes through 1 to 4 once more with an error of the clock in the place of the actuator stage that it looks like.
//!
//! What evidence an effect needs is defined in `evidence`. Nominal parameters may move within their tolerances in every
//! hypothesis; those that would have to move further are findings themselves.

mod actuator;
mod answer;
mod body;
mod catalogue;
mod clock;
mod conclusion;
pub(crate) mod evidence;
mod finding;
mod logs;
mod named;
mod noise;
mod prediction_error;
mod question;
mod stages;
mod stretches;
mod watch;
mod wrench;

pub use evidence::NAMED;
pub use finding::*;
pub use logs::Logs;

use crate::compare::compare;
use crate::fit::same_rig;
use crate::held_back::{all_held_back, are_of_one_log};
use crate::import::checks::{acceleration, force};
use crate::levels::ChannelLevels;
use answer::outcome::Outcome;
use anyhow::{bail, ensure};
use conclusion::Asking;
use prediction_error::brakes::{WRONG, amplitude_factor};
use question::Question;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::prediction::Prediction;
use softdock_report::number;
use std::time::Instant;
use watch::Watch;
use wrench::finding::WrenchFinding;

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

/// Diagnoses what a model lacks. All logs together decide what is missing. Its parameters are those of the logs `train`, and
/// errors are those on `test`, which the parameters have not seen. Without `test` the ends of the others are held back.
/// `progress` is called with the share that is done and the present step.
///
/// # Errors
///
/// Logs that cannot be predicted at all: fewer than two cycles, unreadable settings, no rising
/// time.
pub fn diagnose(
    model: &Model,
    train: &[&Recording],
    test: &[&Recording],
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Report> {
    ask(model, train, test, &Question::default(), progress)
}

/// [`diagnose`] with a caller that follows it: `tried` is called with each hypothesis when it is tried. Either of the two
/// callbacks may end the diagnosis by unwinding ([`std::panic::resume_unwind`]).
///
/// # Errors
///
/// Those of [`diagnose`].
pub fn diagnose_watched(
    model: &Model,
    train: &[&Recording],
    test: &[&Recording],
    progress: &dyn Fn(f64, &str),
    tried: &(dyn Fn(&Trial) + Sync),
) -> anyhow::Result<Report> {
    let question = Question {
        watch: Watch(Some(tried)),
        ..Question::default()
    };
    ask(model, train, test, &question, progress)
}

/// Fits one effect, beside those that the model has already. `forced`: also if the data hardly
/// shows it.
///
/// # Errors
///
/// Those of [`diagnose`]; an effect that is in the model already, on which these logs say nothing,
/// or whose sign physics forbids.
pub fn fit_effect(
    model: &Model,
    id: &str,
    train: &[&Recording],
    test: &[&Recording],
    forced: bool,
) -> anyhow::Result<Report> {
    ensure_lacks(model, id)?;
    let question = Question {
        only: Some(id),
        forced,
        ..Question::default()
    };
    let report = ask(model, train, test, &question, &|_, _| {})?;
    if report.diagnosis.effects.iter().any(|e| e == id) {
        return Ok(report);
    }
    let about = |note: &&String| note.starts_with(id);
    if let Some(note) = report.diagnosis.notes.iter().find(about) {
        bail!("`{id}` is not added: {note}");
    }
    let tried = report.diagnosis.ranked.first();
    match tried.map(|r| (&r.refused, r)) {
        Some((Some(reason), _)) => bail!("`{id}` is not added: {reason}"),
        Some((None, ranked)) => {
            let rows = train.iter().chain(test).map(|log| log.cycles.len()).sum();
            bail!("`{id}` is not added: {}", too_little(id, ranked, rows))
        }
        None => bail!(
            "`{id}` cannot be determined from this log: it has nothing for the effect to act on, or \
             shows nothing of it with the sign that it must have; see softdock effects show {id}{}",
            confused_with(id)
        ),
    }
}

pub(crate) fn ensure_lacks(model: &Model, id: &str) -> anyhow::Result<()> {
    ensure!(
        !catalogue::has(model, id),
        "`{id}` is in the model already; `softdock fit` fits it anew"
    );
    Ok(())
}

/// Why the fall of χ² over this many rows does not suffice: it is compared with the evidence that a name needs and the price of
/// the parameters. The search counts only the rows that it has looked at, so the price is approximate.
fn too_little(id: &str, ranked: &Ranked, rows: usize) -> String {
    let cost = evidence::threshold(0.0)
        + evidence::prior()
        + evidence::price(rows) * ranked.parameters as f64;
    let fitted = ranked.parameters;
    let falls = format!(
        "χ² falls by {:.0} on the log of the fit and by {:.0} on unseen data",
        ranked.gain_train, ranked.gain_test
    );
    if ranked.gain_train + ranked.gain_test < cost {
        return format!(
            "{falls}, together less than the {cost:.0} or so that a name takes (fitted parameters: {fitted}); take a log that excites it (softdock effects \
             show {id})"
        );
    }
    format!(
        "{falls}, together more than the {cost:.0} or so that a name takes (fitted parameters: {fitted}), but no more than \
         an error of the form of what the model has already may make, or with amounts that the logs do not have in common; if something else is missing as well, \
         `softdock add` without an effect looks for all of it, with several it fits them together, and --force adds this one alone"
    )
}

/// A hint at effects that are confused with this one; empty if there are none.
fn confused_with(id: &str) -> String {
    let others =
        softdock_physics::effects::by_id(id).map_or(&[][..], |effect| effect.confused_with);
    match others.is_empty() {
        true => String::new(),
        false => format!(", or try what looks like it: {}", others.join(", ")),
    }
}

/// Fits effects together, in the forms that suit these logs best: a diagnosis that knows no other effects. Effects that are not
/// worth their price are left out of the answer. `asked`: those that are worth it are named, whatever else is missing.
///
/// # Errors
///
/// Those of [`diagnose`]; an effect that is in the model already.
pub fn fit_effects(
    model: &Model,
    ids: &[String],
    train: &[&Recording],
    test: &[&Recording],
    asked: bool,
) -> anyhow::Result<Report> {
    ids.iter().try_for_each(|id| ensure_lacks(model, id))?;
    let question = Question {
        among: Some(ids),
        asked,
        ..Question::default()
    };
    ask(model, train, test, &question, &|_, _| {})
}

fn ask(
    model: &Model,
    train: &[&Recording],
    test: &[&Recording],
    question: &Question<'_>,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Report> {
    let started = Instant::now();
    ensure!(!train.is_empty(), "expected at least one log to fit on");
    let halves: Vec<(Recording, Recording)>;
    let whole = if test.is_empty() {
        match all_held_back(train) {
            Some(all) => {
                halves = all;
                let (beginnings, ends) = halves.iter().map(|(a, b)| (a, b)).unzip();
                Logs::new(beginnings, ends)
            }
            None => Logs::new(train.to_vec(), Vec::new()),
        }
    } else {
        Logs::new(train.to_vec(), test.to_vec())
    };
    let cut = stretches::between_gaps(model, &whole);
    // Stretches of one log are not asked whether they are of one machine.
    let of_one_log = cut.is_some() || are_of_one_log(whole.train(), &whole.all[whole.fitted..]);
    let question = &Question {
        of_one_log,
        ..*question
    };
    let pieces = cut.as_ref().map_or_else(|| whole.clone(), Logs::map_refs);
    let parts = stretches::of_long(&pieces);
    let recordings = parts
        .as_ref()
        .map_or_else(|| pieces.clone(), Logs::map_refs);
    let unseen = !test.is_empty();
    let asking = Asking {
        model,
        recordings: &recordings,
        unseen,
        question,
    };
    let (stages, outcome) = asking.concluded(progress)?;
    let much_is_left = stages.wrench.as_ref().is_some_and(much_is_left);
    let is_whole = outcome.diagnosis.verdict == Verdict::Named && cut.is_none();
    let left = match is_whole && much_is_left {
        true => left_on_each(&outcome, &recordings)?,
        false => Vec::new(),
    };
    let mut diagnosis = outcome.diagnosis;
    if cut.is_some() {
        let note = stretches::note_of_gaps(&whole, &pieces);
        diagnosis.notes.push(note);
    }
    if parts.is_some() {
        diagnosis.notes.push(stretches::note(&pieces, &recordings));
    }
    diagnosis.notes.extend(left);
    if let Some(settings) = same_rig::said_first(train, test) {
        diagnosis.sentence = answer::sentence::of_two_rigs(&settings, &diagnosis.sentence);
    }
    diagnosis.sentence += &of_free_swing(&outcome.after, recordings.test());
    let finds_something = !matches!(
        diagnosis.verdict,
        Verdict::NothingMissing | Verdict::NotTestable
    );
    if finds_something {
        // Logs that differ do so whatever their noise is.
        let is_of_motion = diagnosis.verdict != Verdict::LogsDisagree && stages.wrench.is_some();
        let noise = || acceleration::said_first(model, train).filter(|_| is_of_motion);
        if let Some(first) = force::said_first(model, train).or_else(noise) {
            diagnosis.sentence = format!("{first}. {}", diagnosis.sentence);
        }
    }
    diagnosis.seconds = started.elapsed().as_secs_f64();
    progress(1.0, "done");
    Ok(Report {
        diagnosis,
        after: outcome.after,
        before_prediction: stages.before.shown().clone(),
        after_prediction: outcome.predictions.shown().clone(),
    })
}

/// A sentence on a free swing whose amplitude the model with the named effects does not foretell; empty for any other log. At each
/// instant a friction is less than the noise of the acceleration.
fn of_free_swing(after: &Model, recordings: &[&Recording]) -> String {
    let factor = amplitude_factor(after, recordings).filter(|factor| *factor > WRONG);
    factor.map_or(String::new(), |factor| {
        format!(
            " Simulated forward the amplitude of the swing is wrong by a factor of {}: a friction is missing or wrong. Behind a lower \
             `cutoff_hz` of the import less of it is hidden by noise.",
            number::significant(factor, 3)
        )
    })
}

/// Notes with what a comparison says of the model with the named effects: on the log of the fit and the unseen log with the
/// largest error each.
fn left_on_each(outcome: &Outcome, recordings: &Logs<&Recording>) -> anyhow::Result<Vec<String>> {
    let (diagnosis, predictions) = (&outcome.diagnosis, &outcome.predictions);
    let of = |recordings: &[&Recording], predictions: &[Prediction], name: &str| {
        let left = predictions
            .iter()
            .map(|p| ChannelLevels::of(std::slice::from_ref(p)).wrench);
        let known = left.enumerate().filter(|(_, left)| left.is_finite());
        let worst = known.max_by(|a, b| a.1.total_cmp(&b.1));
        let worst = worst.map_or(0, |(worst, _)| worst);
        let log = match recordings.len() {
            1 => name.to_owned(),
            count => format!(
                "{name}, number {} of {count}, which has the largest error",
                worst + 1
            ),
        };
        let rest = compare(&outcome.after, recordings[worst])?.sentence;
        Ok(format!("What is left on {log}: {rest}"))
    };
    let mut each = vec![of(
        recordings.train(),
        predictions.train(),
        "the log of the fit",
    )];
    if !diagnosis.in_sample {
        let name = match diagnosis.unseen {
            true => "the log of the test",
            false => "the end of the log",
        };
        each.push(of(recordings.test(), predictions.test(), name));
    }
    each.into_iter().collect()
}

/// Whether more than errors of form is left of the reading.
fn much_is_left(found: &WrenchFinding) -> bool {
    let accepted = found.found.accepted.as_ref();
    accepted.is_some_and(|accepted| found.prepared.has_much_left(accepted.gain))
}
