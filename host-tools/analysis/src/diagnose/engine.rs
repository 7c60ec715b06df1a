//! The order of a diagnosis: clock, actuator, reading of the sensor, model of the spacecraft.
//!
//! Each stage works with what the stages before it have found: the wrench is predicted from the
//! motion that the accepted actuator simulates, in the cycles that the clock really took.

use super::actuator::Search;
use super::body::{self, BodyRegression, BodySearch};
use super::clock::Jitter;
use super::finding::NoiseFloor;
use super::logs::Logs;
use super::question::Question;
use super::rivals::{self, ClockRival};
use super::sampling::Sampling;
use super::wrench_finding::WrenchFinding;
use crate::compare::Phase;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::log::Log;
use softdock_physics::model::prediction::{Prediction, predict};

/// The unmodelled error of the clock.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ClockFinding {
    /// Standard deviation of the duration of a cycle, s, and the gain in χ² over all logs.
    pub jitter: Option<Jitter>,
    /// Relative error, with its deviation.
    pub rate: Option<(f64, f64)>,
    /// Offset of the pose, s, with its deviation.
    pub offset_s: Option<(f64, f64)>,
}

/// Everything that the stages found.
pub(crate) struct Stages {
    /// The logs.
    pub logs: Logs<Log>,
    /// Predictions with the model as given.
    pub before: Logs<Prediction>,
    /// The clock.
    pub clock: ClockFinding,
    /// Errors of the clock that compete with stages of the actuator.
    pub clock_rivals: Vec<ClockRival>,
    /// The actuator, where anything was commanded.
    pub actuator: Option<ActuatorFinding>,
    /// Sampling of the sensor.
    pub sampling: Logs<Sampling>,
    /// The reading.
    pub wrench: Option<WrenchFinding>,
    /// The model of the spacecraft.
    pub body: BodySearch,
    /// Noise floors on the log of the fit.
    pub noise: Vec<NoiseFloor>,
    /// Nominal parameters beside what the reading says, by name: value and deviation, and by how many tolerances it is off.
    pub nominal: Vec<(String, f64, f64, f64)>,
    /// Phases of the log that is drawn.
    pub phases: Vec<Phase>,
}

/// The unmodelled dynamics of the actuator.
pub(crate) struct ActuatorFinding {
    /// The search.
    pub search: Search,
    /// Its largest evidence.
    pub strongest: Option<f64>,
    /// Residuals of each log and axis in units of its noise, with what is accepted.
    pub white: Vec<[Vec<f64>; 6]>,
    /// Level of each log and axis over the data sheet's noise.
    pub level: Vec<[f64; 6]>,
    /// Number of velocities that are judged.
    pub count: usize,
    /// Ends of the 95 % interval of each parameter of each term.
    pub intervals: Vec<Vec<[f64; 2]>>,
    /// Ids of effects about which the logs disagree.
    pub disagreeing: Vec<&'static str>,
}

/// Runs all stages. `progress` is told a share and what is being done.
pub(crate) fn run(
    model: &Model,
    recordings: &Logs<&Recording>,
    question: &Question<'_>,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Stages> {
    progress(0.02, "reading the logs");
    let before = predict_all(model, recordings)?;
    progress(0.1, "looking at the clock");
    let (results, rivals) = rivals::run_stages(model, recordings, question, progress)?;
    progress(0.9, "comparing the model of the spacecraft");
    let body = body_stage(model, recordings, &before, question);
    Ok(Stages {
        logs: results.timed.logs,
        before,
        clock: results.timed.clock,
        clock_rivals: rivals,
        actuator: results.actuator,
        sampling: results.sampling,
        wrench: results.wrench,
        body,
        noise: results.noise,
        nominal: results.nominal,
        phases: crate::compare::phases_of(model, recordings.shown())?,
    })
}

/// Predicts all logs.
pub(super) fn predict_all(
    model: &Model,
    recordings: &Logs<&Recording>,
) -> anyhow::Result<Logs<Prediction>> {
    recordings
        .map_at_once(|recording| predict(model, recording))
        .whole()
}

/// Whether an effect is in the model already.
pub(crate) fn has(model: &Model, id: &str) -> bool {
    model.effects.iter().any(|e| e.id == id)
}

/// The effect of one amount that is of the same kind as one which may be simpler.
pub(super) fn simplest(model: &Model, id: &str) -> Option<&'static str> {
    let effect = LoadEffect::find(model, id).filter(|effect| effect.may_be_simpler())?;
    let kind = effect.effect.kind?;
    let mut alike = LoadEffect::all(model).filter(|other| other.effect.kind == Some(kind));
    let simple = alike.find(|other| other.coefficients.len() == 1 && !is_shape(other.id))?;
    Some(simple.id)
}

/// Whether a catalogue entry is a curve that fits many mechanisms, and therefore no name.
pub(crate) fn is_shape(id: &str) -> bool {
    softdock_physics::effects::by_id(id)
        .is_some_and(|e| e.naming == softdock_physics::effects::Naming::Shape)
}

fn body_stage(
    model: &Model,
    recordings: &Logs<&Recording>,
    before: &Logs<Prediction>,
    question: &Question<'_>,
) -> BodySearch {
    let both = recordings.all.iter().zip(&before.all);
    let regressions: Vec<BodyRegression> = both
        .filter_map(|(recording, before)| BodyRegression::new(model, recording, before))
        .collect();
    if regressions.len() < recordings.all.len() {
        return BodySearch::default();
    }
    let regressions = Logs {
        all: regressions,
        fitted: recordings.fitted,
    };
    body::search(model, &regressions, &|id| !question.tries(model, id))
}
