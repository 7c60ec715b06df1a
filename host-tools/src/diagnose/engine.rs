//! The order of a diagnosis: clock, actuator, reading of the sensor, model of the craft.
//!
//! Each stage works with what the stages before it have found: the wrench is predicted from the
//! motion that the accepted actuator simulates, in the cycles that the clock really took.

use super::actuator::{self, Cost, Search, Term};
use super::body::{self, BodyFit, BodySide};
use super::clock;
use super::finding::NoiseFloor;
use super::named;
use super::sampling::Sampling;
use super::wrench::{self, Fitted, Side, Tested};
use crate::compare::Phase;
use crate::model::clock::recover;
use crate::model::log::Log;
use crate::model::prediction::{Prediction, predict};
use crate::model::{Axis, Channel, Model};
use crate::recording::Recording;

/// Residual over noise up to which the simulated motion is trusted.
const TRUSTED: f64 = 1.08;
/// Pose and velocity of an imported log may be sampled this share of a cycle apart.
const SAMPLED_APART: f64 = 0.15;
/// Relative error of a clock that is of no consequence.
const RATE_TOLERANCE: f64 = 1e-3;

/// Something for the log of the fit and for unseen data.
#[derive(Clone, Debug)]
pub(crate) struct Pair<T> {
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
}

/// What the clock lacks.
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
    /// The actuator, where anything was commanded.
    pub actuator: Option<ActuatorFinding>,
    /// Sampling of the sensor.
    pub sampling: Pair<Sampling>,
    /// The reading.
    pub wrench: Option<WrenchFinding>,
    /// The model of the craft.
    pub body: Vec<BodyFit>,
    /// Noise floors on the log of the fit.
    pub noise: Vec<NoiseFloor>,
    /// Phases of the unseen log.
    pub phases: Vec<Phase>,
}

/// What the actuator lacks.
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

/// What the reading lacks.
pub(crate) struct WrenchFinding {
    /// The search.
    pub found: wrench::Found,
    /// Both logs, ready for further questions.
    pub sides: Pair<Side>,
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
    fn tries(&self, model: &Model, id: &str) -> bool {
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
    let logs = Pair {
        train: Log::new(model, recordings.train)?,
        test: Log::new(model, recordings.test)?,
    };
    let before = Pair {
        train: predict(model, recordings.train)?,
        test: predict(model, recordings.test)?,
    };
    progress(0.1, "looking at the clock");
    let clock = clock_stage(model, &logs, question);
    let intervals = intervals(model, &logs, &clock);
    progress(0.15, "simulating actuators");
    let mut costs = Pair {
        train: Cost::new(model, &logs.train, intervals.train.clone()),
        test: Cost::new(model, &logs.test, intervals.test.clone()),
    };
    let actuator = actuator_stage(model, &logs, &mut costs, clock.jitter.is_some(), question);
    progress(0.5, "explaining the wrench");
    let sigma = wrench::sheet_sigma(model);
    let mut sampling = logs.map(|log| Sampling::of(log, &sigma));
    let wrench = wrench_rounds(model, question, &mut |model, question| {
        wrench_stage(
            model,
            &logs,
            &costs,
            actuator.as_ref(),
            &mut sampling,
            &intervals,
            question,
        )
    });
    progress(0.9, "comparing the model of the craft");
    let body = body_stage(model, recordings, &before, question);
    let noise = noise_floors(model, &costs, wrench.as_ref());
    Ok(Stages {
        logs,
        before,
        clock,
        actuator,
        sampling,
        wrench,
        body,
        noise,
        phases: crate::compare::phases_of(model, recordings.test)?,
    })
}

/// Whether an effect is in the model already.
pub(crate) fn has(model: &Model, id: &str) -> bool {
    model.effects.iter().any(|e| e.id == id)
}

fn clock_stage(model: &Model, logs: &Pair<Log>, question: &Question<'_>) -> ClockFinding {
    let found = logs.map(|log| clock::test(model, log));
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
        Some(jitter_s) => logs.map(|log| recover(model, log, jitter_s)),
        None => logs.map(|_| Vec::new()),
    }
}

fn actuator_stage(
    model: &Model,
    logs: &Pair<Log>,
    costs: &mut Pair<Cost<'_>>,
    jitters: bool,
    question: &Question<'_>,
) -> Option<ActuatorFinding> {
    let moves = costs.train.active.contains(&true) && costs.test.active.contains(&true);
    if model.sensor.at_rest || !logs.train.is_commanded() || !logs.test.is_commanded() || !moves {
        return None;
    }
    let excluded = |id: &str| !question.tries(model, id);
    let ask = actuator::Ask {
        excluded: &excluded,
        forced: question.forced,
        alone: jitters,
    };
    let mut search = actuator::search(&costs.train, &costs.test, &ask);
    if search.quieten(&mut costs.train) | search.quieten(&mut costs.test) {
        search = actuator::search(&costs.train, &costs.test, &ask);
    }
    let terms: &[Term] = search.accepted.as_ref().map_or(&[], |c| &c.terms);
    let around = costs.map(|cost| cost.around(terms));
    let white = around.map(|cost| cost.white(terms));
    let level = |cost: &Cost<'_>, white: &[Vec<f64>; 6]| -> [f64; 6] {
        std::array::from_fn(|axis| rms(&white[axis]) * cost.sigma[axis] / cost.sheet_sigma[axis])
    };
    Some(ActuatorFinding {
        level: Pair {
            train: level(&costs.train, &white.train),
            test: level(&costs.test, &white.test),
        },
        white,
        count: costs.train.count(),
        intervals: actuator::intervals(&search, &around.train),
        search,
    })
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Most rounds of the search on the reading.
const ROUNDS: usize = 3;

