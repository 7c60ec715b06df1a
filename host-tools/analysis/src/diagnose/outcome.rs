//! From what the stages found to a verdict.

use super::engine::Stages;
use super::equivalent;
use super::error_reduction::{ErrorReduction, with_effects};
use super::evidence;
use super::finding::{Diagnosis, Nominal, Remainder, RunnerUp, Verdict};
use super::left_over::left_over;
use super::log_to_log::from_log_to_log;
use super::logs::Logs;
use super::named::Named;
use super::notes::{Answer, TESTED, lacking, of_a_rig};
use super::question::Question;
use super::structure::{Left, Structure};
use super::verdict::Grounds;
use super::wrench::{self, OtherSign, Ripple};
use super::wrench_finding::WrenchFinding;
use super::{closest_rival, ranking, regions, sentence};
use crate::levels::{BeforeAfter, ChannelLevels};
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Channel, Model};
use softdock_statistics::DEVIATIONS_95;
use std::collections::BTreeMap;

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
    let named: Vec<&Named> = reduction.named.iter().map(|(named, _)| named).collect();
    let after = with_effects(model, named.iter().copied());
    let left = left_over(stages, &predictions);
    let in_sample = recordings.all.len() < 2;
    let found: Vec<String> = named.iter().map(|n| n.effect.id.clone()).collect();
    let disagreeing = match question.of_one_log {
        true => Vec::new(),
        false => disagreeing(stages),
    };
    let (anything, any_left) = (!found.is_empty(), left.iter().any(Left::any));
    let stands_still = !anything && !any_left && stands_still(model, stages);
    let grounds = Grounds {
        testable: lacking(stages).len() < TESTED && !stands_still,
        found: anything,
        disagree: !disagreeing.is_empty(),
        left: any_left,
        in_sample,
        asked,
    };
    let (verdict, unexplained) = (grounds.verdict(), grounds.unexplained());
    let unnamed = matches!(verdict, Verdict::Unexplained | Verdict::LogsDisagree);
    let ranked = ranking::ranked(stages);
    let (runner_up, further_ties) = closest_rival::all(&found, &ranked);
    // A curve beside which nothing is left says nothing.
    let curves = match !asked && left.iter().any(Left::is_structured) {
        true => ranking::shapes(stages),
        false => Vec::new(),
    };
    let looks_like = curves.iter().chain(found.iter().filter(|_| unnamed));
    let looks_like = looks_like.cloned().collect();
    let regions = match unnamed {
        true => regions::left_over(&left, stages),
        false => regions::explained(stages.before.shown(), predictions.shown(), stages),
    };
    let same = equivalent::of(named.iter().copied()).filter(|_| !unnamed);
    let mut remainder = remainder(stages, &left);
    let ripples = ripples(stages);
    if !ripples.is_empty() {
        remainder.follows = format!("{}; {}", each_ripple(&ripples), remainder.follows);
    }
    if verdict == Verdict::Unexplained {
        say_other_sign(stages, &mut remainder);
    }
    let notes = Answer {
        model,
        stages,
        fitted: recordings.fitted,
        verdict,
        reduction: &reduction,
        log_to_log: match verdict == Verdict::Named && !question.of_one_log {
            true => from_log_to_log(&after, recordings, &predictions, &named),
            false => None,
        },
        remainder: &remainder,
        curves: &curves,
        ripples: &ripples,
        equivalent: same.as_ref(),
    };
    let notes = notes.all(unexplained, in_sample);
    let probability = match unnamed {
        true => BTreeMap::new(),
        false => {
            let rivals: Vec<&RunnerUp> = runner_up.iter().chain(&further_ties).collect();
            probabilities(&named, &rivals, remainder.share > 0.0)
        }
    };
    let named_effects = if unnamed { Vec::new() } else { found };
    let mut diagnosis = Diagnosis {
        sentence: String::new(),
        verdict,
        experiment: runner_up
            .as_ref()
            .and_then(|r| closest_rival::experiment(named_effects.first(), r, of_a_rig(stages))),
        parameters: named
            .iter()
            .map(|n| (n.effect.id.clone(), n.estimates.clone()))
            .collect(),
        equivalent: same,
        effects: named_effects,
        probability,
        nominal: nominal(stages),
        remainder,
        disagreeing,
        residual_rms_sigma: BeforeAfter {
            before: ChannelLevels::of(stages.before.test()),
            after: ChannelLevels::of(predictions.test()),
        },
        steps: reduction.steps,
        runner_up,
        further_ties,
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

/// Whether nothing moves. Readings at rest show a zero that is off and a drift, and nothing else.
fn stands_still(model: &Model, stages: &Stages) -> bool {
    let mut logs = stages.logs.all.iter();
    !model.sensor.at_rest && logs.all(|log| log.rests(&model.noise))
}

/// Probability of each named effect: of two that the logs do not tell apart none is certain.
fn probabilities(
    named: &[&Named],
    rivals: &[&RunnerUp],
    leaves_structure: bool,
) -> BTreeMap<String, f64> {
    let of = |named: &&Named| {
        // A rival that fits better, but in whose place a simpler one was taken, is as likely.
        let own = named.support.against.max(0.0);
        let of_it = rivals.iter().find(|rival| rival.of == named.effect.id);
        let against = of_it.map_or(own, |rival| own.min(rival.against()));
        let probability = evidence::probability(against, leaves_structure);
        (named.effect.id.clone(), probability)
    };
    named.iter().map(of).collect()
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

/// Nominal parameters beside what was found.
fn nominal(stages: &Stages) -> BTreeMap<String, Nominal> {
    let found = stages.wrench.iter();
    let all = found.flat_map(WrenchFinding::nominal);
    let of = |(name, value, sigma, tolerances): (String, f64, f64, f64)| {
        let reach = DEVIATIONS_95 * sigma;
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

/// What repeats along an axis in what is left of the wrench.
fn ripples(stages: &Stages) -> Vec<Ripple> {
    let of = |found: &WrenchFinding| {
        let accepted = found.found.accepted.as_ref();
        wrench::ripples(&found.prepared, accepted, &found.structured_axes())
    };
    stages.wrench.as_ref().map_or(Vec::new(), of)
}

fn each_ripple(ripples: &[Ripple]) -> String {
    let of = |ripple: &Ripple| format!("{} {}: {}", Channel::Wrench, ripple.axis, ripple.words());
    ripples.iter().map(of).collect::<Vec<_>>().join("; ")
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
