//! From what the stages found to a verdict.

use super::actuator::{Candidate, Search};
use super::engine::{ActuatorFinding, Logs, Question, Stages, WrenchFinding};
use super::equivalent;
use super::error_reduction::{ErrorReduction, with_effects};
use super::evidence::{self, NAMED};
use super::finding::{Diagnosis, Nominal, Remainder, Verdict};
use super::named::{INTERVAL_95, Named};
use super::structure::{self, Left, Line, SLOW_HZ, Structure};
use super::verdict::Grounds;
use super::wrench::{self, Disagreement, OtherSign, PreparedLog};
use super::{closest_rival, ranking, regions, sentence};
use crate::compare::sentence::listed;
use crate::levels::{BeforeAfter, ChannelLevels};
use softdock_io::recording::Recording;
use softdock_physics::effects::CATALOGUE;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Axis, Channel, Model};
use softdock_report::number;
use softdock_statistics::{Noise, noise_floor};
use std::collections::BTreeMap;

/// Level of the model velocity over its digits that is no rounding any more.
const DIGITS: f64 = 1.35;

/// Share of a smooth remainder from which it is said what it follows.
const FOLLOWS: f64 = 0.1;

/// What a diagnosis concludes, and the model with what was named.
pub(crate) struct Outcome {
    /// For the user.
    pub diagnosis: Diagnosis,
    /// The model with the named effects.
    pub after: Model,
    /// Predictions with it.
    pub predictions: Logs<Prediction>,
}

/// Draws the conclusion; `unseen`: the second log was given, not held back.
pub(crate) fn conclude(
    model: &Model,
    recordings: &Logs<&Recording>,
    stages: &Stages,
    unseen: bool,
    question: &Question<'_>,
) -> anyhow::Result<Outcome> {
    let asked = question.only.is_some();
    let (reduction, predictions) = ErrorReduction::of(model, recordings, stages, asked)?;
    let after = with_effects(model, reduction.named.iter().map(|n| &n.0));
    let left = left_over(stages, &predictions);
    let in_sample = recordings.all.len() < 2;
    let found: Vec<String> = reduction
        .named
        .iter()
        .map(|n| n.0.effect.id.clone())
        .collect();
    let disagreeing = match question.of_one_log {
        true => Vec::new(),
        false => disagreeing(stages),
    };
    // Readings at rest show a zero that is off and a drift, and nothing else.
    let stands_still = !model.sensor.at_rest
        && stages.logs.all.iter().all(|log| log.rests(&model.noise))
        && found.is_empty()
        && !left.iter().any(Left::any);
    let grounds = Grounds {
        testable: lacking(stages).len() < TESTED && !stands_still,
        found: !found.is_empty(),
        disagree: !disagreeing.is_empty(),
        left: left.iter().any(Left::any),
        in_sample,
        asked,
    };
    let (verdict, unexplained) = (grounds.verdict(), grounds.unexplained());
    let unnamed = matches!(verdict, Verdict::Unexplained | Verdict::LogsDisagree);
    let ranked = ranking::ranked(stages);
    let runner_up = closest_rival::runner_up(&found, &ranked);
    // A curve beside which nothing is left says nothing.
    let curves = match !asked && left.iter().any(Left::is_structured) {
        true => ranking::shapes(stages),
        false => Vec::new(),
    };
    let mut looks_like = curves.clone();
    let regions = if unnamed {
        looks_like.extend(found.iter().cloned());
        regions::left_over(&left, stages)
    } else {
        regions::explained(stages.before.shown(), predictions.shown(), stages)
    };
    let named_effects = if unnamed { Vec::new() } else { found };
    let same = equivalent::of(reduction.named.iter().map(|n| &n.0)).filter(|_| !unnamed);
    let mut remainder = remainder(stages, &left);
    if verdict == Verdict::Unexplained {
        say_other_sign(stages, &mut remainder);
    }
    let mut notes = notes(model, stages, &remainder, unexplained, in_sample);
    if verdict == Verdict::LogsDisagree {
        let all = stages.wrench.iter().flat_map(|w| &w.found.disagreeing);
        notes.extend(all.flat_map(|one| amounts_of_logs(one, recordings.fitted)));
    }
    notes.extend(curves.iter().map(|id| {
        format!("{id} is a curve that fits many mechanisms, and is not named; `softdock add MODEL {id} --fit LOG` adds it.")
    }));
    notes.extend(same.iter().map(|same| same.sentence.clone()));
    notes.extend(
        reduction.undetermined.iter().map(|id| {
            format!("{id} is not named: the 95 % intervals of all its parameters hold 0.")
        }),
    );
    notes.extend(reduction.done_without.iter().map(|id| {
        format!("{id} is not named: a friction that turns round over a speed foretells unseen data better without it.")
    }));
    notes.extend(reduction.refused.iter().map(|(id, without, with)| {
        format!(
            "{id} is not named: with it the error on unseen data goes from {without:.2} to {with:.2}; something of \
             another form is there."
        )
    }));
    notes.extend(reduction.refitted.iter().map(|[before, after]| {
        format!(
            "Parameters, and how a friction turns round, are those of least squares: these foretell unseen data {:.1} % better than those of the likelihood \
             that decides on names, which weighs errors as the noise has them; the form of a law is not quite that of the machine. \
             The intervals hold both.",
            100.0 * (1.0 - after / before)
        )
    }));
    if !unnamed {
        let choices = reduction.named.iter();
        notes.extend(choices.filter_map(|(n, _)| n.choice(of_a_rig(stages))));
        let ends = stages.wrench.iter().flat_map(|found| {
            let named = reduction.named.iter();
            named.filter_map(|(one, _)| one.at_its_end(found))
        });
        notes.extend(ends);
    }
    // Of two that the logs do not tell apart none is certain.
    let against = |named: &Named| {
        // A rival that fits better, but in whose place a simpler one was taken, is as likely.
        let own = named.support.against.max(0.0);
        match &runner_up {
            Some(rival) if rival.of == named.effect.id => own.min(rival.against()),
            _ => own,
        }
    };
    let mut diagnosis = Diagnosis {
        sentence: String::new(),
        verdict,
        experiment: runner_up
            .as_ref()
            .and_then(|r| closest_rival::experiment(named_effects.first(), r, of_a_rig(stages))),
        parameters: reduction
            .named
            .iter()
            .map(|(n, _)| (n.effect.id.clone(), n.estimates.clone()))
            .collect(),
        equivalent: same,
        effects: named_effects,
        probability: reduction
            .named
            .iter()
            .filter(|_| !unnamed)
            .map(|(n, _)| {
                (
                    n.effect.id.clone(),
                    evidence::probability(against(n), remainder.share > 0.0),
                )
            })
            .collect(),
        nominal: nominal(stages),
        remainder,
        disagreeing,
        residual_rms_sigma: BeforeAfter {
            before: ChannelLevels::of(stages.before.test()),
            after: ChannelLevels::of(predictions.test()),
        },
        steps: reduction.steps,
        runner_up,
        regions,
        looks_like,
        ranked,
        strongest_evidence: ranking::strongest(stages),
        noise: stages.noise.clone(),
        notes,
        unseen,
        seconds: 0.0,
    };
    diagnosis.sentence = sentence::of(&diagnosis, &left, stands_still);
    Ok(Outcome {
        diagnosis,
        after,
        predictions,
    })
}