/// Searches again beside what was found, as long as much is left: a delay or a gain acts on the
/// whole reading, with the effects that were found first.
fn wrench_rounds(
    model: &Model,
    question: &Question<'_>,
    search: &mut dyn FnMut(&Model, &Question<'_>) -> Option<WrenchFinding>,
) -> Option<WrenchFinding> {
    let mut finding = search(model, question)?;
    let mut known = model.clone();
    for _ in 1..ROUNDS {
        let Some(accepted) = finding.found.accepted.as_ref() else {
            break;
        };
        if question.only.is_some() || !finding.sides.train.has_much_left(accepted) {
            break;
        }
        known
            .effects
            .extend(accepted.effects.iter().map(named::model_of));
        let Some(mut next) = search(&known, question) else {
            break;
        };
        let rest = finding.sides.train.left(accepted);
        if !next
            .found
            .accepted
            .as_ref()
            .is_some_and(|t| wrench::is_much(t.gain, rest))
        {
            break;
        }
        next.earlier = finding.earlier;
        next.earlier.0.extend(accepted.effects.iter().cloned());
        next.earlier.1 += accepted.gain;
        next.found.ranked.extend(finding.found.ranked);
        next.found.rivals.extend(finding.found.rivals);
        finding = next;
    }
    Some(finding)
}

fn wrench_stage(
    model: &Model,
    logs: &Pair<Log>,
    costs: &Pair<Cost<'_>>,
    actuator: Option<&ActuatorFinding>,
    sampling: &mut Pair<Sampling>,
    intervals: &Pair<Vec<f64>>,
    question: &Question<'_>,
) -> Option<WrenchFinding> {
    let measured = |log: &Log| log.wrench.iter().flatten().any(|v| *v != 0.0);
    if !measured(&logs.train) || !measured(&logs.test) {
        return None;
    }
    let terms: &[Term] = actuator
        .and_then(|a| a.search.accepted.as_ref())
        .map_or(&[], |c| &c.terms);
    let trusted = actuator.is_some_and(|a| {
        let chi2 = a
            .search
            .accepted
            .as_ref()
            .map_or(a.search.nominal.0, |c| c.train);
        (chi2 / a.count.max(1) as f64).sqrt() < TRUSTED
    });
    let side = |log: &Log, cost: &Cost<'_>, sampling: &mut Sampling, intervals: &[f64]| {
        let scene = wrench::scene(model, log, cost, terms, trusted, intervals);
        Side::new(model, log, scene, sampling)
    };
    let (train, test) = rayon::join(
        || {
            side(
                &logs.train,
                &costs.train,
                &mut sampling.train,
                &intervals.train,
            )
        },
        || side(&logs.test, &costs.test, &mut sampling.test, &intervals.test),
    );
    let sides = Pair { train, test };
    let finished =
        |tested: &Tested| super::structure::left(&sides, Some(tested), 0.0).is_finished();
    let excluded =
        |id: &str| !question.tries(model, id) || (is_shape(id) && question.only.is_none());
    let found = wrench::search(
        &sides.train,
        &sides.test,
        &excluded,
        &finished,
        question.forced,
    );
    Some(WrenchFinding {
        found,
        sides,
        earlier: (Vec::new(), 0.0),
    })
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
    let train = BodySide::new(model, recordings.train, &before.train);
    let test = BodySide::new(model, recordings.test, &before.test);
    match (train, test) {
        (Some(train), Some(test)) => {
            body::search(model, &train, &test, &|id| !question.tries(model, id))
        }
        _ => Vec::new(),
    }
}

fn noise_floors(
    model: &Model,
    costs: &Pair<Cost<'_>>,
    wrench: Option<&WrenchFinding>,
) -> Vec<NoiseFloor> {
    let mut all = Vec::new();
    for axis in Axis::ALL
        .into_iter()
        .filter(|a| costs.train.active[a.index()])
    {
        all.push(NoiseFloor {
            channel: Channel::ExecutedVelocity,
            axis,
            measured: costs.train.sigma[axis.index()],
            data_sheet: costs.train.sheet_sigma[axis.index()],
        });
    }
    let sheet = wrench::sheet_sigma(model);
    for axis in Axis::ALL {
        if let Some(found) = wrench {
            all.push(NoiseFloor {
                channel: Channel::Wrench,
                axis,
                measured: found.sides.train.colour[axis.index()].level,
                data_sheet: sheet[axis.index()],
            });
        }
    }
    all
}
