//! What a pair of logs shows, with what is believed of their clock.

use super::actuator::{self, Cost, Term};
use super::clock::{self, CommonDelay, Scatter};
use super::engine::{ActuatorFinding, Pair, Question, WrenchFinding, is_shape};
use super::finding::NoiseFloor;
use super::named;
use super::sampling::Sampling;
use super::structure;
use super::timed_logs::TimedLogs;
use super::wrench::{self, PreparedLog, Tested};
use crate::model::log::Log;
use crate::model::{Axis, Channel, Model};

/// Residual over noise up to which the simulated motion is trusted.
const TRUSTED: f64 = 1.08;

/// What was found in logs with one belief about their clock.
pub(super) struct StageResults {
    /// The logs, and what is believed of their clock.
    pub timed: TimedLogs,
    /// The actuator, where anything was commanded.
    pub actuator: Option<ActuatorFinding>,
    /// Scatter of the poses' instants that is left, in logs without a velocity of their own.
    pub scatter: Pair<Scatter>,
    /// A common delay of all velocities; None where nothing speaks for it.
    pub common_delay: Option<CommonDelay>,
    /// A common factor of all velocities, less 1, with its deviation.
    pub proportion: (f64, f64),
    /// Sampling of the sensor.
    pub sampling: Pair<Sampling>,
    /// The reading.
    pub wrench: Option<WrenchFinding>,
    /// Noise floors on the log of the fit.
    pub noise: Vec<NoiseFloor>,
}

impl StageResults {
    /// Searches actuator and reading.
    pub(super) fn of(
        timed: TimedLogs,
        question: &Question<'_>,
        progress: &dyn Fn(f64, &str),
    ) -> Self {
        let (model, logs, intervals) = (&timed.model, &timed.logs, &timed.intervals);
        progress(0.15, "simulating actuators");
        let mut costs = Pair {
            train: Cost::new(model, &logs.train, intervals.train.clone()),
            test: Cost::new(model, &logs.test, intervals.test.clone()),
        };
        let jitters = timed.clock.jitter.is_some();
        let actuator = actuator_stage(model, logs, &mut costs, jitters, question);
        let terms: &[Term] = actuator
            .as_ref()
            .and_then(|a| a.search.accepted.as_ref())
            .map_or(&[], |c| &c.terms);
        let scatter = costs.map(|cost| clock::scatter(cost, terms));
        let common_delay = clock::common_delay(&costs.train, &costs.test);
        let proportion = clock::proportion(&costs.train);
        progress(0.5, "explaining the wrench");
        let sigma = wrench::sheet_sigma(model);
        let mut sampling = logs.map(|log| Sampling::of(log, &sigma));
        let aligned = timed.aligned();
        let plain = timed.without_offset();
        let moved = match &timed.aligned {
            // The actuator as it really moves the tool, not as late poses show it.
            Some(aligned) => Pair {
                train: Cost::new(&plain, &aligned.train, intervals.train.clone()),
                test: Cost::new(&plain, &aligned.test, intervals.test.clone()),
            },
            None => costs.clone(),
        };
        let wrench = wrench_rounds(model, question, &mut |model, question| {
            let motion = Motion {
                logs: aligned,
                costs: &moved,
                intervals,
                actuator: actuator.as_ref(),
            };
            wrench_stage(model, &motion, &mut sampling, question)
        });
        let noise = noise_floors(model, &costs, wrench.as_ref());
        Self {
            actuator,
            scatter,
            common_delay,
            proportion,
            sampling,
            wrench,
            noise,
            timed,
        }
    }
}

/// How the tool moves, for the search on the reading.
struct Motion<'a> {
    logs: &'a Pair<Log>,
    costs: &'a Pair<Cost<'a>>,
    intervals: &'a Pair<Vec<f64>>,
    actuator: Option<&'a ActuatorFinding>,
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
        if question.only.is_some() || !finding.prepared.train.has_much_left(accepted) {
            break;
        }
        known
            .effects
            .extend(accepted.effects.iter().map(named::model_of));
        let Some(mut next) = search(&known, question) else {
            break;
        };
        let rest = finding.prepared.train.left(accepted);
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
    motion: &Motion<'_>,
    sampling: &mut Pair<Sampling>,
    question: &Question<'_>,
) -> Option<WrenchFinding> {
    let Motion {
        logs,
        costs,
        intervals,
        actuator,
    } = motion;
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
        PreparedLog::new(model, log, scene, sampling)
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
    let prepared = Pair { train, test };
    let finished = |tested: &Tested| structure::left(&prepared, Some(tested), 0.0).is_finished();
    let excluded =
        |id: &str| !question.tries(model, id) || (is_shape(id) && question.only.is_none());
    let found = wrench::search(
        &prepared.train,
        &prepared.test,
        &excluded,
        &finished,
        question.forced,
    );
    Some(WrenchFinding {
        found,
        prepared,
        earlier: (Vec::new(), 0.0),
    })
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
                measured: found.prepared.train.noise_model[axis.index()].level,
                data_sheet: sheet[axis.index()],
            });
        }
    }
    all
}
