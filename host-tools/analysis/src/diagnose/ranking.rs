//! Hypotheses with their evidence, and the closest rival of what is named.

use super::actuator::Candidate;
use super::clock::Jitter;
use super::engine::{Stages, WrenchFinding, is_shape};
use super::evidence;
use super::finding::{Experiment, Ranked, RunnerUp, StrongestEvidence, Tie};
use super::named::NEARLY_AS_GOOD;
use super::rivals::ClockRival;
use super::wrench::Tested;
use softdock_physics::effects::by_id;
use softdock_physics::model::Channel;
use std::collections::{BTreeMap, BTreeSet};

/// χ² by which a rival has to be behind to be told apart.
const TOLD_APART: f64 = 12.0;
/// Hypotheses that are reported.
const REPORTED: usize = 12;
/// Hypotheses that are reported of each later round.
const REPORTED_LATER: usize = 4;

/// Hypotheses of all stages with their evidence.
pub(super) fn ranked(stages: &Stages) -> Vec<Ranked> {
    let mut all = Vec::new();
    let fitted = stages.logs.fitted;
    let fit = |gains: &[f64]| gains.iter().take(fitted).sum::<f64>();
    let unseen = |gains: &[f64]| gains.iter().skip(fitted).sum::<f64>();
    if let Some(found) = &stages.actuator {
        let pair = found.search.accepted.iter().filter(|c| c.ids().len() > 1);
        let gains = |c: &Candidate| -> Vec<f64> {
            let both = found.search.nominal.each.iter().zip(&c.each);
            both.map(|(nominal, own)| nominal - own).collect()
        };
        for candidate in pair.chain(&found.search.singles) {
            all.push(Ranked {
                effects: candidate.ids().into_iter().map(str::to_owned).collect(),
                beside: Vec::new(),
                channel: Channel::ExecutedVelocity,
                gain_train: fit(&gains(candidate)),
                gain_test: unseen(&gains(candidate)),
                parameters: candidate.parameters(),
                as_good_as: None,
                refused: None,
            });
        }
    }
    all.extend(in_place(stages));
    for body in &stages.body.accepted {
        all.push(Ranked {
            effects: vec![body.id.to_owned()],
            beside: Vec::new(),
            channel: Channel::ModelVelocity,
            gain_train: fit(&body.gains),
            gain_test: unseen(&body.gains),
            parameters: body.parameters.len(),
            as_good_as: None,
            refused: None,
        });
    }
    all.extend(
        stages
            .clock_rivals
            .iter()
            .flat_map(|r| against_the_clock(r, stages)),
    );
    if let Some(Jitter { gain, .. }) = stages.clock.jitter {
        all.push(Ranked {
            effects: vec!["clock_jitter".to_owned()],
            beside: Vec::new(),
            channel: Channel::Pose,
            gain_train: gain,
            gain_test: 0.0,
            parameters: 1,
            as_good_as: None,
            refused: None,
        });
    }
    // By the price by which the search decides, so that what is named stands before what only fits a
    // little better with more effects.
    let price = evidence::price(stages.logs.all.iter().map(|log| log.cycle_count()).sum());
    let worth = |r: &Ranked| {
        let paid = price * r.parameters as f64 + evidence::prior() * r.effects.len() as f64;
        fall(r) - paid
    };
    let mut all: Vec<(f64, Ranked)> = all.into_iter().map(|r| (worth(&r), r)).collect();
    all.extend(stages.wrench.iter().flat_map(|w| of_wrench(w, fitted)));
    all.sort_by(|(a, one), (b, other)| {
        let refused = |r: &Ranked| r.refused.is_some();
        refused(one).cmp(&refused(other)).then(b.total_cmp(a))
    });
    let mut seen: Vec<(Vec<String>, Vec<String>)> = Vec::new();
    let mut all: Vec<Ranked> = all.into_iter().map(|(_, one)| one).collect();
    all.retain(|one| {
        let key = (one.effects.clone(), one.beside.clone());
        let new = !seen.contains(&key);
        seen.push(key);
        new
    });
    all.retain(|one| fall(one) > 10.0);
    shortened(all)
}

/// Fall of χ² over all logs.
fn fall(ranked: &Ranked) -> f64 {
    ranked.gain_train + ranked.gain_test
}

