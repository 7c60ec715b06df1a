//! Hypotheses of all stages with their evidence.

use super::closest_rival::is_more_than;
use crate::diagnose::actuator::Candidate;
use crate::diagnose::catalogue::is_general_curve;
use crate::diagnose::clock::Jitter;
use crate::diagnose::evidence::{self, NEARLY_AS_GOOD, TOLD_APART};
use crate::diagnose::finding::{Ranked, StrongestEvidence};
use crate::diagnose::stages::Stages;
use crate::diagnose::stages::clock_rivals::ClockRival;
use crate::diagnose::wrench::TestedHypothesis;
use crate::diagnose::wrench::finding::WrenchFinding;
use softdock_physics::effects::body::clock_jitter;
use softdock_physics::model::Channel;
use std::collections::{BTreeMap, BTreeSet};

/// Most hypotheses that are reported of the first round.
const REPORTED: usize = 12;
/// Most that are reported of each later round, and of refused ones.
const REPORTED_LATER: usize = 4;
/// Smallest fall of χ² over all logs with which a hypothesis is reported.
const LEAST: f64 = 10.0;

/// All hypotheses of all stages, best first, refused ones last.
pub(crate) fn ranked(stages: &Stages) -> Vec<Ranked> {
    let fitted = stages.logs.fitted;
    let mut all = of_actuator(stages);
    all.extend(in_place(stages));
    let bodies = stages.body.accepted.iter();
    all.extend(bodies.map(|body| {
        let fall = fall(&body.gains, fitted);
        plain(
            &[body.id],
            Channel::ModelVelocity,
            fall,
            body.parameters.len(),
        )
    }));
    let rivals = stages.clock_rivals.iter();
    all.extend(rivals.flat_map(|r| against_the_clock(r, stages)));
    let jitter = stages.clock.jitter.iter();
    all.extend(jitter.map(|Jitter { gain, .. }| {
        plain(&[clock_jitter::EFFECT.id], Channel::Pose, [*gain, 0.0], 1)
    }));
    // Hypotheses on other channels are ranked by the fall of χ² less a price from the number of cycles, so that a named set
    // stands before one that fits a little better with more effects. Those on the reading have the evidence of their search.
    let price = evidence::price(stages.logs.all.iter().map(|log| log.cycle_count()).sum());
    let worth = |r: &Ranked| {
        let paid = price * r.parameters as f64 + evidence::prior() * r.effects.len() as f64;
        r.fall() - paid
    };
    let mut all: Vec<(f64, Ranked)> = all.into_iter().map(|r| (worth(&r), r)).collect();
    all.extend(stages.wrench.iter().flat_map(|w| of_wrench(w, fitted)));
    all.sort_by(|(a, one), (b, other)| {
        let refused = |r: &Ranked| r.refused.is_some();
        refused(one).cmp(&refused(other)).then(b.total_cmp(a))
    });
    let mut all = each_once(all.into_iter().map(|(_, one)| one).collect());
    all.retain(|one| one.fall() > LEAST);
    all
}

/// Keeps the first of those with the same effects beside the same others.
fn each_once(mut all: Vec<Ranked>) -> Vec<Ranked> {
    let mut seen: BTreeSet<(Vec<String>, Vec<String>)> = BTreeSet::new();
    all.retain(|one| {
        let mut effects = one.effects.clone();
        effects.sort_unstable();
        seen.insert((effects, one.beside.clone()))
    });
    all
}

/// Sums the fall of χ² over the logs of the fit, and over unseen ones.
fn fall(gains: &[f64], fitted: usize) -> [f64; 2] {
    let (fit, unseen) = gains.split_at(fitted.min(gains.len()));
    [fit, unseen].map(|gains| gains.iter().sum())
}

/// A hypothesis that was tried beside nothing else.
fn plain(effects: &[&str], channel: Channel, fall: [f64; 2], parameters: usize) -> Ranked {
    let [gain_train, gain_test] = fall;
    Ranked {
        effects: effects.iter().map(|id| (*id).to_owned()).collect(),
        beside: Vec::new(),
        channel,
        gain_train,
        gain_test,
        parameters,
        as_good_as: None,
        refused: None,
    }
}

