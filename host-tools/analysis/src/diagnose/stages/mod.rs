//! The stages of a diagnosis in their order: clock, actuator, reading of the sensor, model of the spacecraft.
//!
//! Each stage uses the results of the stages before it: the wrench is predicted from the motion that the accepted actuator
//! simulates, with the true durations of the cycles.

pub(crate) mod accepted;
pub(crate) mod clock_rivals;
pub(crate) mod results;

use super::actuator::ActuatorFinding;
use super::body::{self, BodyRegression, BodySearch};
use super::clock::ClockFinding;
use super::finding::NoiseFloor;
use super::logs::Logs;
use super::question::Question;
use super::wrench::NominalEstimate;
use super::wrench::finding::WrenchFinding;
use super::wrench::sampling::Sampling;
use crate::compare::Phase;
use clock_rivals::ClockRival;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::log::Log;
use softdock_physics::model::prediction::{Prediction, predict};

/// The results of all stages.
pub(crate) struct Stages {
    /// The logs.
    pub logs: Logs<Log>,
    /// Predictions with the model as given.
    pub before: Logs<Prediction>,
    /// The clock.
    pub clock: ClockFinding,
    /// Errors of the clock, each compared with the actuator stage that it looks like.
    pub clock_rivals: Vec<ClockRival>,
    /// The actuator; `None` where nothing was commanded.
    pub actuator: Option<ActuatorFinding>,
    /// Sampling of the sensor.
    pub sampling: Logs<Sampling>,
    /// The effects on the reading; `None` where there is none to search.
    pub wrench: Option<WrenchFinding>,
    /// The model of the spacecraft.
    pub body: BodySearch,
    /// Noise floors on the first log of the fit.
    pub noise: Vec<NoiseFloor>,
    /// Nominal parameters beside the effects on the reading.
    pub nominal: Vec<NominalEstimate>,
    /// Phases of the log that is drawn.
    pub phases: Vec<Phase>,
}

/// Runs all stages. `progress` is called with the share that is done and the present step.
pub(crate) fn run(
    model: &Model,
    recordings: &Logs<&Recording>,
    question: &Question<'_>,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Stages> {
    progress(0.02, "reading the logs");
    let before = predict_all(model, recordings)?;
    progress(0.1, "looking at the clock");
    let (results, rivals) = clock_rivals::run_stages(model, recordings, question, progress)?;
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
pub(crate) fn predict_all(
    model: &Model,
    recordings: &Logs<&Recording>,
) -> anyhow::Result<Logs<Prediction>> {
    recordings
        .map_at_once(|recording| predict(model, recording))
        .transpose()
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