/// Effects of all stages about which the logs disagree.
fn disagreeing(stages: &Stages) -> Vec<String> {
    let actuator = stages.actuator.iter().flat_map(|a| &a.disagreeing);
    let wrench = stages.wrench.iter().flat_map(|w| &w.found.disagreeing);
    let wrench = wrench.map(|disagreement| &disagreement.id);
    let body = stages.body.accepted.iter().filter(|fit| fit.disagrees);
    let all = actuator.chain(wrench).copied();
    let all = all.chain(body.map(|fit| fit.id));
    let mut ids: Vec<String> = Vec::new();
    for id in all {
        if !ids.iter().any(|known| known == id) {
            ids.push(id.to_owned());
        }
    }
    ids
}

/// What each log alone says of an effect about which they disagree.
fn amounts_of_logs(one: &Disagreement, fitted: usize) -> impl Iterator<Item = String> {
    one.amounts.iter().map(move |(name, unit, of_logs)| {
        let values: Vec<String> = of_logs.iter().map(|v| number::significant(*v, 3)).collect();
        let unseen = match values.get(fitted..) {
            Some(unseen @ [_, ..]) => format!("; those of --test {}", listed(unseen)),
            _ => String::new(),
        };
        let of_fit = listed(&values[..fitted.min(values.len())]);
        let unit = match *unit {
            "-" => String::new(),
            unit => format!(" in {unit}"),
        };
        format!(
            "{} {name}{unit}, each log alone: those of the fit {of_fit}{unseen}.",
            one.id
        )
    })
}

/// Said of logs of a rig.
const NO_SPACECRAFT: &str =
    "The model of the spacecraft is not tested: the logs hold no velocities of it.";

