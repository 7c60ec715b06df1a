//! The parameters that foretell best.
//!
//! Names are decided by the likelihood of the noise as it is, which weighs a slow error less where the noise is slow. Where a
//! law's form is wrong, that likelihood fits the parameters to the fast part of what is left, and others foretell the wrench
//! better: those of least squares, in which each error counts as it is.

use super::engine::{Stages, is_shape, predict_all};
use super::error_reduction::with_effects;
use super::evidence::{FORETELLS, RISES};
use super::logs::Logs;
use super::named::{self, Named};
use super::ranking::foretells_alike;
use super::wrench::Tested;
use super::wrench_finding::WrenchFinding;
use crate::fit::refit_effects;
use crate::levels::ChannelLevels;
use softdock_io::recording::Recording;
use softdock_physics::effects::{Kind, by_id};
use softdock_physics::model::load::effects::{LEVEL, LoadEffect};
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Channel, Model};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Effects with other parameters, and the error on unseen data before and with them.
pub(super) type Better = (Vec<Named>, [f64; 2]);

/// The effects with the parameters of least squares, if these foretell unseen data better. Each interval holds what both
/// likelihoods say; `in_rounds`: what least squares say, as some were found while others were held, beside which what is known of these
/// was too much or too little.
pub(super) fn refit(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[Named],
    in_rounds: bool,
) -> anyhow::Result<Option<Better>> {
    if named.is_empty() {
        return Ok(None);
    }
    let before = Errors::of(model, recordings, named)?;
    let refitted = by_least_squares(model, recordings, named, in_rounds)?;
    let after = Errors::of(model, recordings, &refitted)?;
    let is_better = after.unseen * RISES < before.unseen; // not so for NaN
    Ok(is_better.then_some((refitted, [before.unseen, after.unseen])))
}

/// The same with the dry frictions among them turning round over the speed with which all leave least of the logs of the fit, if
/// that foretells unseen data better, too. How sharp a reversal is shows in the fast part of a reading, where the likelihood has
/// other errors of form to fit to. `speed`: the usual one.
pub(super) fn with_reversals(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[Named],
    speed: f64,
) -> anyhow::Result<Option<Better>> {
    let frictions = each_friction(named);
    if frictions.is_empty() {
        return Ok(None);
    }
    let before = Errors::of(model, recordings, named)?;
    let as_found = by_least_squares(model, recordings, named, false)?;
    let as_found = Errors::of(model, recordings, &as_found)?;
    let best = best_reversal(model, recordings, frictions, speed, false, as_found.of_fit)?;
    let is_better = |errors: &Errors| errors.unseen * RISES < before.unseen.min(as_found.unseen);
    let best = best.filter(|(_, errors)| is_better(errors));
    Ok(best.map(|(named, after)| (named, [before.unseen, after.unseen])))
}

/// The same with what moves the reading in time, beside them or in the place of one of them that is no dry friction, and with the
/// reversals that are best beside that. A reading that is late makes a reversal look round, and where the likelihood has a sharp one,
/// or a spring, whose force is in quadrature with the velocity, nothing looks late. In the place of another it has to leave and to
/// foretell less; with a parameter more, by so much less as decides without a likelihood; and a curve in its place has to leave more. `late`: effects of one parameter, and the end up to which
/// a search looks for it: what is later is something else.
pub(super) fn with_what_is_late(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[Named],
    wrench: &WrenchFinding,
    late: &[(&LoadEffect, f64)],
) -> anyhow::Result<Option<Better>> {
    /// From here least squares find what is late by 5 to 50 ms, s.
    const START_S: f64 = 0.01;
    if late.is_empty() || each_friction(named).is_empty() {
        return Ok(None);
    }
    let before = Errors::of(model, recordings, named)?;
    let places = (0..named.len()).filter(|k| !is_dry(&named[*k].effect.id));
    let sets: Vec<(Vec<Named>, f64)> = places
        .map(|gone| (without(named, gone), RISES))
        .chain([(named.to_vec(), FORETELLS)])
        .collect();
    let speed = wrench.prepared.pace().speed;
    let (mut least, mut best) = (f64::INFINITY, None);
    for (others, margin) in &sets {
        for (effect, end) in late {
            let [parameter] = effect.parameters[..] else {
                continue;
            };
            let late = Named::new(effect.id, Vec::new());
            let late = late.with(parameter.name, (START_S, 0.0), parameter.unit);
            let both: Vec<Named> = others.iter().cloned().chain([late]).collect();
            let least_of_it = least.min(before.of_fit / margin);
            let frictions = each_friction(&both);
            let with_it = best_reversal(model, recordings, frictions, speed, true, least_of_it)?;
            let value =
                |named: &[Named]| named.last()?.effect.parameters.get(parameter.name).copied();
            if let Some((named, errors)) = with_it
                && errors.unseen * margin < before.unseen
                && value(&named).is_some_and(|value| value < *end)
            {
                least = errors.of_fit;
                best = Some((named, errors));
            }
        }
    }
    let Some((best, errors)) = best else {
        return Ok(None);
    };
    // What builds up after each reversal is late as well.
    let is_a_curve = match with_a_curve(wrench) {
        Some(curve) => {
            let curve = by_least_squares(model, recordings, &curve, true)?;
            let curve = Errors::of(model, recordings, &curve)?;
            curve.of_fit < errors.of_fit && curve.unseen < errors.unseen
        }
        None => false,
    };
    Ok((!is_a_curve).then_some((best, [before.unseen, errors.unseen])))
}

