//! What moves the reading in time, by what it foretells.

use super::for_prediction::{Better, Errors, by_least_squares};
use super::reversal::{best_reversal, each_friction, is_dry};
use crate::diagnose::catalogue::is_shape;
use crate::diagnose::evidence::{FORETELLS, RISES};
use crate::diagnose::logs::Logs;
use crate::diagnose::named::{Named, of_reading};
use crate::diagnose::wrench::finding::WrenchFinding;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::load::effects::LoadEffect;

/// Effects with what moves the reading in time, beside them or in the place of one of them that is no dry friction, and with the
/// reversals that are best beside that. A reading that is late makes a reversal look round, and where the likelihood has a sharp one,
/// or a spring, whose force is in quadrature with the velocity, nothing looks late. In the place of another it has to leave and to
/// foretell less; with a parameter more, by so much less as decides without a likelihood; and a curve in its place has to leave more.
/// `late`: effects of one parameter, and the end up to which a search looks for it: what is later is something else.
pub(crate) fn with_what_is_late(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[Named],
    wrench: &WrenchFinding,
    late: &[(&LoadEffect, f64)],
) -> anyhow::Result<Option<Better>> {
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
    let tried = Tried {
        model,
        recordings,
        before: &before,
        speed,
    };
    let mut best = None;
    for (others, margin) in &sets {
        for (effect, end) in late {
            tried.beside(others, *margin, effect, *end, &mut best)?;
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

/// What is tried with something late, and what it is held against.
struct Tried<'a> {
    model: &'a Model,
    recordings: &'a Logs<&'a Recording>,
    before: &'a Errors,
    /// The usual speed.
    speed: f64,
}

impl Tried<'_> {
    /// Takes an effect beside others, if that leaves less of the logs of the fit than the best so far, and less of all than before, by a
    /// factor.
    fn beside(
        &self,
        others: &[Named],
        margin: f64,
        effect: &LoadEffect,
        end: f64,
        best: &mut Option<(Vec<Named>, Errors)>,
    ) -> anyhow::Result<()> {
        /// Where least squares begin, s. Set by hand: of a damper that is late by 28 ms they come there from 5 to 45 ms.
        const START_S: f64 = 0.01;
        let [parameter] = effect.parameters[..] else {
            return Ok(());
        };
        let late = Named::new(effect.id, Vec::new());
        let late = late.with(parameter.name, (START_S, 0.0), parameter.unit);
        let both: Vec<Named> = others.iter().cloned().chain([late]).collect();
        let least = best.as_ref().map_or(f64::INFINITY, |(_, best)| best.of_fit);
        let least = least.min(self.before.of_fit / margin);
        let frictions = each_friction(&both);
        let Self {
            model, recordings, ..
        } = self;
        let with_it = best_reversal(model, recordings, frictions, self.speed, true, least)?;
        let foretells = |(named, errors): &(Vec<Named>, Errors)| {
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

/// The likeliest hypothesis with a curve that fits many mechanisms.
fn with_a_curve(wrench: &WrenchFinding) -> Option<Vec<Named>> {
    let likeliest = wrench.likeliest_with(is_shape)?;
    let all = wrench.earlier.0.iter().chain(&likeliest.effects);
    Some(all.map(of_reading).collect())
}

fn without(named: &[Named], gone: usize) -> Vec<Named> {
    let others = named.iter().enumerate().filter(|(k, _)| *k != gone);
    others.map(|(_, one)| one.clone()).collect()
}