/// Number of things that a log may lack.
const TESTED: usize = 3;

/// Whether the controller of a rig wrote any of the logs.
fn of_a_rig(stages: &Stages) -> bool {
    stages.logs.all.iter().any(|log| log.of_a_rig)
}

/// What cannot be tested on these logs, and why.
fn lacking(stages: &Stages) -> Vec<&'static str> {
    let mut all = Vec::new();
    if stages.actuator.is_none() && !is_driven(stages) {
        all.push("The actuator is not tested: the logs hold no commanded velocities.");
    }
    if stages.wrench.is_none() {
        all.push("The mechanism, the tool and the sensor are not tested: the logs hold no wrench.");
    }
    let model_velocity = |p: &Prediction| {
        let channel = p.channel(Channel::ModelVelocity);
        channel.predicted.iter().any(Option::is_some)
    };
    if !stages.before.all.iter().all(model_velocity) {
        all.push(NO_SPACECRAFT);
    }
    all
}

/// Nominal parameters beside what was found.
fn nominal(stages: &Stages) -> BTreeMap<String, Nominal> {
    let found = stages.wrench.iter();
    let all = found.flat_map(WrenchFinding::nominal);
    let of = |(name, value, sigma, tolerances): (String, f64, f64, f64)| {
        let reach = INTERVAL_95 * sigma;
        let nominal = Nominal {
            value,
            low: value - reach,
            high: value + reach,
            tolerances,
        };
        (name, nominal)
    };
    all.map(of).collect()
}

/// What is left with structure of the channel that has most of it.
fn remainder(stages: &Stages, left: &[Left]) -> Remainder {
    let structured = left.iter().filter(|left| left.is_structured());
    let most = structured.max_by(|a, b| a.share.total_cmp(&b.share));
    let Some(most) = most else {
        return Remainder::default();
    };
    let of_wrench = most
        .axes
        .first()
        .is_some_and(|axis| axis.0 == Channel::Wrench);
    let found = stages.wrench.iter().filter(|_| of_wrench);
    let beside = found.filter_map(|found| found.beside_remainder.as_ref());
    let functions = beside.flat_map(|beside| &beside.remainder.follows);
    let words: Vec<String> = functions
        .filter(|(_, _, share)| *share > FOLLOWS)
        .map(|(axis, quantity, share)| {
            let (channel, words) = (Channel::Wrench, quantity.words());
            format!("{channel} {axis}: {:.0} % follows {words}", 100.0 * share)
        })
        .collect();
    let structure = most.structured().map(|(channel, axis, each)| {
        let words = each.last().map(Structure::words).unwrap_or_default();
        format!("{channel} {axis}: {words}")
    });
    Remainder {
        share: most.share,
        follows: match words.is_empty() {
            true => structure.collect::<Vec<_>>().join("; "),
            false => words.join("; "),
        },
    }
}

/// Says what law the reading follows with a sign that physics forbids it.
fn say_other_sign(stages: &Stages, remainder: &mut Remainder) {
    let is_asked = |found: &&WrenchFinding| found.left().is_structured();
    let other_sign = stages.wrench.as_ref().filter(is_asked).and_then(|found| {
        let accepted = found.found.accepted.clone().unwrap_or_default();
        wrench::other_sign(&found.prepared, &accepted)
    });
    if let Some(OtherSign { id, amount, share }) = other_sign {
        remainder.follows = format!(
            "{:.0} % of what is left of the wrench is like {id} with {amount}, a sign that physics forbids it; an own hypothesis \
             can say what acts so; {}",
            100.0 * share,
            remainder.follows
        );
    }
}

/// What is left of each channel.
fn left_over(stages: &Stages, after: &Logs<Prediction>) -> Vec<Left> {
    let mut all = Vec::new();
    if let Some(found) = &stages.actuator {
        all.push(left_of_actuator(found, stages));
    }
    if let Some(found) = &stages.wrench {
        let accepted = found.found.accepted.as_ref();
        let mut left = structure::left(&found.prepared, accepted, &[]);
        if stages.clock.jitter.is_some() {
            // Instants that were recovered but for noise leave bursts where the load is steep.
            let each = left.axes.iter_mut().flat_map(|(_, _, each)| each);
            each.for_each(|one| *one = one.clone().of_size());
        }
        let explains = accepted.is_some() || found.prepared.known > 0.0;
        if let Some(beside) = found.beside_remainder.as_ref().filter(|_| explains) {
            let smooth = &beside.remainder.of_logs;
            let both = structure::left(&found.prepared, accepted, smooth);
            left = left.beside(&beside.remainder, &both);
        }
        all.push(left);
    }
    all.push(left_of(Channel::ModelVelocity, stages, after));
    if stages.clock.jitter.is_none() {
        all.push(left_of(Channel::Pose, stages, after));
    }
    all
}

