//! What the logs show, with what is believed of their clock.

use super::actuator::{self, Candidate, Cost, Term};
use super::clock::{self, CommonDelay, PoseScatter};
use super::engine::{ActuatorFinding, Imitated, Logs, Question, WrenchFinding, is_shape};
use super::evidence::NAMED;
use super::finding::NoiseFloor;
use super::named;
use super::sampling::Sampling;
use super::structure::{Left, Structure};
use super::timed_logs::TimedLogs;
use super::wrench::{self, Joint, PreparedLog};
use rayon::prelude::*;
use softdock_physics::effects::{Kind, by_id};
use softdock_physics::model::log::Log;
use softdock_physics::model::{Axis, Channel, Model};

/// Residual over noise up to which the simulated motion is trusted: its misfit is then three quarters
/// of the noise that a measured velocity would bring into the load. Coloured noise, whose floor is
/// taken for smaller than it is, reaches 1.2.
const TRUSTED: f64 = 1.25;

/// What was found in logs with one belief about their clock.
pub(super) struct StageResults {
    /// The logs, and what is believed of their clock.
    pub timed: TimedLogs,
    /// The actuator, where anything was commanded.
    pub actuator: Option<ActuatorFinding>,
    /// Scatter of the poses' instants that is left, in logs without a velocity of their own.
    pub scatter: Vec<PoseScatter>,
    /// A common delay of all velocities; None where nothing speaks for it.
    pub common_delay: Option<CommonDelay>,
    /// A common factor of all velocities, less 1, with its deviation.
    pub proportion: (f64, f64),
    /// Sampling of the sensor.
    pub sampling: Logs<Sampling>,
    /// The reading.
    pub wrench: Option<WrenchFinding>,
    /// Noise floors on the first log.
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
        let mut cost = Cost::new(model, &logs.all, &intervals.all);
        let jitters = timed.clock.jitter.is_some();
        let actuator = actuator_stage(model, logs, &mut cost, jitters, question);
        let terms = actuator.as_ref().map_or(&[][..], |a| a.search.terms());
        let of_log = |log| clock::scatter(&cost, log, terms);
        let scatter = cost.logs.iter().map(of_log).collect();
        let common_delay = clock::common_delay(&cost);
        let proportion = clock::proportion(&cost);
        progress(0.5, "explaining the wrench");
        let sigma = wrench::sheet_sigma(model);
        let mut sampling = logs.map(|log| Sampling::of(log, &sigma));
        let plain = timed.without_offset();
        let moved = match &timed.aligned {
            // The actuator as it really moves the tool, not as late poses show it.
            Some(aligned) => Cost::new(&plain, &aligned.all, &intervals.all),
            None => cost.clone(),
        };
        let wrench = wrench_rounds(model, question, &mut |model, question| {
            let motion = Motion {
                logs: timed.aligned(),
                cost: &moved,
                intervals,
                actuator: actuator.as_ref(),
            };
            wrench_stage(model, &motion, &mut sampling, question)
        });
        let noise = noise_floors(model, &cost, wrench.as_ref());
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
    logs: &'a Logs<Log>,
    cost: &'a Cost<'a>,
    intervals: &'a Logs<Vec<f64>>,
    actuator: Option<&'a ActuatorFinding>,
}

