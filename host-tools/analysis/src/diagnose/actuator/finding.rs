//! What the search on the executed velocity found.

use super::candidate::{Candidate, Search};
use super::cost::{Cost, LogCost, Term};
use super::intervals::{at_their_ends, intervals};
use super::search::{Ask, search};
use crate::diagnose::logs::Logs;
use crate::diagnose::noise::structure::Structure;
use crate::diagnose::question::Question;
use crate::diagnose::wrench::left::Left;
use softdock_physics::model::log::Log;
use softdock_physics::model::{Axis, Channel, Model};
use softdock_statistics::rms;

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
    /// χ² that the effects explain which the model has already.
    pub explained: f64,
    /// Number of velocities that are judged.
    pub count: usize,
    /// Ends of the 95 % interval of each parameter of each term.
    pub intervals: Vec<Vec<[f64; 2]>>,
    /// Parameters that stand where their search ends, in words.
    pub at_their_ends: Vec<String>,
    /// Ids of effects about which the logs disagree.
    pub disagreeing: Vec<&'static str>,
}

/// Searches what is between sent and executed velocity; none where nothing is sent or moves. `jitters`: the clock does.
pub(crate) fn actuator_stage(
    model: &Model,
    logs: &Logs<Log>,
    cost: &mut Cost<'_>,
    jitters: bool,
    question: &Question<'_>,
) -> Option<ActuatorFinding> {
    let moves = cost.active.contains(&true);
    let commanded = logs.all.iter().all(Log::is_commanded);
    if model.sensor.at_rest || !commanded || !moves {
        return None;
    }
    let excluded = |id: &str| !question.tries(model, id);
    let ask = Ask {
        excluded: &excluded,
        forced: question.forced,
        alone: jitters,
        fitted: logs.fitted,
        watch: question.watch,
    };
    let mut found = search(cost, &ask);
    if found.quieten(cost) {
        found = search(cost, &ask);
    }
    let around = cost.around(found.terms());
    let white = around.white(found.terms());
    let fitted = around.of_logs(|log| log < logs.fitted);
    // What all logs show beside terms in amounts of their own is something else than a disagreement.
    let explain = |own: &Vec<Vec<Term>>| !left_apart(own, logs, cost, jitters).any();
    let disagree = found.apart.as_ref().is_some_and(explain);
    let disagreeing = found.accepted.iter().filter(|_| disagree);
    Some(ActuatorFinding {
        disagreeing: disagreeing.flat_map(Candidate::ids).collect(),
        level: cost
            .logs
            .iter()
            .zip(&white)
            .map(|(log, white)| levels(log, white))
            .collect(),
        white,
        explained: cost.explained(),
        count: cost.count(),
        intervals: intervals(&found, &fitted),
        at_their_ends: at_their_ends(found.terms(), &fitted),
        strongest: found.strongest(cost),
        search: found,
    })
}

/// What terms leave that each log has in amounts of its own.
fn left_apart(own: &[Vec<Term>], logs: &Logs<Log>, cost: &Cost<'_>, scatters: bool) -> Left {
    let mut squares = 0.0;
    let each = logs.all.iter().zip(own).enumerate();
    let structures: Vec<[Structure; 6]> = each
        .map(|(k, (log, terms))| {
            let alone = cost.of_logs(|log| log == k).around(terms);
            let white = alone.white(terms).swap_remove(0);
            squares += white.iter().flatten().map(|w| w * w).sum::<f64>();
            let levels = levels(&alone.logs[0], &white);
            std::array::from_fn(|axis| {
                Structure::of_velocity(&white[axis], log, levels[axis], scatters)
            })
        })
        .collect();
    let axes = Axis::ALL.into_iter().map(|axis| {
        let of_axis = structures.iter().map(|axes| axes[axis.index()].clone());
        (Channel::ExecutedVelocity, axis, of_axis.collect())
    });
    Left::of_velocities(axes.collect(), squares, cost.of(&[]), cost.count())
}

/// Level of what is left of each axis over the data sheet's noise.
fn levels(log: &LogCost<'_>, white: &[Vec<f64>; 6]) -> [f64; 6] {
    std::array::from_fn(|axis| {
        let known = white[axis].get(log.known()).unwrap_or_default();
        rms(known) * log.sigma[axis] / log.sheet_sigma[axis]
    })
}