/// The likeliest hypothesis with a curve that fits many mechanisms.
fn with_a_curve(wrench: &WrenchFinding) -> Option<Vec<Named>> {
    let has_one = |tested: &&Tested| tested.effects.iter().any(|one| is_shape(one.id));
    let with_it = wrench.found.ranked.iter().filter(has_one);
    let likeliest = with_it.max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    let all = wrench.earlier.0.iter().chain(&likeliest.effects);
    Some(all.map(named::of_reading).collect())
}

fn without(named: &[Named], gone: usize) -> Vec<Named> {
    let others = named.iter().enumerate().filter(|(k, _)| *k != gone);
    others.map(|(_, one)| one.clone()).collect()
}

fn is_dry(id: &str) -> bool {
    by_id(id).and_then(|effect| effect.kind) == Some(Kind::DryFriction)
}

/// The reversal of a friction with which least squares leave least of the logs of the fit, if that is less than `least`; `anew`:
/// there are many sets, and what was said before is no other opinion on the amounts.
fn best_reversal(
    model: &Model,
    recordings: &Logs<&Recording>,
    frictions: Vec<(usize, Vec<Named>)>,
    speed: f64,
    anew: bool,
    mut least: f64,
) -> anyhow::Result<Option<(Vec<Named>, Errors)>> {
    /// Halvings of the speed with which a friction has its level at the usual one, from one with which it is sharp; of many
    /// sets fewer are tried.
    const HALVINGS: &[i32] = &[5, 4, 3, 2, 1, 0];
    const FEWER: &[i32] = &[4, 2, 0];
    let turning = |named: &[Named], k: usize, speed: f64| {
        let mut others = named.to_vec();
        let Some(turning) = others[k].clone().turning_over(model, speed) else {
            return Ok(None);
        };
        others[k] = turning;
        let others = by_least_squares(model, recordings, &others, anew)?;
        let errors = Errors::of(model, recordings, &others)?;
        Ok::<_, anyhow::Error>(Some((others, errors)))
    };
    let mut best = None;
    for (k, named) in frictions {
        let (mut last, mut rises, mut before) = (f64::INFINITY, 0, named);
        let (mut tried, mut best_speed) = (Vec::new(), None);
        // From sharp ones, beyond which most leave more and more.
        for halvings in if anew { FEWER } else { HALVINGS } {
            let speed = speed / LEVEL * 0.5_f64.powi(*halvings);
            let Some((others, errors)) = turning(&before, k, speed)? else {
                continue;
            };
            rises = if errors.of_fit > last { rises + 1 } else { 0 };
            last = errors.of_fit;
            before.clone_from(&others);
            tried.push((others, errors));
            if last < least {
                least = last;
                best_speed = Some(speed);
            } else if rises > 1 {
                break;
            }
        }
        let Some(speed) = best_speed else {
            continue;
        };
        // Between two of them.
        let twice = [0.5, 2.0].into_iter().filter(|_| anew);
        for beside in twice.chain([FRAC_1_SQRT_2, SQRT_2]) {
            tried.extend(turning(&before, k, beside * speed)?);
        }
        best = with_all_as_good(tried);
        least = best.as_ref().map_or(least, |(_, errors)| errors.of_fit);
    }
    Ok(best)
}

/// What leaves least, with intervals that hold what all say that the logs do not refuse: those that leave as little, but for what
/// noise makes, and those that leave little more and foretell better.
fn with_all_as_good(mut tried: Vec<(Vec<Named>, Errors)>) -> Option<(Vec<Named>, Errors)> {
    tried.sort_by(|a, b| a.1.of_fit.total_cmp(&b.1.of_fit));
    let mut tried = tried.into_iter();
    let (mut best, errors) = tried.next()?;
    let is_as_good = |(_, other): &(Vec<Named>, Errors)| {
        let worse = other.of_fit / errors.of_fit;
        worse < RISES || (worse < FORETELLS && other.unseen < errors.unseen)
    };
    for (others, _) in tried.filter(is_as_good) {
        let both = best.iter_mut().zip(&others);
        both.for_each(|(one, other)| one.hold(other));
    }
    Some((best, errors))
}