/// Hypotheses on the reading, with their evidence.
fn of_wrench(stage: &WrenchFinding, fitted: usize) -> impl Iterator<Item = (f64, Ranked)> {
    let ranked = &stage.found.ranked;
    // As it was tried beside the others, with their noise.
    let accepted = stage.found.accepted.as_ref().map(Tested::effects_in_order);
    let answer = ranked
        .iter()
        .find(|t| accepted.as_ref() == Some(&t.effects_in_order()));
    let answer = answer.filter(|_| stage.left().is_structured());
    let error = |tested: &Tested| stage.prepared.error_on_unseen(tested);
    let of = move |tested: &Tested| {
        let forbidden = tested.wrong.join(", ");
        let ranked = Ranked {
            effects: tested.ids(),
            beside: tested.beside.clone(),
            channel: Channel::Wrench,
            gain_train: tested.gains.iter().take(fitted).sum(),
            gain_test: tested.gains.iter().skip(fitted).sum(),
            parameters: tested.parameters,
            as_good_as: answer.and_then(|answer| foretells_alike(answer, tested, &error)),
            refused: (!forbidden.is_empty()).then(|| format!("physics forbids {forbidden}")),
        };
        (tested.evidence, ranked)
    };
    ranked.iter().map(of)
}

/// The effect of an answer that has another in its place in a hypothesis, if that foretells the unseen logs as well and
/// explains nearly as much: beside what no law describes the form of an error decides between such two, not the noise.
fn foretells_alike(
    answer: &Tested,
    tested: &Tested,
    error: &dyn Fn(&Tested) -> f64,
) -> Option<String> {
    let [named, ids] = [answer, tested].map(Tested::effects_in_order);
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
pub(super) fn strongest(stages: &Stages) -> StrongestEvidence {
    let wrench = stages.wrench.as_ref();
    StrongestEvidence {
        actuator: stages.actuator.as_ref().and_then(|a| a.strongest),
        wrench: wrench.and_then(|w| strongest_of(&w.found.ranked)),
        body: stages.body.strongest,
    }
}

/// The largest evidence of an effect beside those that it was tried with: as in the decision, two
/// count for what the pair has beyond the better one of them alone.
fn strongest_of(ranked: &[Tested]) -> Option<f64> {
    let possible = || ranked.iter().filter(|t| t.wrong.is_empty());
    let of_last = |pair: &Tested| {
        let ids = pair.ids();
        let fewer =
            |t: &&Tested| t.effects.len() < ids.len() && t.ids().iter().all(|id| ids.contains(id));
        let alone = possible().filter(fewer).map(|t| t.evidence);
        pair.evidence - alone.fold(0.0, f64::max)
    };
    possible().map(of_last).max_by(f64::total_cmp)
}

/// An error of the clock and the stage of the actuator that it looks like, the believed one first, each with what
/// the actuator has besides.
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
    let fitted = stages.logs.fitted;
    let train: f64 = rival.gain.iter().take(fitted).sum();
    let test: f64 = rival.gain.iter().skip(fitted).sum();
    let one = |id: &str, behind: f64, as_good_as: Option<&str>| {
        let mut ids: Vec<&str> = besides.iter().copied().chain([id]).collect();
        ids.sort_unstable();
        // By how much one is behind is known of all logs together.
        let share = 1.0 - behind / (train + test).max(behind).max(f64::MIN_POSITIVE);
        Ranked {
            parameters: ids.len(),
            effects: ids.into_iter().map(str::to_owned).collect(),
            beside: Vec::new(),
            channel: Channel::ExecutedVelocity,
            gain_train: share * train,
            gain_test: share * test,
            as_good_as: as_good_as.map(str::to_owned),
            refused: None,
        }
    };
    let tied = rival.is_tie().then_some(winner);
    vec![one(winner, 0.0, None), one(loser, behind, tied)]
}

/// Rivals of one of several effects, and the effect itself, both beside the others.
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
        // Where more is left than noise, the error of form that is left can be of the difference's
        // size.
        let tie = own - others < TOLD_APART || (much && others > NEARLY_AS_GOOD * own);
        let as_good_as = tie.then(|| rival.of.to_owned());
        [
            (rival.of, &rival.gain, None),
            (rival.id, &rival.gain_of_rival, as_good_as),
        ]
        .map(|(id, gain, as_good_as)| Ranked {
            effects: vec![id.to_owned()],
            beside: rival.beside.clone(),
            channel: Channel::Wrench,
            gain_train: gain.iter().take(fitted).sum(),
            gain_test: gain.iter().skip(fitted).sum(),
            parameters: 1,
            as_good_as,
            refused: None,
        })
    });
    each.collect()
}

/// The best of the first round, and fewer of each later one, which gain less.
fn shortened(all: Vec<Ranked>) -> Vec<Ranked> {
    let first = all.iter().map(|one| one.beside.len()).min();
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    let mut kept = Vec::new();
    for one in all {
        let round = one.beside.len();
        let most = if Some(round) == first {
            REPORTED
        } else {
            REPORTED_LATER
        };
        let count = counts.entry(round).or_default();
        *count += 1;
        if *count <= most {
            kept.push(one);
        }
    }
    kept
}

