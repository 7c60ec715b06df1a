//! A pair of logs with what is believed of their clock.

use super::clock;
use super::engine::{ClockFinding, Pair, Question};
use crate::model::actuator::Reading;
use crate::model::clock::recover;
use crate::model::log::Log;
use crate::model::prediction::retimed::retimed;
use crate::model::prediction::signals::Signals;
use crate::model::{self, EffectModel, Model};
use crate::recording::Recording;
use std::collections::BTreeMap;

/// Pose and velocity of an imported log may be sampled this share of a cycle apart.
const SAMPLED_APART: f64 = 0.15;
/// Relative error of a clock that is of no consequence.
const RATE_TOLERANCE: f64 = 1e-3;

/// The logs, and how their clock is read.
pub(super) struct TimedLogs {
    /// The unmodelled error of the clock.
    pub clock: ClockFinding,
    /// The model; where the recorded velocity is the difference of poses, with these errors of the
    /// clock.
    pub model: Model,
    /// The logs as they were recorded.
    pub logs: Pair<Log>,
    /// The logs with poses at the instants of the wrenches and true velocities, where they differ.
    pub aligned: Option<Pair<Log>>,
    /// True durations of the cycles; empty where they are nominal.
    pub intervals: Pair<Vec<f64>>,
}

impl TimedLogs {
    /// With errors of the clock that are believed; without them, those that a velocity of its own
    /// shows.
    pub(super) fn new(
        model: &Model,
        recordings: &Pair<&Recording>,
        believed: Option<ClockFinding>,
        question: &Question<'_>,
    ) -> anyhow::Result<Self> {
        let signals = Pair {
            train: Signals::new(recordings.train)?,
            test: Signals::new(recordings.test)?,
        };
        let of = |signals: &Signals<'_>| Log::of(signals, &model.noise);
        let logs = Pair {
            train: of(&signals.train)?,
            test: of(&signals.test)?,
        };
        let clock = believed.unwrap_or_else(|| clock_stage(model, &logs, question));
        if logs.train.reading == Reading::AtEnd {
            return Ok(Self {
                intervals: intervals(model, &logs, &clock),
                model: model.clone(),
                aligned: None,
                clock,
                logs,
            });
        }
        let model = with_clock(model, &clock);
        let all = signals.map_both(|signals| model::prediction::intervals(&model, signals));
        let own = |log: &Log, all: &[f64]| {
            let own = all.iter().skip(log.first).take(log.len());
            own.copied().collect::<Vec<f64>>()
        };
        let intervals = Pair {
            train: own(&logs.train, &all.train),
            test: own(&logs.test, &all.test),
        };
        let train = retimed(&model, &signals.train, &all.train);
        let test = retimed(&model, &signals.test, &all.test);
        let aligned = match (train, test) {
            (Some(train), Some(test)) => Some(Pair {
                train: Log::of(&signals.train.with(&train), &model.noise)?,
                test: Log::of(&signals.test.with(&test), &model.noise)?,
            }),
            _ => None,
        };
        Ok(Self {
            clock,
            model,
            logs,
            aligned,
            intervals,
        })
    }

    /// The logs with poses at the instants of the wrenches.
    pub(super) fn aligned(&self) -> &Pair<Log> {
        self.aligned.as_ref().unwrap_or(&self.logs)
    }

    /// The model of logs whose poses are where they belong.
    pub(super) fn without_offset(&self) -> Model {
        let mut model = self.model.clone();
        model.effects.retain(|e| e.id != "clock_offset");
        model
    }
}

/// The model with errors of the clock.
fn with_clock(model: &Model, clock: &ClockFinding) -> Model {
    let mut with = model.clone();
    let mut add = |id: &str, name: &str, value: Option<f64>| {
        if let Some(value) = value {
            with.effects.push(EffectModel {
                id: id.to_owned(),
                parameters: BTreeMap::from([(name.to_owned(), value)]),
                ..EffectModel::default()
            });
        }
    };
    add("clock_jitter", "jitter_s", clock.jitter.map(|j| j.0));
    add("clock_rate", "rate_error", clock.rate.map(|r| r.0));
    add("clock_offset", "offset_s", clock.offset_s.map(|o| o.0));
    with
}

fn clock_stage(model: &Model, logs: &Pair<Log>, question: &Question<'_>) -> ClockFinding {
    let found = logs.map_both(|log| clock::test(model, log));
    let (train, test) = (found.train, found.test);
    let apart_s = SAMPLED_APART * logs.train.cycle_s;
    let jitters = train.jitters() && test.jitters() && question.tries(model, "clock_jitter");
    let rate = question.tries(model, "clock_rate");
    let offset = question.tries(model, "clock_offset");
    ClockFinding {
        jitter: jitters.then_some((train.jitter_s, (train.jitter_gain, test.jitter_gain))),
        rate: (rate && train.has_rate_error(RATE_TOLERANCE) && test.has_rate_error(RATE_TOLERANCE))
            .then_some(train.rate),
        offset_s: (offset && train.has_offset(apart_s) && test.has_offset(apart_s))
            .then_some(train.offset_s),
    }
}

/// True durations of the cycles; empty where they are nominal.
fn intervals(model: &Model, logs: &Pair<Log>, clock: &ClockFinding) -> Pair<Vec<f64>> {
    let known = model.effects.iter().find(|e| e.id == "clock_jitter");
    let known_s = known.and_then(|e| e.parameters.get("jitter_s")).copied();
    match clock.jitter.map(|j| j.0).or(known_s) {
        Some(jitter_s) => logs.map_both(|log| recover(model, log, jitter_s)),
        None => logs.map(|_| Vec::new()),
    }
}
