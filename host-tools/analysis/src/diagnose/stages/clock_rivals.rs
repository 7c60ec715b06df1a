//! Errors of the clock in logs whose velocity was not measured.
//!
//! There the recorded velocity is the difference of two poses, so an error of the clock looks like one of the actuator: poses
//! that are taken late like a delay, cycles that last longer like a gain. The sensor tells them apart, as its readings are those
//! of the true motion, which is neither late nor faster. So both hypotheses are followed to the end, and the one that leaves less
//! of velocity and wrench is believed. If neither leaves clearly less they are a tie.

use super::results::StageResults;
use crate::diagnose::actuator::ActuatorFinding;
use crate::diagnose::clock::timed_logs::TimedLogs;
use crate::diagnose::clock::{ClockFinding, Jitter, PoseScatter};
use crate::diagnose::evidence::TOLD_APART;
use crate::diagnose::logs::Logs;
use crate::diagnose::question::Question;
use crate::diagnose::wrench::subtract;
use softdock_actuator::Reading;
use softdock_io::recording::Recording;
use softdock_physics::effects::body::clock_jitter::{self, Scatter};
use softdock_physics::effects::body::{clock_offset, clock_rate};
use softdock_physics::model::Model;
use softdock_physics::model::stage::Stage;
use softdock_statistics::DEVIATIONS_95;

/// Price of a parameter, in χ².
const PRICE: f64 = 10.0;
/// Share of the excess over the noise that recovered instants have to remove to be believed.
const TAKEN: f64 = 0.5;

/// An error of the clock, compared with the actuator stage that it looks like.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClockRival {
    /// Id of the error of the clock.
    pub id: &'static str,
    /// Id of the stage.
    pub of: &'static str,
    /// By how much χ² over all logs is less with the error of the clock.
    pub better: f64,
    /// The error of the clock is believed, and not the stage.
    pub believed: bool,
    /// Fall of χ² on each log by the believed one.
    pub gain: Vec<f64>,
}

impl ClockRival {
    /// Whether the logs prefer neither.
    pub(crate) fn is_tie(&self) -> bool {
        self.better.abs() < TOLD_APART
    }
}

