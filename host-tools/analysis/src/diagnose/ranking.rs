//! Hypotheses with their evidence, and the closest rival of what is named.

use super::engine::{Stages, is_shape};
use super::finding::{Experiment, Ranked, RunnerUp};
use super::rivals::ClockRival;
use crate::model::Channel;
use std::collections::BTreeMap;

/// χ² by which a rival has to be behind to be told apart.
const TOLD_APART: f64 = 12.0;
/// Hypotheses that are reported.
const REPORTED: usize = 12;
/// Hypotheses that are reported of each later round.
const REPORTED_LATER: usize = 4;

/// Hypotheses of all stages with their evidence.
pub(super) fn ranked(stages: &Stages) -> Vec<Ranked> {
    let mut all = Vec::new();
    if let Some(found) = &stages.actuator {
        let nominal = found.search.nominal;
        let pair = found.search.accepted.iter().filter(|c| c.terms.len() > 1);
        for candidate in pair.chain(&found.search.singles) {
            all.push(Ranked {
                effects: candidate
                    .terms
                    .iter()
                    .map(|t| t.stage.id().to_owned())
                    .collect(),
                beside: Vec::new(),
                channel: Channel::ExecutedVelocity,
                gain_train: nominal.0 - candidate.train,
                gain_test: nominal.1 - candidate.test,
                parameters: candidate.terms.iter().map(|t| t.values.len()).sum(),
                as_good_as: None,
                refused: None,
            });
        }
    }
    if let Some(found) = &stages.wrench {
        for tested in &found.found.ranked {
            let wrong = (!tested.wrong.is_empty())
                .then(|| format!("physics forbids {}", tested.wrong.join(", ")));
            all.push(Ranked {
                effects: tested.ids(),
                beside: tested.beside.clone(),
                channel: Channel::Wrench,
                gain_train: tested.gain,
                gain_test: tested.gain_test,
                parameters: tested.parameters,
                as_good_as: None,
                refused: wrong,
            });
        }
    }
    all.extend(in_place(stages));
    for fit in &stages.body {
        all.push(Ranked {
            effects: vec![fit.id.to_owned()],
            beside: Vec::new(),
            channel: Channel::ModelVelocity,
            gain_train: fit.gain.0,
            gain_test: fit.gain.1,
            parameters: fit.parameters.len(),
            as_good_as: None,
            refused: None,
        });
    }
    all.extend(stages.clock_rivals.iter().flat_map(against_the_clock));
    if let Some((_, gain)) = stages.clock.jitter {
        all.push(Ranked {
            effects: vec!["clock_jitter".to_owned()],
            beside: Vec::new(),
            channel: Channel::Pose,
            gain_train: gain.0,
            gain_test: gain.1,
            parameters: 1,
            as_good_as: None,
            refused: None,
        });
    }
    for one in &mut all {
        if one.refused.is_none() && one.gain_train > 40.0 && one.gain_test < 0.15 * one.gain_train {
            one.refused =
                Some("what it gains on the fitted log it loses on unseen data".to_owned());
        }
    }
    all.sort_by(|a, b| b.gain_train.total_cmp(&a.gain_train));
    let mut seen: Vec<(Vec<String>, Vec<String>)> = Vec::new();
    all.retain(|one| {
        let key = (one.effects.clone(), one.beside.clone());
        let new = !seen.contains(&key);
        seen.push(key);
        new
    });
    all.retain(|one| one.gain_train > 10.0);
    shortened(all)
}

/// An error of the clock and the stage of the actuator that it looks like, the believed one first.
fn against_the_clock(rival: &ClockRival) -> Vec<Ranked> {
    let behind = (rival.better.0.abs(), rival.better.1.abs());
    let (winner, loser) = if rival.believed {
        (rival.id, rival.of)
    } else {
        (rival.of, rival.id)
    };
    let one = |id: &str, behind: (f64, f64), as_good_as: Option<&str>| Ranked {
        effects: vec![id.to_owned()],
        beside: Vec::new(),
        channel: Channel::ExecutedVelocity,
        gain_train: rival.gain.0 - behind.0,
        gain_test: rival.gain.1 - behind.1,
        parameters: 1,
        as_good_as: as_good_as.map(str::to_owned),
        refused: None,
    };
    let tied = rival.is_tie().then_some(winner);
    vec![one(winner, (0.0, 0.0), None), one(loser, behind, tied)]
}

/// Rivals of one of several effects, and the effect itself, both beside the others.
fn in_place(stages: &Stages) -> Vec<Ranked> {
    let rivals = stages.wrench.iter().flat_map(|found| &found.found.rivals);
    let each = rivals.flat_map(|rival| {
        let as_good_as = rival.is_as_good.then(|| rival.of.to_owned());
        [
            (rival.of, rival.gain, None),
            (rival.id, rival.gain_of_rival, as_good_as),
        ]
        .map(|(id, gain, as_good_as)| Ranked {
            effects: vec![id.to_owned()],
            beside: rival.beside.clone(),
            channel: Channel::Wrench,
            gain_train: gain.0,
            gain_test: gain.1,
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

/// The best rival of what is named: one that explains as much in the place of a named effect, else
/// the best single hypothesis in the place of the first, `id`, against the best one with that and
/// nothing that is not named.
pub(super) fn runner_up(id: &str, named: &[String], ranked: &[Ranked]) -> Option<RunnerUp> {
    let tie = ranked.iter().find_map(|rival| {
        let of = rival.as_good_as.as_ref().filter(|of| named.contains(of))?;
        let alone = |r: &&Ranked| r.beside == rival.beside && r.effects == [of.clone()];
        Some((ranked.iter().find(alone)?, rival))
    });
    let (winner, rival) = tie.or_else(|| {
        let is_named = |r: &&Ranked| r.effects.iter().all(|e| named.contains(e));
        let with_it = ranked.iter().filter(is_named);
        let winner = with_it
            .filter(|r| r.effects.iter().any(|e| e == id))
            .max_by(|a, b| a.gain_train.total_cmp(&b.gain_train))?;
        let rival = ranked.iter().find(|r| {
            r.effects.len() == 1
                && r.channel == winner.channel
                && r.beside == winner.beside
                && !named.contains(&r.effects[0])
                && r.refused.is_none()
        })?;
        Some((winner, rival))
    })?;
    // What fits a little better, and was not taken for other reasons, ties.
    let behind = (winner.gain_train - rival.gain_train).max(0.0);
    Some(RunnerUp {
        effect: rival.effects[0].clone(),
        of: winner.effects[0].clone(),
        behind,
        told_apart: behind > TOLD_APART && rival.as_good_as.is_none(),
    })
}

/// What the catalogue says tells an effect and its rival apart; `first` where there is no rival.
pub(super) fn experiment(first: Option<&String>, rival: &RunnerUp) -> Option<Experiment> {
    let effect = softdock_control::effects::by_id(&rival.of)
        .or_else(|| softdock_control::effects::by_id(first?))?;
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
    ids.filter(|id| is_shape(id)).collect()
}