/// Hypotheses about the actuator: the accepted one if it has several effects, and each single stage.
fn of_actuator(stages: &Stages) -> Vec<Ranked> {
    let Some(found) = &stages.actuator else {
        return Vec::new();
    };
    let several = found.search.accepted.iter().filter(|c| c.ids().len() > 1);
    let of = |candidate: &Candidate| {
        let both = found.search.nominal.each.iter().zip(&candidate.each);
        let gains: Vec<f64> = both.map(|(nominal, own)| nominal - own).collect();
        let fall = fall(&gains, stages.logs.fitted);
        plain(
            &candidate.ids(),
            Channel::ExecutedVelocity,
            fall,
            candidate.parameters(),
        )
    };
    several.chain(&found.search.singles).map(of).collect()
}

/// Hypotheses on the reading, with their evidence.
fn of_wrench(stage: &WrenchFinding, fitted: usize) -> impl Iterator<Item = (f64, Ranked)> {
    let ranked = &stage.found.ranked;
    // The answer as the search tried it, with the noise model of that search.
    let accepted = stage.found.accepted.as_ref();
    let answer = accepted.and_then(|accepted| ranked.iter().find(|t| t.is_same(accepted)));
    let answer = answer.filter(|_| stage.remaining_structure().is_structured());
    let error = |tested: &TestedHypothesis| stage.prepared.error_on_unseen(tested);
    let of = move |tested: &TestedHypothesis| {
        // Searches measure χ² by noise models of their own. Hypotheses that were tried beside the same effects are rescaled to
        // that of the answer.
        let tested = &match answer.filter(|answer| answer.beside == tested.beside) {
            Some(answer) => tested.clone().beside_noise(answer.to_explain),
            None => tested.clone(),
        };
        let forbidden = tested.wrong.join(", ");
        let [gain_train, gain_test] = fall(&tested.gains, fitted);
        let ranked = Ranked {
            effects: tested.ids(),
            beside: tested.beside.clone(),
            channel: Channel::Wrench,
            gain_train,
            gain_test,
            parameters: tested.parameters,
            as_good_as: answer.and_then(|answer| foretells_alike(answer, tested, &error)),
            refused: (!forbidden.is_empty()).then_some(forbidden),
        };
        (tested.evidence, ranked)
    };
    ranked.iter().map(of)
}

/// The effect of an answer in whose place a hypothesis has another one, if the hypothesis foretells the unseen logs as well and
/// explains nearly as much. Where structure is left, errors of form decide between two such hypotheses and not the noise. `None`
/// otherwise.
pub(crate) fn foretells_alike(
    answer: &TestedHypothesis,
    tested: &TestedHypothesis,
    error: &dyn Fn(&TestedHypothesis) -> f64,
) -> Option<String> {
    let [named, ids] = [answer, tested].map(TestedHypothesis::effects_in_order);
    let missing: Vec<&&str> = named.iter().filter(|id| !ids.contains(id)).collect();
    let [of] = missing[..] else {
        return None;
    };
    let has_more = tested.parameters > answer.parameters
        && ids
            .iter()
            .any(|id| !named.contains(id) && is_more_than(id, of));
    let exchanged = ids.len() == named.len() && tested.gain > NEARLY_AS_GOOD * answer.gain;
    let alike = exchanged && !has_more && error(tested) <= evidence::RISES * error(answer);
    alike.then(|| (*of).to_owned())
}

/// The largest evidence of any effect of each stage.
pub(crate) fn strongest(stages: &Stages) -> StrongestEvidence {
    let wrench = stages.wrench.as_ref();
    StrongestEvidence {
        actuator: stages.actuator.as_ref().and_then(|a| a.strongest),
        wrench: wrench.and_then(|w| strongest_of(&w.found.ranked)),
        body: stages.body.strongest,
    }
}

/// The largest evidence of a hypothesis over the best of its subsets alone, as the decision counts it.
fn strongest_of(ranked: &[TestedHypothesis]) -> Option<f64> {
    let possible = || ranked.iter().filter(|t| t.wrong.is_empty());
    let of_last = |pair: &TestedHypothesis| {
        let ids = pair.ids();
        let fewer = |t: &&TestedHypothesis| {
            t.effects.len() < ids.len() && t.ids().iter().all(|id| ids.contains(id))
        };
        let alone = possible().filter(fewer).map(|t| t.evidence);
        pair.evidence - alone.fold(0.0, f64::max)
    };
    possible().map(of_last).max_by(f64::total_cmp)
}

