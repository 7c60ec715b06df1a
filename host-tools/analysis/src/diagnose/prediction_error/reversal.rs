//! The speed over which a dry friction changes sign, found by the error on unseen data.

use super::for_prediction::{Better, Errors, by_least_squares};
use crate::diagnose::evidence::{FORETELLS, RISES};
use crate::diagnose::logs::Logs;
use crate::diagnose::named::NamedEffect;
use softdock_io::recording::Recording;
use softdock_physics::effects::{Kind, by_id};
use softdock_physics::model::Model;
use softdock_physics::model::load::effects::LEVEL;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Gives one of the dry frictions the transition speed with which least squares leave least on the logs of the fit. `None` if that
/// does not foretell unseen data better, too. The sharpness of a reversal shows in the fast part of a reading, where the likelihood
/// fits other errors of form. `speed` is the largest rms speed of the logs.
pub(crate) fn with_reversals(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[NamedEffect],
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

pub(crate) fn is_dry(id: &str) -> bool {
    by_id(id).and_then(|effect| effect.kind) == Some(Kind::DryFriction)
}

/// The effects with that transition speed of one of the frictions with which least squares leave least on the logs of the fit;
/// `None` if that is not less than `least`. With `anew` there are many sets of effects, so fewer speeds are tried, and intervals do
/// not include those of earlier fits.
pub(crate) fn best_reversal(
    model: &Model,
    recordings: &Logs<&Recording>,
    frictions: Vec<(usize, Vec<NamedEffect>)>,
    speed: f64,
    anew: bool,
    mut least: f64,
) -> anyhow::Result<Option<(Vec<NamedEffect>, Errors)>> {
    /// Speeds that are tried, as numbers of halvings of the slowest transition, with which the friction just reaches its level at
    /// the rms speed; from sharp to round. Fewer are tried of many sets.
    const HALVINGS: &[i32] = &[5, 4, 3, 2, 1, 0];
    const FEWER: &[i32] = &[4, 2, 0];
    /// By how much another transition may lower an error, in levels of the friction. It moves the force of each row by at most one
    /// level; the friction that is fitted with it may be larger, and other amounts move with it. Set by hand.
    const ROUNDER: f64 = 3.0;
    let slowest = speed / LEVEL;
    let is_one_axis = model.rig.active_axes.len() == 1;
    let turning = |named: &[NamedEffect], k: usize, speed: f64| {
        // A transition over higher speeds would make a viscous friction of it.
        if speed > slowest {
            return Ok(None);
        }
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
        // From sharp ones on, as most frictions leave more and more beyond the best one.
        for halvings in if anew { FEWER } else { HALVINGS } {
            let speed = slowest * 0.5_f64.powi(*halvings);
            let Some((others, errors)) = turning(&before, k, speed)? else {
                continue;
            };
            rises = if errors.of_fit > last { rises + 1 } else { 0 };
            last = errors.of_fit;
            before.clone_from(&others);
            let farthest = others[k].level(model);
            tried.push((others, errors));
            if last < least {
                least = last;
                best_speed = Some(speed);
            } else if rises > 1 || (is_one_axis && last - ROUNDER * farthest > least) {
                break;
            }
        }
        let Some(speed) = best_speed else {
            continue;
        };
        // Refines between the values that were tried.
        let twice = [0.5, 2.0].into_iter().filter(|_| anew);
        for beside in twice.chain([FRAC_1_SQRT_2, SQRT_2]) {
            tried.extend(turning(&before, k, beside * speed)?);
        }
        best = with_all_as_good(tried);
        least = best.as_ref().map_or(least, |(_, errors)| errors.of_fit);
    }
    Ok(best)
}

/// The result that leaves least, with intervals that cover those of all as good ones: results that leave as little up to noise,
/// and results that leave little more but foretell better.
fn with_all_as_good(
    mut tried: Vec<(Vec<NamedEffect>, Errors)>,
) -> Option<(Vec<NamedEffect>, Errors)> {
    tried.sort_by(|a, b| a.1.of_fit.total_cmp(&b.1.of_fit));
    let mut tried = tried.into_iter();
    let (mut best, errors) = tried.next()?;
    let is_as_good = |(_, other): &(Vec<NamedEffect>, Errors)| {
        let worse = other.of_fit / errors.of_fit;
        worse < RISES || (worse < FORETELLS && other.unseen < errors.unseen)
    };
    for (others, _) in tried.filter(is_as_good) {
        let both = best.iter_mut().zip(&others);
        both.for_each(|(one, other)| one.hold(other));
    }
    Some((best, errors))
}

/// For each dry friction, or detail of one: its place in a set of effects, and the set. If there are other such effects, which
/// can imitate a rounder reversal together, each dry friction is also taken without them.
pub(crate) fn each_friction(named: &[NamedEffect]) -> Vec<(usize, Vec<NamedEffect>)> {
    let is_detail = |one: &&NamedEffect| {
        let details = by_id(&one.effect.id).map_or(&[][..], |effect| effect.detail_of);
        details.iter().any(|(of, _)| is_dry(of))
    };
    let of = |friction: &NamedEffect| {
        let id = &friction.effect.id;
        let is_it = |one: &NamedEffect| one.effect.id == *id;
        let others = |one: &&NamedEffect| !is_it(one) && (is_dry(&one.effect.id) || is_detail(one));
        let alone = named.iter().filter(|one| !others(one)).cloned();
        let alone = (is_dry(id) && named.iter().any(|one| others(&one))).then(|| alone.collect());
        let sets = alone.into_iter().chain([named.to_vec()]);
        sets.filter_map(|set: Vec<NamedEffect>| Some((set.iter().position(is_it)?, set)))
            .collect::<Vec<_>>()
    };
    let frictions = named.iter();
    let frictions = frictions.filter(|one| is_dry(&one.effect.id) || is_detail(one));
    frictions.flat_map(of).collect()
}