fn left_of_actuator(found: &ActuatorFinding, stages: &Stages) -> Left {
    let moving = |axis: &Axis| found.white.iter().all(|w| !w[axis.index()].is_empty());
    let axes = Axis::ALL
        .into_iter()
        .filter(moving)
        .map(|axis| {
            let i = axis.index();
            let logs = stages.logs.all.iter().zip(&found.white).zip(&found.level);
            let scatters = stages.clock.jitter.is_some();
            let of = logs.map(|((log, white), level)| {
                Structure::of_velocity(&white[i], log, level[i], scatters)
            });
            (Channel::ExecutedVelocity, axis, of.collect())
        })
        .collect();
    let (reached, nominal) = (found.search.reached(), found.search.nominal.chi2);
    Left::of_velocities(axes, reached, nominal, found.count)
}

/// Structure of a channel that the stages do not whiten themselves.
fn left_of(channel: Channel, stages: &Stages, after: &Logs<Prediction>) -> Left {
    let series = |prediction: &Prediction, axis: Axis| -> Vec<f64> {
        let values = prediction.channel(channel);
        (0..prediction.time_s.len())
            .map(|n| values.residual(n, axis).unwrap_or(0.0))
            .collect()
    };
    let rms = |v: &[f64]| (v.iter().map(|x| x * x).sum::<f64>() / v.len().max(1) as f64).sqrt();
    let of = |prediction: &Prediction, axis: Axis| -> Structure {
        let values = series(prediction, axis);
        let sheet = prediction.channel(channel).sigma[axis.index()];
        let level = rms(&values) / sheet;
        if channel == Channel::ModelVelocity {
            // Digits are no noise: only their size counts.
            return Structure {
                level: if level > DIGITS { level } else { 0.0 },
                ..Structure::default()
            };
        }
        // The increments of a noisy pose are differences: their spectrum is no test of anything.
        let floor = noise_floor(&values, Noise::Differenced, None)
            .unwrap_or(sheet)
            .max(0.3 * sheet);
        let white: Vec<f64> = values.iter().map(|v| v / floor).collect();
        Structure {
            slow: 0.0,
            line: Line::default(),
            narrow: Line::default(),
            ..Structure::of(&white, prediction.cycle_s, level)
        }
    };
    let judged = after.all[0].judged(channel).iter().copied();
    let axes = judged
        .filter(|a| !(channel == Channel::Pose && a.is_rotation()))
        .map(|axis| {
            let each = after.all.iter().map(|prediction| of(prediction, axis));
            (channel, axis, each.collect())
        })
        .collect();
    let square = |p: &[Prediction]| {
        let z = ChannelLevels::of(p);
        if channel == Channel::Pose {
            z.pose.powi(2)
        } else {
            z.model_velocity.powi(2)
        }
    };
    let (before, now) = (square(&stages.before.all), square(&after.all));
    let floor = if channel == Channel::Pose { 1.0 } else { 0.0 };
    let excess = (now - floor).max(0.0);
    let was = excess + (before - now).max(0.0);
    Left::new(axes, excess / was.max(1e-12))
}

