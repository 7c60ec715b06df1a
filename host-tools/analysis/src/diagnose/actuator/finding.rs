//! What the search on the executed velocity found.

use super::candidate::Search;
use super::cost::{Cost, LogCost, Term};
use super::intervals::{at_their_ends, intervals};
use super::search::{Ask, search};
use super::tried::specs;
use crate::diagnose::evidence::{DIFFERS, MOST};
use crate::diagnose::logs::Logs;
use crate::diagnose::noise::structure::Structure;
use crate::diagnose::question::Question;
use crate::diagnose::wrench::Disagreement;
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
    /// Effects about which the logs disagree.
    pub disagreeing: Vec<Disagreement>,
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
    // What all logs show beside terms in amounts of their own is something else than a disagreement, but on machines, which leave
    // something in any case.
    let explain = |own: &Vec<Vec<Term>>| {
        !left_apart(own, logs, cost, jitters).any()
            || (differ(own, cost) && explain_most(own, found.reached(), cost))
    };
    let disagreeing = found.apart.as_ref().filter(|own| explain(own));
    Some(ActuatorFinding {
        disagreeing: disagreeing.map_or_else(Vec::new, |own| disagreements(own)),
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

/// The amounts of each log, one entry for an effect: that of its first axes.
fn disagreements(own: &[Vec<Term>]) -> Vec<Disagreement> {
    let mut all: Vec<Disagreement> = Vec::new();
    for (place, term) in own[0].iter().enumerate() {
        let id = term.stage.id();
        if all.iter().any(|one| one.id == id) {
            continue;
        }
        let rotation = term.axes[3..].contains(&true);
        let named = term.stage.parameters(rotation).iter().enumerate();
        let amounts = named.map(|(k, (name, unit))| {
            let of_logs = own.iter().map(|terms| terms[place].values[k]);
            (*name, *unit, of_logs.collect())
        });
        all.push(Disagreement {
            id,
            amounts: amounts.collect(),
        });
    }
    all
}

/// Whether terms in amounts of each log's own explain most of what common ones leave.
fn explain_most(own: &[Vec<Term>], left: f64, cost: &Cost<'_>) -> bool {
    let each = own.iter().enumerate();
    let apart: f64 = each
        .map(|(log, terms)| cost.of_logs(|k| k == log).of(terms))
        .sum();
    left - apart > MOST * left
}

/// Whether an amount of one log is half as large again as that of another, as [`DIFFERS`] asks of a wrench.
fn differ(own: &[Vec<Term>], cost: &Cost<'_>) -> bool {
    let ratio = (1.0 + DIFFERS.sqrt()) / (1.0 - DIFFERS.sqrt());
    let of_term = |place: usize| {
        let term = &own[0][place];
        let specs = specs(term.stage, &cost.scale(&term.axes));
        let mut known = specs.iter().enumerate();
        known.any(|(k, spec)| {
            let Some(from) = spec.ratio_from else {
                return false;
            };
            let amounts = own.iter().map(|terms| terms[place].values[k] - from);
            let (least, most) = amounts.fold((f64::INFINITY, 0.0), |(least, most), amount| {
                (f64::min(least, amount), f64::max(most, amount))
            });
            most > ratio * least
        })
    };
    (0..own[0].len()).any(of_term)
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
