//! What the search on the executed velocity found.

use super::candidate::Search;
use super::cost::{Cost, LogCost, Term};
use super::intervals::{at_their_ends, intervals};
use super::search::{Ask, search};
use super::tried::specs;
use crate::diagnose::evidence::DIFFERS;
use crate::diagnose::logs::Logs;
use crate::diagnose::noise::structure::Structure;
use crate::diagnose::question::Question;
use crate::diagnose::wrench::left::RemainingStructure;
use crate::diagnose::wrench::{AmountByLog, Disagreement};
use softdock_physics::model::log::Log;
use softdock_physics::model::{Axis, Channel, Model};
use softdock_statistics::rms;

/// The unmodelled dynamics of the actuator.
pub(crate) struct ActuatorFinding {
    /// Result of the search.
    pub search: Search,
    /// The largest evidence of any stage alone.
    pub strongest: Option<f64>,
    /// Whitened residuals of each log and axis with the accepted terms.
    pub white: Vec<[Vec<f64>; 6]>,
    /// Rms residual of each log and axis over the data sheet's noise.
    pub level: Vec<[f64; 6]>,
    /// Fall of χ² by the effects that the model has already.
    pub explained: f64,
    /// Number of velocities that count.
    pub count: usize,
    /// Ends of the 95 % interval of each parameter of each term.
    pub intervals: Vec<Vec<[f64; 2]>>,
    /// For each parameter that lies at an end of its searched range: a sentence that says so.
    pub at_their_ends: Vec<String>,
    /// Effects about which the logs disagree.
    pub disagreeing: Vec<Disagreement>,
}

/// Searches what lies between sent and executed velocity. `jitters`: the clock does, so no pairs are searched. `None` where
/// nothing is sent or moves.
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
    let white = around.whitened_residuals(found.terms());
    let fitted = around.of_logs(|log| log < logs.fitted);
    let disagreeing = found.accepted.iter().zip(&found.apart);
    let disagreeing = disagreeing
        .map(|(common, own)| disagreements(&common.terms, own, logs, cost, jitters))
        .next();
    Some(ActuatorFinding {
        disagreeing: disagreeing.unwrap_or_default(),
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

/// Effects about which the logs disagree, given that own amounts of each log are worth their price. If these leave structure as
/// well, the error is not a disagreement. A machine that is no docking rig always leaves something: there the logs disagree if
/// the common amounts leave more than a name allows and the own ones do not. On such a machine only those effects count of which
/// one log shows half as much again as another, as evidence alone tells amounts apart that differ by some percent from run to
/// run.
fn disagreements(
    common: &[Term],
    own: &[Vec<Term>],
    logs: &Logs<Log>,
    cost: &Cost<'_>,
    jitters: bool,
) -> Vec<Disagreement> {
    let left = |own: &[Vec<Term>]| left_apart(own, logs, cost, jitters);
    let mut places: Vec<usize> = (0..common.len()).collect();
    if left(own).any() {
        let all_alike = vec![common.to_vec(); own.len()];
        let is_named = |own: &[Vec<Term>]| !left(own).of_a_servo().any();
        if logs.have_spacecraft() || !is_named(own) || is_named(&all_alike) {
            return Vec::new();
        }
    }
    if !logs.have_spacecraft() {
        places.retain(|place| differ(*place, own, cost));
    }
    let amounts = |place: &usize| {
        let stage = common[*place].stage;
        let rotation = common[*place].axes[3..].contains(&true);
        let named = stage.parameters(rotation).iter().enumerate();
        let amounts = named.map(|(k, (name, unit))| {
            let of_logs = own.iter().map(|terms| terms[*place].values[k]);
            AmountByLog {
                name,
                unit,
                values: of_logs.collect(),
            }
        });
        Disagreement {
            id: stage.id(),
            amounts: amounts.collect(),
        }
    };
    places.iter().map(amounts).collect()
}

/// Whether an amount of one log is half as large again as that of another, by [`DIFFERS`] as for a wrench. Amounts without a
/// natural zero, as the centre of a dead zone, have no ratio and do not count.
fn differ(place: usize, own: &[Vec<Term>], cost: &Cost<'_>) -> bool {
    let ratio = (1.0 + DIFFERS.sqrt()) / (1.0 - DIFFERS.sqrt());
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
}

/// What terms leave if each log has amounts of its own.
fn left_apart(
    own: &[Vec<Term>],
    logs: &Logs<Log>,
    cost: &Cost<'_>,
    scatters: bool,
) -> RemainingStructure {
    let mut squares = 0.0;
    let each = logs.all.iter().zip(own).enumerate();
    let structures: Vec<[Structure; 6]> = each
        .map(|(k, (log, terms))| {
            let alone = cost.of_logs(|log| log == k).around(terms);
            let white = alone.whitened_residuals(terms).swap_remove(0);
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
    RemainingStructure::of_velocities(axes.collect(), squares, cost.of(&[]), cost.count())
}

/// Rms of what is left of each axis, over the data sheet's noise.
fn levels(log: &LogCost<'_>, white: &[Vec<f64>; 6]) -> [f64; 6] {
    std::array::from_fn(|axis| {
        let known = white[axis].get(log.known_cycles()).unwrap_or_default();
        rms(known) * log.sigma[axis] / log.sheet_sigma[axis]
    })
}
