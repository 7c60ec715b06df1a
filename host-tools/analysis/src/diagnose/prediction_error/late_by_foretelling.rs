//! Finds late effects (those that move the reading in time) by their error on unseen data.

use super::for_prediction::{Better, Errors, by_least_squares};
use super::noise_of_motion::MovedInertia;
use super::reversal::{best_reversal, each_friction, is_dry};
use crate::diagnose::catalogue::is_general_curve;
use crate::diagnose::evidence::{FORETELLS, RISES};
use crate::diagnose::logs::Logs;
use crate::diagnose::named::{NamedEffect, of_reading};
use crate::diagnose::wrench::finding::WrenchFinding;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::load::effects::LoadEffect;

/// Tries each late effect beside the answer, and in the place of each effect that is no dry friction, with the transition speeds
/// of frictions that are best beside it. A late reading makes a reversal look round. If the likelihood prefers a sharp reversal,
/// or a spring (whose force is in quadrature with the velocity), nothing looks late to it. In the place of an effect the errors
/// on the logs of the fit and on unseen data have to fall by [`RISES`]; beside all of them, which costs a parameter, by
/// [`FORETELLS`]. No lag stands in the place of a mass or an inertia: beside a viscous friction d it is a mass d T, of which no
/// acceleration, with its noise, is needed to foretell the force. A general curve in its place must not be better on both. `late` has effects of one parameter with the upper end
/// of the searched range, as a longer delay is something else. `None` if nothing is found, or there is no dry friction.
pub(crate) fn with_what_is_late(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[NamedEffect],
    wrench: &WrenchFinding,
    late: &[(&LoadEffect, f64)],
) -> anyhow::Result<Option<Better>> {
    if late.is_empty() || each_friction(named).is_empty() {
        return Ok(None);
    }
    let before = Errors::of(model, recordings, named)?;
    let places = (0..named.len()).filter(|k| !is_dry(&named[*k].effect.id));
    let in_place = places.map(|gone| {
        let is_moved = MovedInertia::of(model, &named[gone].effect).is_some();
        (without(named, gone), RISES, is_moved)
    });
    let sets = in_place.chain([(named.to_vec(), FORETELLS, false)]);
    let sets: Vec<(Vec<NamedEffect>, f64, bool)> = sets.collect();
    let speed = wrench.prepared.pace().speed;
    let tried = LateTrials {
        model,
        recordings,
        before: &before,
        speed,
    };
    let mut best = None;
    for (others, margin, replaces_inertia) in &sets {
        let may_stand = |effect: &LoadEffect| effect.is_a_delay() || !replaces_inertia;
        for (effect, end) in late.iter().filter(|(effect, _)| may_stand(effect)) {
            tried.beside(others, *margin, effect, *end, &mut best)?;
        }
    }
    let Some((best, errors)) = best else {
        return Ok(None);
    };
    // A friction that builds up after each reversal is late as well.
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

/// What all trials of late effects have in common.
struct LateTrials<'a> {
    model: &'a Model,
    recordings: &'a Logs<&'a Recording>,
    before: &'a Errors,
    /// The largest rms speed of the logs.
    speed: f64,
}

impl LateTrials<'_> {
    /// Tries a late effect beside others and keeps it in `best` if it leaves less on the logs of the fit than the best so far,
    /// and both errors are smaller than before by `margin`.
    fn beside(
        &self,
        others: &[NamedEffect],
        margin: f64,
        effect: &LoadEffect,
        end: f64,
        best: &mut Option<(Vec<NamedEffect>, Errors)>,
    ) -> anyhow::Result<()> {
        /// Start value of least squares, s. Set by hand: for a damper that is late by 28 ms, starts from 5 to 45 ms converge.
        const START_S: f64 = 0.01;
        let [parameter] = effect.parameters[..] else {
            return Ok(());
        };
        let late = NamedEffect::new(effect.id, Vec::new());
        let late = late.with(parameter.name, (START_S, 0.0), parameter.unit);
        let both: Vec<NamedEffect> = others.iter().cloned().chain([late]).collect();
        let least = best.as_ref().map_or(f64::INFINITY, |(_, best)| best.of_fit);
        let least = least.min(self.before.of_fit / margin);
        let frictions = each_friction(&both);
        let Self {
            model, recordings, ..
        } = self;
        let with_it = best_reversal(model, recordings, frictions, self.speed, true, least)?;
        let foretells = |(named, errors): &(Vec<NamedEffect>, Errors)| {
            let late = named
                .last()
                .and_then(|one| one.effect.parameters.get(parameter.name));
            errors.unseen * margin < self.before.unseen && late.is_some_and(|late| *late < end)
        };
        if let Some(found) = with_it.filter(foretells) {
            *best = Some(found);
        }
        Ok(())
    }
}

/// The likeliest hypothesis with a general curve; `None` if none was tried.
fn with_a_curve(wrench: &WrenchFinding) -> Option<Vec<NamedEffect>> {
    let likeliest = wrench.likeliest_with(is_general_curve)?;
    let all = wrench.earlier.0.iter().chain(&likeliest.effects);
    Some(all.map(of_reading).collect())
}

fn without(named: &[NamedEffect], gone: usize) -> Vec<NamedEffect> {
    let others = named.iter().enumerate().filter(|(k, _)| *k != gone);
    others.map(|(_, one)| one.clone()).collect()
}