fn notes(
    model: &Model,
    stages: &Stages,
    remainder: &Remainder,
    unexplained: bool,
    in_sample: bool,
) -> Vec<String> {
    let mut notes = stages.before.shown().notes.clone();
    let lacking = lacking(stages).into_iter();
    let lacking = lacking.filter(|lack| of_a_rig(stages) || *lack != NO_SPACECRAFT);
    notes.extend(lacking.map(str::to_owned));
    if stages.logs.have_own_origins() {
        let turns = model.bearing().is_some();
        let by_position = CATALOGUE.iter().filter(|e| e.acts_by_position(turns));
        let ids: Vec<&str> = by_position.map(|effect| effect.id).collect();
        notes.push(format!(
            "Not tested: {}. The logs hold velocities and no positions, so that each has an origin of its own; map the \
             position.",
            ids.join(", ")
        ));
    }
    if in_sample {
        notes.push(
            "There is no unseen data: the end of the log holds too little motion to judge on, so \
             the effects are judged on the data that they were fitted on. Give a second log with \
             --test."
                .to_owned(),
        );
    }
    for id in stages.actuator.iter().flat_map(|a| undecided(&a.search)) {
        notes.push(format!(
            "The log does not tell which form of {id} it is; the interval spans all that fit as well."
        ));
    }
    if let Some(steps) = stages.wrench.as_ref().and_then(|w| w.found.ended_after) {
        notes.push(format!(
            "The search for effects on the wrench was ended after {steps} steps, each with more \
             evidence than the one before: no few effects explain this log; check its units and the \
             model file."
        ));
    }
    let beside = stages
        .wrench
        .iter()
        .filter_map(|w| w.beside_remainder.as_ref());
    let mut logs = stages.wrench.iter().flat_map(|w| &w.prepared.logs);
    let touches = logs.any(|log| log.scene.touches_anything());
    for one in beside.flat_map(|beside| &beside.imitated) {
        let reason = match one.evidence < NAMED {
            true => format!(
                "the evidence for it is {:.0}, {NAMED:.0} are needed",
                one.evidence
            ),
            false => "its 95 % interval holds 0".to_owned(),
        };
        notes.push(format!(
            "{} is not told from a smooth remainder, functions of position, velocity, \
             acceleration{} and time in its place: {reason}.",
            one.id,
            if touches { ", contact depth" } else { "" }
        ));
    }
    let in_place = stages.wrench.iter();
    for id in in_place.flat_map(|w| &w.found.curve_in_place_of) {
        notes.push(format!(
            "{id} would explain more, and is not told from a curve that fits many mechanisms in its place."
        ));
    }
    for floor in &stages.noise {
        let ratio = floor.measured / floor.data_sheet;
        if ratio < 1.0 / sentence::MORE_THAN_NOISE {
            notes.push(format!(
                "{} {}: what is faster than {SLOW_HZ} Hz is {ratio:.2} times the noise of the model file, which is too large: errors in its units look small. Evidence and intervals take the noise from the log.",
                floor.channel, floor.axis
            ));
        }
        // The filter of an import leaves nothing that is faster than its cutoff; nor does a log have it beyond half of its rate.
        let filter = stages.wrench.iter().flat_map(|w| &w.prepared.logs);
        let mut filters = filter.filter_map(|log| log.scene.model.sensor.filter);
        let has_none = floor.channel == Channel::Wrench && filters.any(|f| f.cutoff_hz <= SLOW_HZ);
        let is_slow = 0.5 / stages.logs.shown().cycle_s <= SLOW_HZ;
        if !has_none && !is_slow && ratio > sentence::MORE_THAN_NOISE {
            let filter = match floor.channel {
                Channel::Wrench if differentiates(stages) => {
                    " If that is the acceleration of differentiated positions, what follows from it is not told from \
                     noise, nor is a delay: a [filter] in the mapping of the import keeps the motion and cuts the rest."
                }
                _ => "",
            };
            notes.push(format!(
                "{} {}: what is faster than {SLOW_HZ} Hz is {ratio:.2} times the noise of the model file: noise, or a fast error of \
                 the model.{filter}",
                floor.channel, floor.axis
            ));
        }
    }
    if remainder.share > 0.0 && !unexplained {
        notes.push(format!(
            "{:.2} % of the error is left with structure: {}.",
            100.0 * remainder.share,
            remainder.follows
        ));
    }
    notes
}

/// Whether accelerations are differences of recorded positions or velocities, and nothing smooths them.
fn differentiates(stages: &Stages) -> bool {
    let raw = |log: &PreparedLog| log.scene.model.sensor.filter.is_none();
    let mut logs = stages.wrench.iter().flat_map(|w| &w.prepared.logs);
    logs.any(raw) && !stages.logs.all.iter().any(|log| log.is_commanded())
}

/// Whether the motion follows the wrench of the logs.
fn is_driven(stages: &Stages) -> bool {
    let mut logs = stages.wrench.iter().flat_map(|w| &w.prepared.logs);
    logs.any(|log| log.scene.model.sensor.wrench.drives())
}

/// Effects whose form the log does not tell.
fn undecided(search: &Search) -> Vec<&'static str> {
    let accepted = search.accepted.iter().flat_map(|c| &c.terms);
    let mut ids: Vec<&str> = accepted
        .enumerate()
        .filter(|(i, term)| {
            let differs =
                |form: &Candidate| form.terms.get(*i).is_some_and(|t| t.stage != term.stage);
            search.equal_forms.iter().any(differs)
        })
        .map(|(_, term)| term.stage.id())
        .collect();
    ids.dedup();
    ids
}
