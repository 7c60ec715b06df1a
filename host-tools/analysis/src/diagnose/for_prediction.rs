//! The parameters that foretell best.
//!
//! Names are decided by the likelihood of the noise as it is, which weighs a slow error less where the noise is slow. Where a
//! law's form is wrong, that likelihood fits the parameters to the fast part of what is left, and others foretell the wrench
//! better: those of least squares, in which each error counts as it is.

use super::engine::{Stages, is_shape, predict_all};
use super::error_reduction::with_effects;
use super::evidence::RISES;
use super::logs::Logs;
use super::named::{self, Named};
use super::ranking::foretells_alike;
use super::wrench::Tested;
use super::wrench_finding::WrenchFinding;
use crate::fit::refit_effects;
use crate::levels::ChannelLevels;
use softdock_io::recording::Recording;
use softdock_physics::effects::{Kind, by_id};
use softdock_physics::model::load::effects::LEVEL;
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Channel, Model};

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
    /// Halvings, from the speed with which a friction has its level at the usual one, to one with which it is sharp.
    const HALVINGS: i32 = 5;
    let frictions = each_friction(named);
    if frictions.is_empty() {
        return Ok(None);
    }
    let before = Errors::of(model, recordings, named)?;
    let as_found = by_least_squares(model, recordings, named, false)?;
    let as_found = Errors::of(model, recordings, &as_found)?;
    let (mut least, mut best) = (as_found.of_fit, None);
    for (k, named) in frictions {
        let (mut last, mut rises) = (f64::INFINITY, 0);
        // From sharp ones, beyond which most leave more and more.
        for halvings in (0..=HALVINGS).rev() {
            let mut others = named.clone();
            let speed = speed / LEVEL * 0.5_f64.powi(halvings);
            let Some(turning) = others[k].clone().turning_over(model, speed) else {
                continue;
            };
            others[k] = turning;
            let others = by_least_squares(model, recordings, &others, false)?;
            let errors = Errors::of(model, recordings, &others)?;
            rises = if errors.of_fit > last { rises + 1 } else { 0 };
            last = errors.of_fit;
            if errors.of_fit < least {
                least = errors.of_fit;
                best = Some((others, errors));
            } else if rises > 1 {
                break;
            }
        }
    }
    let is_better = |errors: &Errors| errors.unseen * RISES < before.unseen.min(as_found.unseen);
    let best = best.filter(|(_, errors)| is_better(errors));
    Ok(best.map(|(named, after)| (named, [before.unseen, after.unseen])))
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
    let is_dry = |id: &str| by_id(id).and_then(|effect| effect.kind) == Some(Kind::DryFriction);
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
