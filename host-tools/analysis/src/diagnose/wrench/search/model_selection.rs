//! What is still open once several effects are found: the form of each beside the others, and which of two effects that imitate
//! each other it is.
//!
//! The form of an effect is chosen when it is found, and an effect that is found later can change the choice: a delay moves the
//! reversals, and with that the sharpness that a dry friction seems to have there.

use crate::diagnose::wrench::regression::fitted::{Fitted, FittedParameter};
use crate::diagnose::wrench::regression::hypothesis::{Hypothesis, Part, evaluate};
use crate::diagnose::wrench::regression::tested::TestedHypothesis;
use crate::diagnose::wrench::regression::variants::Library;
use softdock_physics::model::load::effects::LoadEffect;
use std::collections::BTreeSet;

/// Rounds over all effects.
const ROUNDS: usize = 3;

/// A rival in the place of one of several effects.
#[derive(Clone, Debug)]
pub(crate) struct Rival {
    /// Id of the effect in whose place it is.
    pub of: &'static str,
    /// Its own id.
    pub id: &'static str,
    /// Ids of the effects beside which both were fitted.
    pub beside: Vec<String>,
    /// What the effect gains beside the others on each log.
    pub gain: Vec<f64>,
    /// Gain of the rival in its place, on each log.
    pub gain_of_rival: Vec<f64>,
}

/// The same effects, with the form of each chosen again beside the others. `None` if the parts have no solution.
pub(crate) fn with_forms_reselected(
    library: &Library,
    parts: Vec<Part>,
    price: f64,
) -> Option<Hypothesis> {
    let mut best = evaluate(library, parts, price)?;
    for _ in 0..ROUNDS {
        let before = best.evidence;
        for place in 0..best.parts.len() {
            for parts in other_forms(library, &best.parts, place) {
                match evaluate(library, parts, price) {
                    Some(other)
                        if other.solution.wrong.is_empty() && other.evidence > best.evidence =>
                    {
                        best = other;
                    }
                    _ => {}
                }
            }
        }
        if best.evidence <= before {
            break;
        }
    }
    Some(best)
}

/// The parts with each form of one of them, its present form included.
pub(crate) fn other_forms<'a>(
    library: &'a Library,
    parts: &[Part],
    place: usize,
) -> impl Iterator<Item = Vec<Part>> + use<'a> {
    let parts = parts.to_vec();
    let id = library.variants[parts[place].variant].effect.id;
    let same = library.variants.iter().enumerate();
    same.filter(move |(_, variant)| variant.effect.id == id)
        .map(move |(index, _)| {
            let mut other = parts.clone();
            other[place].variant = index;
            other
        })
}

/// Rivals of the same kind in the place of each effect, if there are several.
pub(crate) fn rivals(
    library: &Library,
    accepted: &TestedHypothesis,
    price: f64,
    test: &dyn Fn(&[Hypothesis]) -> Vec<TestedHypothesis>,
) -> Vec<Rival> {
    let parts = parts_of(library, accepted);
    if parts.len() < 2 {
        return Vec::new();
    }
    let mut all = Vec::new();
    for (place, part) in parts.iter().enumerate() {
        let LoadEffect { id: of, effect, .. } = library.variants[part.variant].effect;
        let of = *of;
        let alike = library.variants.iter().map(|variant| variant.effect.effect);
        let alike = alike.filter(|other| effect.kind.is_some() && other.kind == effect.kind);
        let others: BTreeSet<&'static str> = alike.map(|other| other.id).collect();
        let mut rest = parts.clone();
        rest.remove(place);
        for id in others.into_iter().filter(|id| *id != of) {
            let Some(rival) = best_in_place(library, &parts, place, id, price) else {
                continue;
            };
            let (Some(without), Some(tested)) = (
                evaluate(library, rest.clone(), price).and_then(|h| test(&[h]).pop()),
                test(&[rival]).pop().filter(|t| t.wrong.is_empty()),
            ) else {
                continue;
            };
            let beside = accepted.beside.iter().cloned().chain(without.ids());
            let own = |t: &TestedHypothesis| -> Vec<f64> {
                let both = t.gains.iter().zip(&without.gains);
                both.map(|(with, without)| with - without).collect()
            };
            all.push(Rival {
                of,
                id,
                beside: beside.collect(),
                gain: own(accepted),
                gain_of_rival: own(&tested),
            });
        }
    }
    all
}

