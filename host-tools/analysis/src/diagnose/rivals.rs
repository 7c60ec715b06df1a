//! Errors of the clock in logs without a velocity of their own.
//!
//! There the recorded velocity is the difference of two poses, so an error of the clock looks like
//! one of the actuator: poses that are taken late like a delay, cycles that last longer like a
//! gain. The sensor tells them apart: its readings are those of the true motion, which is not
//! late, and not faster. Both are therefore followed to the end, and the one that leaves less of
//! velocity and wrench is believed; where neither does they are tied.

use super::clock::Scatter;
use super::engine::{ClockFinding, Pair, Question};
use super::stage_results::StageResults;
use super::timed_logs::TimedLogs;
use super::wrench::subtract;
use crate::model::Model;
use crate::model::actuator::{Reading, Stage};
use crate::recording::Recording;

/// χ² by which the better of two is believed.
const TOLD_APART: f64 = 12.0;
/// What a parameter costs in χ².
const PRICE: f64 = 10.0;
/// Share of the excess over the noise that recovered instants have to take away.
const TAKEN: f64 = 0.5;

/// An error of the clock beside the stage of the actuator that it looks like.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClockRival {
    /// The error of the clock.
    pub id: &'static str,
    /// The stage.
    pub of: &'static str,
    /// By how much χ² is less with the error of the clock, on the log of the fit and on unseen
    /// data.
    pub better: (f64, f64),
    /// The clock is believed.
    pub believed: bool,
    /// What the believed one gains.
    pub gain: (f64, f64),
}

impl ClockRival {
    /// Whether neither can be preferred.
    pub(crate) fn is_tie(&self) -> bool {
        self.better.0.abs() < TOLD_APART
    }
}

/// Runs the stages on the logs, as they are and with errors of their clock.
pub(super) fn run_stages(
    model: &Model,
    recordings: &Pair<&Recording>,
    question: &Question<'_>,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<(StageResults, Vec<ClockRival>)> {
    let with = |clock: Option<ClockFinding>| -> anyhow::Result<StageResults> {
        let timed = TimedLogs::new(model, recordings, clock, question)?;
        Ok(StageResults::of(timed, question, progress))
    };
    let mut best = with(None)?;
    if best.timed.logs.train.reading == Reading::AtEnd || model.sensor.at_rest {
        return Ok((best, Vec::new()));
    }
    if let Some(jitter) = jitter(&best, model, question) {
        let scattered = with(Some(ClockFinding {
            jitter: Some(jitter),
            ..ClockFinding::default()
        }))?;
        if takes_most(&best, &scattered) {
            best = scattered;
        }
    }
    let mut rivals = Vec::new();
    for (id, of, clock) in alternatives(&best, model, question) {
        let other = with(Some(clock))?;
        let (own, others) = (left(&best), left(&other));
        let better = (own.0 - others.0, own.1 - others.1);
        let alone = question.only == Some(id);
        let believed = alone || (better.0 > TOLD_APART && better.1 > 0.0);
        let gain = if believed {
            gain(&best, better)
        } else {
            gain(&best, (0.0, 0.0))
        };
        rivals.push(ClockRival {
            id,
            of,
            better,
            believed,
            gain,
        });
        if believed {
            best = other;
        }
    }
    Ok((best, rivals))
}

/// A scatter of the instants that both logs show.
fn jitter(
    found: &StageResults,
    model: &Model,
    question: &Question<'_>,
) -> Option<(f64, (f64, f64))> {
    let Pair { train, test } = &found.scatter;
    let shown = Scatter::is_significant;
    (shown(train) && shown(test) && question.tries(model, "clock_jitter"))
        .then_some((train.scatter_s, (train.gain, test.gain)))
}

/// Whether recovered instants explain most of what was left of the velocities.
fn takes_most(before: &StageResults, after: &StageResults) -> bool {
    let excess = |found: &StageResults| -> Option<[f64; 2]> {
        let level = &found.actuator.as_ref()?.level;
        let of = |axes: &[f64; 6]| axes.iter().map(|l| (l * l - 1.0).max(0.0)).sum::<f64>();
        Some([of(&level.train), of(&level.test)])
    };
    match (excess(before), excess(after)) {
        (Some(before), Some(after)) => before.iter().zip(after).all(|(b, a)| a < (1.0 - TAKEN) * b),
        _ => false,
    }
}