/// The closest rival of what is named: one that explains as much in the place of a named effect, else
/// the one that is the least behind in such a place.
pub(super) fn runner_up(named: &[String], ranked: &[Ranked]) -> Option<RunnerUp> {
    let tie = ranked.iter().find_map(|rival| {
        let of = rival.as_good_as.as_ref().filter(|of| named.contains(of))?;
        let other = rival.effects.iter().find(|id| !named.contains(id))?;
        let with_it = |r: &&Ranked| {
            let back = rival
                .effects
                .iter()
                .map(|id| if id == other { of } else { id });
            let back: BTreeSet<&String> = back.collect();
            r.beside == rival.beside && r.effects.iter().collect::<BTreeSet<_>>() == back
        };
        Some((of, ranked.iter().find(with_it)?, rival, other))
    });
    let (of, winner, rival, other) = tie.or_else(|| {
        let less = |place: &InPlace<'_>| fall(place.1) - fall(place.2);
        let each = named
            .iter()
            .flat_map(|id| in_the_place_of(id, named, ranked));
        each.min_by(|a, b| less(a).total_cmp(&less(b)))
    })?;
    let others = in_the_place_of(of, named, ranked).into_iter();
    let mut ties: Vec<Tie> = Vec::new();
    for (_, winner, rival, effect) in others {
        let is_new = effect != other && ties.iter().all(|tie| tie.effect != *effect);
        if is_new && !is_told_apart(winner, rival) && does_as_much(of, winner, rival, ranked) {
            ties.push(Tie {
                effect: effect.clone(),
                behind: behind(winner, rival),
                evidence: evidence_against(winner, rival),
            });
        }
    }
    Some(RunnerUp {
        effect: other.clone(),
        of: of.clone(),
        behind: behind(winner, rival),
        told_apart: is_told_apart(winner, rival),
        evidence: evidence_against(winner, rival),
        ties,
    })
}

/// By how much less χ² falls with a rival. What fits a little better, and was not taken for other reasons, ties.
fn behind(winner: &Ranked, rival: &Ranked) -> f64 {
    (fall(winner) - fall(rival)).max(0.0)
}

fn is_told_apart(winner: &Ranked, rival: &Ranked) -> bool {
    rival.as_good_as.is_none() && behind(winner, rival) > by_form(winner)
}

/// χ² that tells a rival from what explains so much: more than noise makes, and than an error of the form of a law.
fn by_form(winner: &Ranked) -> f64 {
    TOLD_APART.max(evidence::LAW * fall(winner))
}

/// Evidence against a rival, beside which errors of form are what noise is where there are none.
fn evidence_against(winner: &Ranked, rival: &Ranked) -> f64 {
    let behind = behind(winner, rival);
    let by_form = match rival.as_good_as.is_some() && behind > TOLD_APART {
        // Where more is left than noise.
        true => (1.0 - NEARLY_AS_GOOD) * fall(winner),
        false => by_form(winner),
    };
    behind * TOLD_APART / by_form.max(TOLD_APART)
}

/// A named effect, a hypothesis with it, the one with another effect in its place, and that effect.
type InPlace<'a> = (&'a String, &'a Ranked, &'a Ranked, &'a String);

/// The best hypothesis of most effects with one and nothing that is not named for which any with another effect in its place
/// was tried, with each of these.
fn in_the_place_of<'a>(id: &'a String, named: &[String], ranked: &'a [Ranked]) -> Vec<InPlace<'a>> {
    let is_named = |r: &&Ranked| r.effects.iter().all(|e| named.contains(e));
    let with_it = ranked.iter().filter(is_named);
    let with_it = with_it.filter(|r| r.effects.contains(id) && explains(id, r, ranked));
    // What is left to fewer of them, others may explain.
    let with_it: Vec<&Ranked> = with_it.collect();
    let most = with_it.iter().map(|r| r.effects.len()).max();
    let with_it = with_it
        .into_iter()
        .filter(|r| Some(r.effects.len()) == most);
    let rivals_of = |winner: &'a Ranked| {
        let alike = move |r: &&Ranked| r.channel == winner.channel && r.beside == winner.beside;
        let others = ranked.iter().filter(|r| r.refused.is_none()).filter(alike);
        others.filter_map(move |r| {
            let other = r.effects.iter().find(|e| !named.contains(e))?;
            let ties = r.as_good_as.as_ref() == Some(id);
            let is_excluded =
                is_in_another(other, id, named) || (!ties && takes_another_place(other, id, named));
            if is_shape(other) || is_excluded {
                return None;
            }
            if !ties && is_refused_by_its_price(r, winner, other, id) {
                return None;
            }
            let kept = |e: &String| e == id || r.effects.contains(e);
            let exchanged = r.effects.len() == winner.effects.len();
            (exchanged && winner.effects.iter().all(kept)).then_some((id, winner, r, other))
        })
    };
    let mut pairs: Vec<InPlace<'a>> = with_it.flat_map(rivals_of).collect();
    let best = pairs.iter().map(|place| fall(place.1)).fold(0.0, f64::max);
    pairs.retain(|place| fall(place.1) >= best);
    pairs
}