fn actuator_stage(
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
    let ask = actuator::Ask {
        excluded: &excluded,
        forced: question.forced,
        alone: jitters,
        fitted: logs.fitted,
        watch: question.watch,
    };
    let mut search = actuator::search(cost, &ask);
    if search.quieten(cost) {
        search = actuator::search(cost, &ask);
    }
    let around = cost.around(search.terms());
    let white = around.white(search.terms());
    let fitted = around.of_logs(|log| log < logs.fitted);
    // What all logs show beside terms in amounts of their own is something else than a disagreement.
    let explain = |own: &Vec<Vec<Term>>| !left_apart(own, logs, cost, jitters).any();
    let disagree = search.apart.as_ref().is_some_and(explain);
    let disagreeing = search.accepted.iter().filter(|_| disagree);
    Some(ActuatorFinding {
        disagreeing: disagreeing.flat_map(Candidate::ids).collect(),
        level: cost
            .logs
            .iter()
            .zip(&white)
            .map(|(log, white)| levels(log, white))
            .collect(),
        white,
        count: cost.count(),
        intervals: actuator::intervals(&search, &fitted),
        strongest: search.strongest(cost),
        search,
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
fn levels(log: &actuator::LogCost<'_>, white: &[Vec<f64>; 6]) -> [f64; 6] {
    std::array::from_fn(|axis| rms(&white[axis]) * log.sigma[axis] / log.sheet_sigma[axis])
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
    let mut leaves_structure = finding.left().is_structured();
    for _ in 1..ROUNDS {
        let Some(accepted) = finding.found.accepted.as_ref() else {
            break;
        };
        if question.only.is_some() || !finding.prepared.has_much_left(accepted.gain) {
            break;
        }
        if !finding.found.disagreeing.is_empty() {
            break;
        }
        known
            .effects
            .extend(accepted.effects.iter().map(named::model_of));
        let Some(mut next) = search(&known, question) else {
            break;
        };
        let worth = |more: &wrench::Tested| more.gain > finding.prepared.threshold(accepted.gain);
        if !next.found.accepted.as_ref().is_some_and(worth) {
            break;
        }
        next.earlier = finding.earlier;
        next.earlier.0.extend(accepted.effects.iter().cloned());
        next.earlier.1.extend(finding.found.support);
        next.found.ranked.extend(finding.found.ranked);
        next.found.rivals.extend(finding.found.rivals);
        finding = next;
        leaves_structure |= finding.left().is_structured();
    }
    // What logs that disagree have in common is no answer that could be bettered.
    if !finding.found.disagreeing.is_empty() {
        return Some(finding);
    }
    while question.only.is_none() {
        let Some(gone) = finding.unsure() else {
            break;
        };
        let ids = finding.ids_without(std::slice::from_ref(&gone));
        let fewer = among(&ids, model, question, search);
        let fewer = fewer.filter(|f| !f.ids().contains(&gone) && f.is_as_good_as(&finding));
        match fewer {
            Some(fewer) => finding = fewer,
            None => break,
        }
    }
    // What a later round finds can be an answer to the structure that the first one has left, and no
    // better than a smooth remainder.
    if question.only.is_none() && leaves_structure {
        finding = beside_remainder(finding, &mut |ids| among(ids, model, question, search));
    }
    // A friction that builds up after each reversal looks like a delay of all that loads the sensor.
    let is_dry = |id: &String| by_id(id).is_some_and(|e| e.kind == Some(Kind::DryFriction));
    let beside_others = !finding.found.before_late.is_empty() || finding.ids().iter().any(is_dry);
    let late = match beside_others {
        true => finding.late(),
        false => Vec::new(),
    };
    let asks = !late.is_empty() || finding.left().is_structured();
    if asks && !question.tries_shapes() {
        let curves = Question {
            shapes: true,
            without: &late,
            ..*question
        };
        if let Some(curve) = finding.better_curve(search(model, &curves), !late.is_empty()) {
            let mut among = |ids: &[String]| among(ids, model, question, search);
            finding = beside_curve(finding, curve, late, &mut among);
        }
    }
    Some(finding)
}

/// A search among some effects.
fn among(
    ids: &[String],
    model: &Model,
    question: &Question<'_>,
    search: &mut dyn FnMut(&Model, &Question<'_>) -> Option<WrenchFinding>,
) -> Option<WrenchFinding> {
    let question = Question {
        among: Some(ids),
        ..*question
    };
    search(model, &question)
}

/// Where a curve that fits many mechanisms does as well: without the late effects in whose place it is.
fn beside_curve(
    first: WrenchFinding,
    curve: wrench::Tested,
    late: Vec<String>,
    among: &mut dyn FnMut(&[String]) -> Option<WrenchFinding>,
) -> WrenchFinding {
    let mut finding = first;
    if let Some(fewer) = (!late.is_empty())
        .then(|| among(&finding.ids_without(&late)))
        .flatten()
    {
        finding = beside_remainder(fewer, among);
        finding.found.curve_in_place_of = late;
    }
    finding.found.ranked.push(curve);
    finding
}

/// Where structure is left: only the effects that a smooth remainder would not explain as well, one
/// less at a time, with the parameters and the intervals that they have beside it. What was left out
/// beside others that were left out later has a second chance.
fn beside_remainder(
    first: WrenchFinding,
    among: &mut dyn FnMut(&[String]) -> Option<WrenchFinding>,
) -> WrenchFinding {
    let mut finding = first;
    let mut imitated = Vec::new();
    while let Some((place, one)) = weakest(&mut finding) {
        let gone = finding.ids().swap_remove(place);
        let mut ids = finding.ids_without(std::slice::from_ref(&gone));
        // Where no detail is told, what it is a detail of may still be.
        let detail_of = by_id(&gone).map_or(&[][..], |effect| effect.detail_of);
        let plain = detail_of.iter().map(|(id, _)| (*id).to_owned());
        ids.extend(plain.filter(|id| !finding.ids().contains(id)));
        imitated.push(one);
        let Some(mut fewer) = among(&ids) else {
            break;
        };
        fewer.found.before_late.extend(finding.found.before_late);
        finding = fewer;
    }
    for Imitated { id, .. } in imitated.clone() {
        let mut ids = finding.ids();
        ids.push(id.clone());
        let Some(mut more) = among(&ids) else {
            continue;
        };
        if more.ids().contains(&id) && weakest(&mut more).is_none() {
            finding = more;
            imitated.retain(|other| other.id != id);
        }
    }
    if finding.found.accepted.is_none() && finding.prepared.known > 0.0 {
        finding.stand_alone();
    }
    if !imitated.is_empty() {
        finding.beside_remainder.get_or_insert_default().imitated = imitated;
    }
    finding
}

/// The effect that stands weakest beside a smooth remainder, if it does not stand; where all do, or
/// nothing is left, there is none.
fn weakest(finding: &mut WrenchFinding) -> Option<(usize, Imitated)> {
    let accepted = finding.found.accepted.as_ref()?;
    let axes = finding.structured_axes();
    if axes.is_empty() {
        return None;
    }
    let each = wrench::standings(&finding.prepared, &finding.earlier.0, accepted, &axes);
    let model = &finding.prepared.logs.first()?.scene.model;
    let effects = finding.earlier.0.iter().chain(&accepted.effects);
    let places = each.iter().zip(effects).map(|(one, effect)| Imitated {
        id: effect.id.to_owned(),
        evidence: one.evidence,
        determined: one.determines(effect, model),
    });
    let least = |these: Vec<(usize, Imitated)>| {
        let these = these.into_iter();
        these.min_by(|a, b| a.1.evidence.total_cmp(&b.1.evidence))
    };
    // What others imitate is undetermined only as long as they are there.
    let (weak, strong): (Vec<_>, Vec<_>) = places
        .enumerate()
        .partition(|(_, one)| one.evidence < NAMED);
    let undetermined = strong.into_iter().filter(|(_, one)| !one.determined);
    let fails = least(weak).or_else(|| least(undetermined.collect()));
    if fails.is_none() {
        let (earlier, _) = &finding.earlier;
        let remainder = wrench::remainder(&finding.prepared, earlier, accepted, &axes);
        finding.stand(&each, remainder);
    }
    fails
}

fn wrench_stage(
    model: &Model,
    motion: &Motion<'_>,
    sampling: &mut Logs<Sampling>,
    question: &Question<'_>,
) -> Option<WrenchFinding> {
    let Motion {
        logs,
        cost,
        intervals,
        actuator,
    } = motion;
    let measured = |log: &Log| log.wrench.iter().flatten().any(|v| *v != 0.0);
    if !logs.all.iter().all(measured) {
        return None;
    }
    let terms: &[Term] = actuator.map_or(&[], |a| a.search.terms());
    let trusted = actuator.is_some_and(|a| actuator::level(a.search.reached(), cost) < TRUSTED);
    let each = logs.all.par_iter().zip(&intervals.all);
    let each = each.zip(&mut sampling.all);
    let prepared = each.map(|((log, intervals), sampling)| {
        let scene = wrench::scene(model, log, cost, terms, trusted, intervals);
        PreparedLog::new(model, log, scene, sampling)
    });
    let mut prepared = Joint::new(prepared.collect(), logs.fitted);
    let excluded =
        |id: &str| !question.tries(model, id) || (is_shape(id) && !question.tries_shapes());
    let ask = wrench::Ask {
        excluded: &excluded,
        forced: question.forced,
        each_log: question.among.is_none() && question.only.is_none(),
        watch: question.watch,
    };
    let found = wrench::search(&mut prepared, &ask);
    Some(WrenchFinding {
        found,
        prepared,
        earlier: (Vec::new(), Vec::new()),
        beside_remainder: None,
    })
}

fn noise_floors(model: &Model, cost: &Cost<'_>, wrench: Option<&WrenchFinding>) -> Vec<NoiseFloor> {
    let mut all = Vec::new();
    let first = cost.logs.iter().take(1);
    for log in first {
        let moving = Axis::ALL.into_iter().filter(|a| cost.active[a.index()]);
        all.extend(moving.map(|axis| NoiseFloor {
            channel: Channel::ExecutedVelocity,
            axis,
            measured: log.sigma[axis.index()],
            data_sheet: log.sheet_sigma[axis.index()],
        }));
    }
    let sheet = wrench::sheet_sigma(model);
    for log in wrench.iter().flat_map(|found| found.prepared.logs.first()) {
        let recorded = |axis: &Axis| !log.residual.0[axis.index()].is_empty();
        let axes = Axis::ALL.into_iter().filter(recorded);
        all.extend(axes.map(|axis| NoiseFloor {
            channel: Channel::Wrench,
            axis,
            measured: log.noise_model[axis.index()].level,
            data_sheet: sheet[axis.index()],
        }));
    }
    all
}