/// Errors of the clock that look like what was accepted, with the stage that they look like.
fn alternatives(
    found: &StageResults,
    model: &Model,
    question: &Question<'_>,
) -> Vec<(&'static str, &'static str, ClockFinding)> {
    let mut all = Vec::new();
    let Some(actuator) = &found.actuator else {
        return all;
    };
    let accepted = actuator.search.accepted.as_ref();
    let everywhere = |axes: &[bool; 6]| {
        let moves = actuator
            .white
            .train
            .each_ref()
            .map(|series| !series.is_empty());
        *axes == moves
    };
    // The fitted value of a stage that all axes have, with its deviation.
    let value = |stage: Stage| -> Option<(f64, f64)> {
        let terms = accepted?.terms.iter().zip(&actuator.intervals);
        let mut of_stage = terms.filter(|(term, _)| term.stage == stage && everywhere(&term.axes));
        let (term, intervals) = of_stage.next()?;
        let [low, high] = *intervals.first()?;
        Some((
            *term.values.first()?,
            (high - low) / (2.0 * super::named::INTERVAL_95),
        ))
    };
    let jitter = found.timed.clock.jitter;
    let alone = |id: &str| question.only == Some(id);
    let reached = accepted.map_or(actuator.search.nominal.0, |c| c.train);
    let earlier = found
        .common_delay
        .filter(|l| alone("clock_offset") || l.train + TOLD_APART < reached);
    let late_s = value(Stage::Delay).or(earlier.map(|l| l.late_s));
    if let Some(late_s) = late_s.filter(|_| question.tries(model, "clock_offset")) {
        let clock = ClockFinding {
            jitter,
            offset_s: Some(late_s),
            ..ClockFinding::default()
        };
        all.push(("clock_offset", Stage::Delay.id(), clock));
    }
    let rate = value(Stage::Gain).or(alone("clock_rate").then_some(found.proportion));
    if let Some(rate) = rate.filter(|_| question.tries(model, "clock_rate")) {
        let clock = ClockFinding {
            jitter,
            rate: Some(rate),
            ..ClockFinding::default()
        };
        all.push(("clock_rate", Stage::Gain.id(), clock));
    }
    all
}

/// Σ of squares of what is left of velocities and wrench, in units of the data sheet's noise, with
/// a price for each parameter.
fn left(found: &StageResults) -> (f64, f64) {
    let (mut train, mut test) = (0.0, 0.0);
    if let Some(actuator) = &found.actuator {
        let of = |level: &[f64; 6], log: usize| -> f64 {
            level.iter().map(|l| l * l * log as f64).sum()
        };
        train += of(&actuator.level.train, found.timed.logs.train.len());
        test += of(&actuator.level.test, found.timed.logs.test.len());
        let accepted = actuator.search.accepted.iter().flat_map(|c| &c.terms);
        train += PRICE * accepted.map(|t| t.values.len()).sum::<usize>() as f64;
    }
    if let Some(wrench) = &found.wrench {
        let accepted = wrench.found.accepted.as_ref();
        let of = |log: &super::wrench::PreparedLog| -> f64 {
            let mut rest = log.residual.clone();
            if let Some(tested) = accepted {
                subtract(&mut rest, &tested.contribution(&log.scene), 1.0);
            }
            let fresh = log.problem.fresh();
            let of_axis = |(series, sigma): (&Vec<f64>, &f64)| -> f64 {
                let counted = series.iter().zip(fresh).filter(|(_, fresh)| **fresh);
                counted.map(|(r, _)| (r / sigma) * (r / sigma)).sum()
            };
            rest.0.iter().zip(&log.sheet_sigma).map(of_axis).sum()
        };
        train += of(&wrench.prepared.train);
        test += of(&wrench.prepared.test);
        let last = accepted.map_or(0, |tested| tested.parameters);
        let earlier: usize = wrench.earlier.0.iter().map(|f| f.parameters.len()).sum();
        train += PRICE * (last + earlier) as f64;
    }
    let clock = &found.timed.clock;
    let believed = [
        clock.jitter.is_some(),
        clock.rate.is_some(),
        clock.offset_s.is_some(),
    ];
    train += PRICE * believed.iter().filter(|b| **b).count() as f64;
    (train, test)
}

/// What the actuator gains, and a bit more.
fn gain(found: &StageResults, more: (f64, f64)) -> (f64, f64) {
    let (train, test) = found.actuator.as_ref().map_or((0.0, 0.0), |actuator| {
        let nominal = actuator.search.nominal;
        let accepted = actuator.search.accepted.as_ref();
        accepted.map_or((0.0, 0.0), |c| (nominal.0 - c.train, nominal.1 - c.test))
    });
    (train + more.0, test + more.1)
}