/// An error of the clock and the stage of the actuator that it looks like, the believed one first. Both have the other accepted
/// stages beside them.
fn against_the_clock(rival: &ClockRival, stages: &Stages) -> Vec<Ranked> {
    let accepted = stages.actuator.iter();
    let accepted = accepted.flat_map(|found| found.search.accepted.iter().flat_map(Candidate::ids));
    let besides: Vec<&str> = accepted.filter(|id| *id != rival.of).collect();
    let behind = rival.better.abs();
    let (winner, loser) = if rival.believed {
        (rival.id, rival.of)
    } else {
        (rival.of, rival.id)
    };
    let [train, test] = fall(&rival.gain, stages.logs.fitted);
    let one = |id: &str, behind: f64, as_good_as: Option<&str>| {
        let mut ids: Vec<&str> = besides.iter().copied().chain([id]).collect();
        ids.sort_unstable();
        // The difference is known for all logs together, so it is shared out in proportion.
        let share = 1.0 - behind / (train + test).max(behind).max(f64::MIN_POSITIVE);
        let fall = [train, test].map(|gain| share * gain);
        Ranked {
            as_good_as: as_good_as.map(str::to_owned),
            ..plain(&ids, Channel::ExecutedVelocity, fall, ids.len())
        }
    };
    let tied = rival.is_tie().then_some(winner);
    vec![one(winner, 0.0, None), one(loser, behind, tied)]
}

/// For each rival of one of several effects: that effect and the rival, both beside the other effects.
fn in_place(stages: &Stages) -> Vec<Ranked> {
    let rivals = stages.wrench.iter().flat_map(|found| &found.found.rivals);
    let fitted = stages.logs.fitted;
    let much = stages.wrench.iter().any(|found| {
        let accepted = found.found.accepted.as_ref();
        accepted.is_some_and(|accepted| found.prepared.has_much_left(accepted.gain))
    });
    let each = rivals.flat_map(move |rival| {
        let sum = |gains: &[f64]| gains.iter().sum::<f64>();
        let (own, others) = (sum(&rival.gain), sum(&rival.gain_of_rival));
        // Where more than noise is left, errors of form may be as large as the difference.
        let tie = own - others < TOLD_APART || (much && others > NEARLY_AS_GOOD * own);
        let as_good_as = tie.then(|| rival.of.to_owned());
        [
            (rival.of, &rival.gain, None),
            (rival.id, &rival.gain_of_rival, as_good_as),
        ]
        .map(|(id, gain, as_good_as)| Ranked {
            beside: rival.beside.clone(),
            as_good_as,
            ..plain(&[id], Channel::Wrench, fall(gain, fitted), 1)
        })
    });
    each.collect()
}

/// Hypotheses to report: the best of the first round, fewer of each later round and of refused ones, and always those with most
/// effects of the answer on their channel.
pub(crate) fn reported(all: &[Ranked], answer: &[String]) -> Vec<Ranked> {
    let first = all.iter().map(|one| one.beside.len()).min();
    let mut counts: BTreeMap<(usize, bool), usize> = BTreeMap::new();
    let named = |one: &Ranked| {
        let all = one.effects.iter().all(|id| answer.contains(id));
        if all { one.effects.len() } else { 0 }
    };
    let most_named = |channel: Channel| {
        let of_channel = all.iter().filter(|one| one.channel == channel);
        of_channel.map(named).max().unwrap_or(0).max(1)
    };
    let is_reported = |one: &&Ranked| {
        let (round, is_refused) = (one.beside.len(), one.refused.is_some());
        let most = match Some(round) == first && !is_refused {
            true => REPORTED,
            false => REPORTED_LATER,
        };
        let count = counts.entry((round, is_refused)).or_default();
        *count += 1;
        *count <= most || named(one) == most_named(one.channel)
    };
    all.iter().filter(is_reported).cloned().collect()
}

/// Ids of general curves (phenomenological shapes) among the hypotheses on the reading.
pub(crate) fn general_curves(stages: &Stages) -> Vec<String> {
    let Some(found) = &stages.wrench else {
        return Vec::new();
    };
    let ids = found.found.ranked.iter().flat_map(|t| t.ids());
    let ids: BTreeSet<String> = ids.filter(|id| is_general_curve(id)).collect();
    ids.into_iter().collect()
}

/// Effects of the likeliest hypothesis with a given curve, and those of earlier rounds, which are added with it.
pub(crate) fn with_general_curve(stages: &Stages, curve: &str) -> Vec<String> {
    let Some(found) = &stages.wrench else {
        return Vec::new();
    };
    let likeliest = found.likeliest_with(|id| id == curve);
    let earlier = found.earlier.0.iter().map(|one| one.id.to_owned());
    let mut all: Vec<String> = Vec::new();
    for id in earlier.chain(likeliest.iter().flat_map(|one| one.ids())) {
        // What was found earlier may have been found again with the curve.
        if !all.contains(&id) {
            all.push(id);
        }
    }
    all
}