/// Whether an effect contains a named one other than `id`, or is of its kind: it is that one's rival.
fn takes_another_place(other: &str, id: &str, named: &[String]) -> bool {
    let Some(other) = by_id(other) else {
        return false;
    };
    let contains = |name: &str| other.detail_of.iter().any(|(of, _)| *of == name);
    let alike =
        |name: &str| other.kind.is_some() && by_id(name).is_some_and(|e| e.kind == other.kind);
    let others = named.iter().filter(|name| *name != id);
    others.into_iter().any(|name| contains(name) || alike(name))
}

/// Whether a rival has more parameters, and neither fits better for it nor is within an error of form of the winner: what has all
/// that the winner has always is.
fn is_refused_by_its_price(rival: &Ranked, winner: &Ranked, other: &str, id: &str) -> bool {
    let further = rival.parameters.saturating_sub(winner.parameters) as f64;
    let better = fall(rival) - fall(winner);
    let is_form = winner.channel == Channel::Wrench && !is_more_than(other, id);
    let by_form = is_form && further * TOLD_APART - better <= evidence::LAW * fall(winner);
    further > 0.0 && better < TOLD_APART && !by_form
}

/// Whether an effect contains another, or is of its kind: with more parameters it fits as well by itself.
fn is_more_than(other: &str, id: &str) -> bool {
    by_id(other).zip(by_id(id)).is_some_and(|(other, one)| {
        let is_kin = other.kind.is_some() && other.kind == one.kind;
        is_kin || other.detail_of.iter().any(|(of, _)| *of == id)
    })
}

/// Whether a named one other than `id` contains an effect: beside it that one is no effect of its own.
fn is_in_another(other: &str, id: &str, named: &[String]) -> bool {
    let others = named.iter().filter(|name| *name != id);
    let mut details = others.filter_map(|name| Some(by_id(name)?.detail_of));
    details.any(|detail_of| detail_of.iter().any(|(of, _)| *of == other))
}

/// Whether a rival does half of what an effect does beside the others: else it is behind by little because neither does much.
fn does_as_much(id: &str, winner: &Ranked, rival: &Ranked, ranked: &[Ranked]) -> bool {
    let rest = without_it(id, winner, ranked);
    fall(rival) - rest > 0.5 * (fall(winner) - rest)
}

/// Whether an effect explains anything beside the others of a hypothesis: what explains nothing there has rivals in
/// everything.
fn explains(id: &str, with_it: &Ranked, ranked: &[Ranked]) -> bool {
    fall(with_it) - without_it(id, with_it, ranked) > TOLD_APART
}

/// Fall of χ² with the others of a hypothesis, 0 where it was not tried.
fn without_it(id: &str, with_it: &Ranked, ranked: &[Ranked]) -> f64 {
    let rest: Vec<&String> = with_it.effects.iter().filter(|e| *e != id).collect();
    let is_rest = |r: &&Ranked| {
        r.beside == with_it.beside
            && r.effects.len() == rest.len()
            && rest.iter().all(|e| r.effects.contains(e))
    };
    ranked.iter().find(is_rest).map_or(0.0, fall)
}

/// What the catalogue says tells an effect and its rival apart; `first` where there is no rival.
pub(super) fn experiment(first: Option<&String>, rival: &RunnerUp) -> Option<Experiment> {
    let effect = by_id(&rival.of).or_else(|| by_id(first?))?;
    Some(Experiment {
        sentence: effect.tell_apart.to_owned(),
        separation_now: rival.behind,
        separation_then: None,
        command: format!("softdock demo --effect {}", effect.id),
    })
}

/// Phenomenological shapes that would fit.
pub(super) fn shapes(stages: &Stages) -> Vec<String> {
    let Some(found) = &stages.wrench else {
        return Vec::new();
    };
    let ids = found.found.ranked.iter().flat_map(|t| t.ids());
    let ids: BTreeSet<String> = ids.filter(|id| is_shape(id)).collect();
    ids.into_iter().collect()
}
