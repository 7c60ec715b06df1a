//! The logs, read with the errors of their clock that are assumed.

use super::{Clock, ClockFinding};
use crate::diagnose::logs::Logs;
use crate::diagnose::question::Question;
use softdock_actuator::Reading;
use softdock_io::recording::Recording;
use softdock_physics::effects::body::clock_jitter::{self, Scatter};
use softdock_physics::effects::body::{clock_offset, clock_rate};
use softdock_physics::model::clock::recover;
use softdock_physics::model::log::Log;
use softdock_physics::model::prediction::retimed::retimed;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::{self, EffectModel, Model};
use std::collections::BTreeMap;

/// Pose and velocity of an imported log may be sampled this share of a cycle apart without being called wrong.
const SAMPLED_APART: f64 = 0.15;
/// Relative error of a clock that is of no consequence.
const RATE_TOLERANCE: f64 = 1e-3;

/// The logs, and the durations of their cycles.
pub(crate) struct TimedLogs {
    /// The unmodelled error of the clock that is assumed.
    pub clock: ClockFinding,
    /// The model. Where the recorded velocity is the difference of poses, it includes these errors of the clock.
    pub model: Model,
    /// The logs as they were recorded.
    pub logs: Logs<Log>,
    /// The logs with poses at the instants of the wrenches and with true velocities; `None` if they are as recorded.
    pub aligned: Option<Logs<Log>>,
    /// True durations of the cycles of each log, s; empty where they are nominal.
    pub intervals: Logs<Vec<f64>>,
}

impl TimedLogs {
    /// Reads the logs with errors of the clock that are `believed`. Without these, with the errors that logs with a measured
    /// velocity show.
    pub(crate) fn new(
        model: &Model,
        recordings: &Logs<&Recording>,
        believed: Option<ClockFinding>,
        question: &Question<'_>,
    ) -> anyhow::Result<Self> {
        let signals = recordings
            .map(|recording| Signals::new(recording))
            .transpose()?;
        let logs = signals.map(|signals| Log::of(signals, model)).transpose()?;
        let clock = believed.unwrap_or_else(|| clock_stage(model, &logs, question));
        if logs.all[0].reading == Reading::AtEnd {
            return Ok(Self {
                intervals: intervals(model, &logs, &clock),
                model: model.clone(),
                aligned: None,
                clock,
                logs,
            });
        }
        let model = with_clock(model, &clock);
        let all = signals.map_at_once(|signals| model::prediction::intervals(&model, signals));
        let own = |(log, all): (&Log, &Vec<f64>)| -> Vec<f64> {
            let own = all.iter().skip(log.first).take(log.cycle_count());
            own.copied().collect()
        };
        let intervals = Logs {
            all: logs.all.iter().zip(&all.all).map(own).collect(),
            fitted: logs.fitted,
        };
        Ok(Self {
            aligned: aligned(&model, &signals, &all)?,
            clock,
            model,
            logs,
            intervals,
        })
    }

    /// The logs with poses at the instants of the wrenches.
    pub(crate) fn aligned(&self) -> &Logs<Log> {
        self.aligned.as_ref().unwrap_or(&self.logs)
    }

    /// The model for logs whose poses are at the right instants.
    pub(crate) fn without_offset(&self) -> Model {
        let mut model = self.model.clone();
        model.effects.retain(|e| e.id != clock_offset::EFFECT.id);
        model
    }
}

/// The logs with poses at the instants of the wrenches and with true velocities; `None` where these are as recorded. `durations`
/// are those of all cycles of each recording, s.
fn aligned(
    model: &Model,
    signals: &Logs<Signals<'_>>,
    durations: &Logs<Vec<f64>>,
) -> anyhow::Result<Option<Logs<Log>>> {
    let one = |(signals, durations): (&Signals<'_>, &Vec<f64>)| {
        let cycles = retimed(model, signals, durations)?;
        Some(Log::of(&signals.with_cycles(&cycles), model))
    };
    let all = signals.all.iter().zip(&durations.all).map(one);
    let all: Option<Vec<anyhow::Result<Log>>> = all.collect();
    let fitted = signals.fitted;
    all.map(|all| Logs { all, fitted }.transpose()).transpose()
}

/// The model with the errors of the clock as effects.
fn with_clock(model: &Model, clock: &ClockFinding) -> Model {
    let mut with = model.clone();
    let mut add = |id: &str, parameters: Option<BTreeMap<String, f64>>| {
        if let Some(parameters) = parameters {
            with.effects.push(EffectModel {
                id: id.to_owned(),
                parameters,
                ..EffectModel::default()
            });
        }
    };
    let one = |name: &str, value: f64| BTreeMap::from([(name.to_owned(), value)]);
    add(
        clock_jitter::EFFECT.id,
        clock.jitter.map(|j| j.scatter.parameters()),
    );
    add(
        clock_rate::EFFECT.id,
        clock.rate.map(|r| one("rate_error", r.0)),
    );
    add(
        clock_offset::EFFECT.id,
        clock.offset_s.map(|o| one("offset_s", o.0)),
    );
    with
}

fn clock_stage(model: &Model, logs: &Logs<Log>, question: &Question<'_>) -> ClockFinding {
    let found = logs.map_at_once(|log| super::test(model, log)).all;
    let apart_s = SAMPLED_APART * logs.all[0].cycle_s;
    let tries = |id: &str| question.tries(model, id);
    let train = Clock::common(&found[..logs.fitted]);
    // An error counts if all logs that determine it show it, the logs of the fit among them.
    let each = |known: &dyn Fn(&Clock) -> f64, of: &dyn Fn(&Clock) -> bool| {
        let mut said = found.iter().filter(|clock| known(clock) > 0.0);
        known(&train) > 0.0 && said.all(of)
    };
    let gain: f64 = found.iter().map(|clock| clock.jitter_gain).sum();
    // Scatter from cycle to cycle does not pass a low-pass, so a filtered log does not show it.
    let filtered = model.sensor.filter.is_some();
    let jitters = tries(clock_jitter::EFFECT.id) && !filtered && gain > super::SIGNIFICANT;
    ClockFinding {
        jitter: jitters.then(|| train.jitter(gain)),
        rate: (tries(clock_rate::EFFECT.id)
            && each(&|c| c.rate.1, &|c| c.has_rate_error(RATE_TOLERANCE)))
        .then_some(train.rate),
        offset_s: (tries(clock_offset::EFFECT.id)
            && each(&|c| c.offset_s.1, &|c| c.has_offset(apart_s)))
        .then_some(train.offset_s),
    }
}

/// True durations of the cycles of each log, s; empty where they are nominal.
fn intervals(model: &Model, logs: &Logs<Log>, clock: &ClockFinding) -> Logs<Vec<f64>> {
    let known = model
        .effects
        .iter()
        .find(|e| e.id == clock_jitter::EFFECT.id);
    let known = known.and_then(|e| Scatter::of(&e.parameters));
    match clock.jitter.map(|j| j.scatter).or(known) {
        Some(jitter) => logs.map_at_once(|log| recover(model, log, &jitter)),
        None => logs.map(|_| Vec::new()),
    }
}