/// Runs the stages on the logs as they are, and with errors of their clock. Returns the results that are believed, and the
/// comparisons.
pub(crate) fn run_stages(
    model: &Model,
    recordings: &Logs<&Recording>,
    question: &Question<'_>,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<(StageResults, Vec<ClockRival>)> {
    let with = |clock: Option<ClockFinding>| -> anyhow::Result<StageResults> {
        let timed = TimedLogs::new(model, recordings, clock, question)?;
        Ok(StageResults::of(timed, question, progress))
    };
    let mut best = with(None)?;
    if best.timed.logs.all[0].reading == Reading::AtEnd || model.sensor.at_rest {
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
        let better = left(&best) - left(&other);
        let believed = question.asks_for(id) || better > TOLD_APART;
        let gain = gain(&best, if believed { better } else { 0.0 });
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

/// Jitter, if all logs show it.
fn jitter(found: &StageResults, model: &Model, question: &Question<'_>) -> Option<Jitter> {
    // Behind a low-pass nothing differs from cycle to cycle: second differences there are those of the motion.
    let shown =
        model.sensor.filter.is_none() && found.scatter.iter().all(PoseScatter::is_significant);
    let gain = found.scatter.iter().map(|s| s.gain).sum();
    let first = found.scatter.first()?;
    let jitter = Jitter {
        scatter: Scatter {
            jitter_s: first.scatter_s,
            of_intervals: false,
        },
        sigma_s: first.sigma_s,
        gain,
    };
    (shown && question.tries(model, clock_jitter::EFFECT.id)).then_some(jitter)
}

/// Whether recovered instants explain most of what was left of the velocities, on every log.
fn takes_most(before: &StageResults, after: &StageResults) -> bool {
    let excess = |found: &StageResults| -> Option<Vec<f64>> {
        let of = |axes: &[f64; 6]| axes.iter().map(|l| (l * l - 1.0).max(0.0)).sum::<f64>();
        Some(found.actuator.as_ref()?.level.iter().map(of).collect())
    };
    match (excess(before), excess(after)) {
        (Some(before), Some(after)) => before.iter().zip(after).all(|(b, a)| a < (1.0 - TAKEN) * b),
        _ => false,
    }
}

/// Errors of the clock that look like accepted stages: id of the error, id of the stage, and the error.
fn alternatives(
    found: &StageResults,
    model: &Model,
    question: &Question<'_>,
) -> Vec<(&'static str, &'static str, ClockFinding)> {
    let mut all = Vec::new();
    let Some(actuator) = &found.actuator else {
        return all;
    };
    let jitter = found.timed.clock.jitter;
    let reached = actuator.search.reached();
    let earlier = found
        .common_delay
        .filter(|l| question.asks_for(clock_offset::EFFECT.id) || l.chi2 + TOLD_APART < reached);
    let late_s = of_all_axes(actuator, Stage::Delay).or(earlier.map(|l| l.late_s));
    // Without a sensor, a motion that comes late is called a delay and one of another size a gain, as the plainer explanations.
    // Only a motion that comes before its command has to be the clock.
    let feels = found.wrench.is_some();
    let differs =
        |late_s: &(f64, f64)| feels || late_s.0 < 0.0 || question.asks_for(clock_offset::EFFECT.id);
    let tried = question.tries(model, clock_offset::EFFECT.id);
    if let Some(late_s) = late_s.filter(differs).filter(|_| tried) {
        let clock = ClockFinding {
            jitter,
            offset_s: Some(late_s),
            ..ClockFinding::default()
        };
        all.push((clock_offset::EFFECT.id, Stage::Delay.id(), clock));
    }
    let rate = of_all_axes(actuator, Stage::Gain).or(question
        .asks_for(clock_rate::EFFECT.id)
        .then_some(found.proportion));
    let of_a_clock = |rate: &(f64, f64)| clock_rate::EFFECT.parameters[0].is_plausible(rate.0);
    let may_be_clock = feels || question.asks_for(clock_rate::EFFECT.id);
    let tried = may_be_clock && question.tries(model, clock_rate::EFFECT.id);
    if let Some(rate) = rate.filter(of_a_clock).filter(|_| tried) {
        let clock = ClockFinding {
            jitter,
            rate: Some(rate),
            ..ClockFinding::default()
        };
        all.push((clock_rate::EFFECT.id, Stage::Gain.id(), clock));
    }
    all
}

/// The fitted value of a stage that acts on all moving axes, and its standard deviation; `None` if there is none.
fn of_all_axes(found: &ActuatorFinding, stage: Stage) -> Option<(f64, f64)> {
    let white = found.white.first()?;
    let moves = white.each_ref().map(|series| !series.is_empty());
    let accepted = found.search.accepted.as_ref()?;
    let mut terms = accepted.terms.iter().zip(&found.intervals);
    let (term, intervals) = terms.find(|(term, _)| term.stage == stage && term.axes == moves)?;
    let [low, high] = *intervals.first()?;
    Some((*term.values.first()?, (high - low) / (2.0 * DEVIATIONS_95)))
}

/// Σ of squares of what is left of velocities and wrench over all logs, in units of the data sheet's
/// noise, with a price for each parameter.
fn left(found: &StageResults) -> f64 {
    let mut left = 0.0;
    if let Some(actuator) = &found.actuator {
        let logs = found.timed.logs.all.iter();
        left += logs
            .zip(&actuator.level)
            .map(|(log, level)| {
                level
                    .iter()
                    .map(|l| l * l * log.cycle_count() as f64)
                    .sum::<f64>()
            })
            .sum::<f64>();
        let accepted = actuator.search.accepted.as_ref();
        left += PRICE * accepted.map_or(0, |c| c.parameters()) as f64;
    }
    if let Some(wrench) = &found.wrench {
        let accepted = wrench.found.accepted.as_ref();
        for log in &wrench.prepared.logs {
            let mut rest = log.residual.clone();
            if let Some(tested) = accepted {
                subtract(&mut rest, &tested.contribution(&log.scene), 1.0);
            }
            let of_axis = |(series, sigma): (&Vec<f64>, &f64)| -> f64 {
                let counted = series.iter().zip(&log.fresh).filter(|(_, fresh)| **fresh);
                counted.map(|(r, _)| (r / sigma) * (r / sigma)).sum()
            };
            left += rest
                .0
                .iter()
                .zip(&log.sheet_sigma)
                .map(of_axis)
                .sum::<f64>();
        }
        let last = accepted.map_or(0, |tested| tested.parameters);
        let earlier: usize = wrench.earlier.0.iter().map(|f| f.parameters.len()).sum();
        left += PRICE * (last + earlier) as f64;
    }
    let clock = &found.timed.clock;
    let believed = [
        clock.jitter.is_some(),
        clock.rate.is_some(),
        clock.offset_s.is_some(),
    ];
    left + PRICE * believed.iter().filter(|b| **b).count() as f64
}

/// Fall of χ² on each log by the actuator, with `more` shared equally by the logs.
fn gain(found: &StageResults, more: f64) -> Vec<f64> {
    let count = found.timed.logs.all.len();
    let own = found.actuator.as_ref().and_then(|actuator| {
        let accepted = actuator.search.accepted.as_ref()?;
        let both = actuator.search.nominal.each.iter().zip(&accepted.each);
        Some(
            both.map(|(nominal, own)| nominal - own)
                .collect::<Vec<f64>>(),
        )
    });
    let own = own.unwrap_or_else(|| vec![0.0; count]);
    own.into_iter()
        .map(|gain| gain + more / count as f64)
        .collect()
}