/// Ids of what has one effect in the place of another that the logs of the fit do not tell from it, with no more parameters, if
/// that foretells unseen data better than what the likelihood prefers: beside what no law describes, errors of form decide between
/// the two there.
pub(super) fn better_tie(
    model: &Model,
    recordings: &Logs<&Recording>,
    stages: &Stages,
) -> anyhow::Result<Option<Vec<String>>> {
    let ties = stages.wrench.as_ref().map_or(Vec::new(), no_larger_ties);
    if ties.is_empty() {
        return Ok(None);
    }
    let named = named::all(model, stages);
    let (mut least, mut best) = (foretold(model, recordings, &named)? / RISES, None);
    for tie in ties {
        let mut others = named.clone();
        let accepted = stages.wrench.iter().flat_map(|w| &w.found.accepted);
        let accepted: Vec<String> = accepted.flat_map(Tested::ids).collect();
        others.retain(|one| !accepted.contains(&one.effect.id));
        others.extend(tie.effects.iter().map(named::of_reading));
        let error = foretold(model, recordings, &others)?;
        if error < least {
            least = error;
            best = Some(others.into_iter().map(|one| one.effect.id).collect());
        }
    }
    Ok(best)
}

/// Error on unseen data with the parameters of least squares.
fn foretold(model: &Model, recordings: &Logs<&Recording>, named: &[Named]) -> anyhow::Result<f64> {
    let named = by_least_squares(model, recordings, named, false)?;
    Ok(Errors::of(model, recordings, &named)?.unseen)
}

/// Hypotheses with another effect in the place of one of the answer, not told from it and with no more parameters.
fn no_larger_ties(wrench: &WrenchFinding) -> Vec<Tested> {
    let ranked = &wrench.found.ranked;
    let accepted = wrench.found.accepted.as_ref();
    let answer = accepted.and_then(|accepted| ranked.iter().find(|t| t.is_same(accepted)));
    let Some(answer) = answer.filter(|_| wrench.can_foretell() && wrench.left().is_structured())
    else {
        return Vec::new();
    };
    let error = |tested: &Tested| wrench.prepared.error_on_unseen(tested);
    let alike = ranked.iter().filter(|t| t.beside == answer.beside);
    let alike = alike.map(|t| t.clone().beside_noise(answer.to_explain));
    let alike = alike.filter(|t| t.wrong.is_empty() && t.parameters <= answer.parameters);
    let alike = alike.filter(|t| !t.effects.iter().any(|one| is_shape(one.id)));
    alike
        .filter(|t| foretells_alike(answer, t, &error).is_some())
        .collect()
}

/// Place of each dry friction among effects, and these; where there are others or details of any, which imitate a rounder reversal
/// together, each alone as well.
fn each_friction(named: &[Named]) -> Vec<(usize, Vec<Named>)> {
    let is_detail = |one: &&Named| {
        let details = by_id(&one.effect.id).map_or(&[][..], |effect| effect.detail_of);
        details.iter().any(|(of, _)| is_dry(of))
    };
    let of = |friction: &Named| {
        let id = &friction.effect.id;
        let is_it = |one: &Named| one.effect.id == *id;
        let others = |one: &&Named| !is_it(one) && (is_dry(&one.effect.id) || is_detail(one));
        let alone = named.iter().filter(|one| !others(one)).cloned();
        let alone = (is_dry(id) && named.iter().any(|one| others(&one))).then(|| alone.collect());
        let sets = alone.into_iter().chain([named.to_vec()]);
        sets.filter_map(|set: Vec<Named>| Some((set.iter().position(is_it)?, set)))
            .collect::<Vec<_>>()
    };
    let frictions = named.iter();
    let frictions = frictions.filter(|one| is_dry(&one.effect.id) || is_detail(one));
    frictions.flat_map(of).collect()
}

fn by_least_squares(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[Named],
    anew: bool,
) -> anyhow::Result<Vec<Named>> {
    let first = model.effects.len();
    let found = refit_effects(
        &with_effects(model, named.iter()),
        first,
        recordings.train(),
    )?;
    let fitted = named.iter().zip(&found.after.effects[first..]);
    let refitted = fitted.map(|(named, fitted)| named.clone().refitted(fitted, anew));
    Ok(refitted.collect())
}

/// Whether a delay leaves less than half of a log to compare: where nothing is predicted there is no error.
fn predicts_little(prediction: &Prediction) -> bool {
    let rows = &prediction.channel(Channel::Wrench).predicted;
    2 * rows.iter().flatten().count() < rows.len()
}

/// Errors with some effects, in units of the noise; NaN where too little is predicted.
struct Errors {
    of_fit: f64,
    unseen: f64,
}

impl Errors {
    fn of(model: &Model, recordings: &Logs<&Recording>, named: &[Named]) -> anyhow::Result<Self> {
        let predictions = predict_all(&with_effects(model, named.iter()), recordings)?;
        if predictions.all.iter().any(predicts_little) {
            return Ok(Self {
                of_fit: f64::NAN,
                unseen: f64::NAN,
            });
        }
        Ok(Self {
            of_fit: ChannelLevels::of(predictions.train()).rms(),
            unseen: ChannelLevels::of(predictions.test()).rms(),
        })
    }
}
