//! The order of a diagnosis: clock, actuator, reading of the sensor, model of the spacecraft.
//!
//! Each stage works with what the stages before it have found: the wrench is predicted from the
//! motion that the accepted actuator simulates, in the cycles that the clock really took.

use super::actuator::Search;
use super::body::{self, BodyFit, BodyRegression};
use super::finding::NoiseFloor;
use super::rivals::{self, ClockRival};
use super::sampling::Sampling;
use super::wrench::{self, Fitted, PreparedLog};
use crate::compare::Phase;
use crate::model::Model;
use crate::model::log::Log;
use crate::model::prediction::{Prediction, predict};
use crate::recording::Recording;

/// Something for the log of the fit and for unseen data.
#[derive(Clone, Debug)]
pub struct Pair<T> {
    /// Of the fit.
    pub train: T,
    /// Unseen.
    pub test: T,
}

impl<T> Pair<T> {
    pub(super) fn map<U>(&self, mut of: impl FnMut(&T) -> U) -> Pair<U> {
        Pair {
            train: of(&self.train),
            test: of(&self.test),
        }
    }

    /// The same for both at once.
    pub(super) fn map_both<U: Send>(&self, of: impl Fn(&T) -> U + Sync) -> Pair<U>
    where
        T: Sync,
    {
        let (train, test) = rayon::join(|| of(&self.train), || of(&self.test));
        Pair { train, test }
    }
}

/// The unmodelled error of the clock.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ClockFinding {
    /// Standard deviation of the duration of a cycle, s, and the gain in χ² on both logs.
    pub jitter: Option<(f64, (f64, f64))>,
    /// Relative error, with its deviation.
    pub rate: Option<(f64, f64)>,
    /// Offset of the pose, s, with its deviation.
    pub offset_s: Option<(f64, f64)>,
}

/// Everything that the stages found.
pub(crate) struct Stages {
    /// The logs.
    pub logs: Pair<Log>,
    /// Predictions with the model as given.
    pub before: Pair<Prediction>,
    /// The clock.
    pub clock: ClockFinding,
    /// Errors of the clock that compete with stages of the actuator.
    pub clock_rivals: Vec<ClockRival>,
    /// The actuator, where anything was commanded.
    pub actuator: Option<ActuatorFinding>,
    /// Sampling of the sensor.
    pub sampling: Pair<Sampling>,
    /// The reading.
    pub wrench: Option<WrenchFinding>,
    /// The model of the spacecraft.
    pub body: Vec<BodyFit>,
    /// Noise floors on the log of the fit.
    pub noise: Vec<NoiseFloor>,
    /// Phases of the unseen log.
    pub phases: Vec<Phase>,
}

/// The unmodelled dynamics of the actuator.
pub(crate) struct ActuatorFinding {
    /// The search.
    pub search: Search,
    /// Residuals of each axis in units of its noise, with what is accepted.
    pub white: Pair<[Vec<f64>; 6]>,
    /// Level of each axis over the data sheet's noise.
    pub level: Pair<[f64; 6]>,
    /// Number of velocities that are judged.
    pub count: usize,
    /// Ends of the 95 % interval of each parameter of each term.
    pub intervals: Vec<Vec<[f64; 2]>>,
}

/// The unmodelled wrench.
pub(crate) struct WrenchFinding {
    /// The search.
    pub found: wrench::Found,
    /// Both logs, ready for further questions.
    pub prepared: Pair<PreparedLog>,
    /// What rounds before this one accepted, and by how much χ² fell with it.
    pub earlier: (Vec<Fitted>, f64),
}

/// What is asked of the stages.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Question<'a> {
    /// Only this effect is tried.
    pub only: Option<&'a str>,
    /// Take the best fit of it although it is not significant, or does not help on unseen data.
    pub forced: bool,
}

impl Question<'_> {
    /// Whether an effect is tried for a model.
    pub(super) fn tries(&self, model: &Model, id: &str) -> bool {
        !has(model, id) && self.only.is_none_or(|only| only == id)
    }
}

/// Runs all stages. `progress` is told a share and what is being done.
pub(crate) fn run(
    model: &Model,
    recordings: &Pair<&Recording>,
    question: &Question<'_>,
    progress: &dyn Fn(f64, &str),
) -> anyhow::Result<Stages> {
    progress(0.02, "reading the logs");
    let before = predict_both(model, recordings)?;
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
        phases: crate::compare::phases_of(model, recordings.test)?,
    })
}

/// Predicts both logs.
pub(super) fn predict_both(
    model: &Model,
    recordings: &Pair<&Recording>,
) -> anyhow::Result<Pair<Prediction>> {
    let both = recordings.map_both(|recording| predict(model, recording));
    Ok(Pair {
        train: both.train?,
        test: both.test?,
    })
}

/// Whether an effect is in the model already.
pub(crate) fn has(model: &Model, id: &str) -> bool {
    model.effects.iter().any(|e| e.id == id)
}

/// Whether a catalogue entry is a curve that fits many mechanisms, and therefore no name.
pub(crate) fn is_shape(id: &str) -> bool {
    softdock_control::effects::by_id(id)
        .is_some_and(|e| e.naming == softdock_control::effects::Naming::Shape)
}

fn body_stage(
    model: &Model,
    recordings: &Pair<&Recording>,
    before: &Pair<Prediction>,
    question: &Question<'_>,
) -> Vec<BodyFit> {
    let (train, test) = rayon::join(
        || BodyRegression::new(model, recordings.train, &before.train),
        || BodyRegression::new(model, recordings.test, &before.test),
    );
    match (train, test) {
        (Some(train), Some(test)) => {
            body::search(model, &train, &test, &|id| !question.tries(model, id))
        }
        _ => Vec::new(),
    }
}