/// The best hypothesis with another effect in one place.
fn best_in_place(
    library: &Library,
    parts: &[Part],
    place: usize,
    id: &str,
    price: f64,
) -> Option<Hypothesis> {
    let variants = library.variants.iter().enumerate();
    let of_id = variants.filter(|(_, variant)| variant.effect.id == id);
    let found = of_id.filter_map(|(index, variant)| {
        let mut other = parts.to_vec();
        other[place] = Part {
            variant: index,
            used: (0..variant.columns.len()).collect(),
        };
        evaluate(library, other, price)
    });
    let best = found.max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    with_forms_reselected(library, best.parts, price)
}

/// Widens the standard deviations to how far the parameters move when one piece of the logs is left out: the jackknife (variance
/// (K − 1)/K · Σ (θ(k) − θ)², Efron 1982), which holds for residuals that are neither white nor noise. If one piece holds nearly
/// all that is known of a parameter, as the only step of a log, the fit without it says nothing. Its term is then weighted by the
/// share of the information that is left (C. F. J. Wu, Annals of Statistics 14(4), 1986). `fits` are those without each piece.
pub(crate) fn widen(accepted: &mut [Fitted], fits: &[TestedHypothesis]) {
    /// Share of the information below which a parameter is unknown without a piece.
    const UNKNOWN: f64 = 0.1;
    let count = fits.len().max(1) as f64;
    for (place, effect) in accepted.iter_mut().enumerate() {
        for (name, parameter) in &mut effect.parameters {
            let FittedParameter { value, sigma, .. } = *parameter;
            let moved = |fit: &TestedHypothesis| {
                let without = fit.effects[place].parameters.get(name)?;
                let left = (sigma / without.sigma).powi(2);
                let weight = match left < UNKNOWN {
                    true => left,
                    false => (count - 1.0) / count,
                };
                Some(weight * (without.value - value).powi(2))
            };
            // A choice has no interval.
            if sigma > 0.0 {
                let squares: f64 = fits.iter().filter_map(moved).sum();
                parameter.sigma = sigma.max(squares.sqrt());
            }
        }
    }
}

/// Distance of two values of a shape, as the size of the logarithm of their ratio.
pub(crate) fn away(value: f64, from: f64) -> f64 {
    ((value + 1e-12) / (from + 1e-12)).ln().abs()
}

/// The parts of the library that correspond to a tested hypothesis, each at the nearest shapes.
pub(crate) fn parts_of(library: &Library, tested: &TestedHypothesis) -> Vec<Part> {
    tested
        .effects
        .iter()
        .filter_map(|fitted| {
            let distance = |shapes: &[f64], effect: &LoadEffect| -> f64 {
                effect
                    .shapes
                    .iter()
                    .zip(shapes)
                    .map(|(shape, value)| {
                        let at = fitted.parameters.get(shape.name).map_or(0.0, |p| p.value);
                        away(*value, at)
                    })
                    .sum()
            };
            let (index, variant) = library
                .variants
                .iter()
                .enumerate()
                .filter(|(_, v)| v.effect.id == fitted.id)
                .min_by(|a, b| {
                    distance(&a.1.shapes, a.1.effect).total_cmp(&distance(&b.1.shapes, b.1.effect))
                })?;
            let used = (0..variant.columns.len())
                .filter(|k| {
                    variant
                        .effect
                        .coefficients
                        .get(*k)
                        .is_none_or(|c| fitted.parameters.contains_key(c.name))
                })
                .collect();
            Some(Part {
                variant: index,
                used,
            })
        })
        .collect()
}
