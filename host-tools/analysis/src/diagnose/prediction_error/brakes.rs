//! What brakes a free swing, by its simulated motion.
//!
//! At each instant a friction is less than the noise of the acceleration, so that the likelihood does not pay for it, but it takes
//! energy all the time: a simulated swing without it goes on where the real one has ended.

use super::for_prediction::{Errors, by_least_squares};
use crate::compare::free_simulation::{STRAYS, simulate};
use crate::diagnose::catalogue::{is_general_curve, simplest};
use crate::diagnose::evidence::{FORETELLS, MOVES};
use crate::diagnose::logs::Logs;
use crate::diagnose::named::{NamedEffect, of_reading, with_effects};
use crate::diagnose::wrench::finding::WrenchFinding;
use crate::diagnose::wrench::regression::fitted::Fitted;
use softdock_io::recording::Recording;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::{Model, WrenchMeaning};

/// From this factor on the amplitude of a simulated swing is wrong: by a tenth, as a simulated motion strays from its log.
pub(crate) const WRONG: f64 = 1.0 + STRAYS;

/// An effect that was found by the simulated swing.
pub(crate) struct Braking {
    /// The answer with it, last, and with the amounts of least squares.
    pub named: Vec<NamedEffect>,
    /// By which factor the amplitude of the simulated swing is wrong, without and with it.
    pub factors: [f64; 2],
}

/// The answer and one effect of a hypothesis that was tried beside it, with the amounts of least squares, if the swing that they
/// foretell on unseen data has an amplitude that is much less [wrong](WRONG), by [`MOVES`] of the square; the one with the best
/// swing. `None` for a log that is no free swing, where no swing is better, or without unseen data.
pub(super) fn with_what_brakes(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[NamedEffect],
    wrench: &WrenchFinding,
) -> anyhow::Result<Option<Braking>> {
    if model.sensor.wrench != WrenchMeaning::Free || !wrench.can_foretell() {
        return Ok(None);
    }
    let swing = |named: Vec<NamedEffect>| Swing::of(model, recordings, named);
    let answer = swing(named.to_vec())?;
    let refitted = swing(by_least_squares(model, recordings, named, true)?)?;
    let closer = answer.log_factor.min(refitted.log_factor);
    if closer <= WRONG.ln() {
        return Ok(None);
    }
    let mut best: Option<(Swing, usize)> = None;
    for one in beside(model, named, wrench) {
        let both: Vec<NamedEffect> = named.iter().cloned().chain([of_reading(one)]).collect();
        let tried = swing(by_least_squares(model, recordings, &both, true)?)?;
        // Further amounts have to make as much of a difference as the first one.
        let least = match &best {
            Some((best, amounts)) if amounts_of(one) <= *amounts => best.log_factor,
            Some((best, _)) => best.log_factor * MOVES.sqrt(),
            None => closer * MOVES.sqrt(),
        };
        let is_there = tried
            .named
            .last()
            .is_some_and(|last| last.is_significant(model));
        if tried.log_factor < least && is_there && tried.is_as_good_as(&answer) {
            best = Some((tried, amounts_of(one)));
        }
    }
    let best = best.map(|(best, _)| best);
    Ok(best.map(|best| Braking {
        factors: [closer, best.log_factor].map(f64::exp),
        named: best.named,
    }))
}

/// Effects with an amount that were tried, and are not named: each as the likeliest hypothesis has it that physics allows. Of those
/// that may be simpler only the simple form: the amplitude of one swing tells no more.
fn beside<'a>(model: &Model, named: &[NamedEffect], wrench: &'a WrenchFinding) -> Vec<&'a Fitted> {
    let may_be = |one: &&Fitted| {
        let effect = LoadEffect::find(model, one.id);
        let is_simple = simplest(model, one.id).is_none_or(|simple| simple == one.id);
        is_simple
            && !is_general_curve(one.id)
            && effect.is_some_and(|effect| !effect.acts_on_reading())
    };
    let mut ranked: Vec<_> = wrench
        .found
        .ranked
        .iter()
        .filter(|t| t.wrong.is_empty())
        .collect();
    ranked.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let mut found: Vec<&Fitted> = Vec::new();
    for one in ranked
        .into_iter()
        .flat_map(|tested| &tested.effects)
        .filter(may_be)
    {
        let is_known = named.iter().any(|named| named.effect.id == one.id);
        if !is_known && found.iter().all(|found| found.id != one.id) {
            found.push(one);
        }
    }
    found.sort_by_key(|one| amounts_of(one));
    found
}

/// Number of amounts that a fit determines.
fn amounts_of(one: &Fitted) -> usize {
    one.parameters.values().filter(|p| p.sigma > 0.0).count()
}

/// Effects with what they foretell.
struct Swing {
    named: Vec<NamedEffect>,
    errors: Errors,
    /// Logarithm of the factor of [`amplitude_factor`].
    log_factor: f64,
}

impl Swing {
    fn of(
        model: &Model,
        recordings: &Logs<&Recording>,
        named: Vec<NamedEffect>,
    ) -> anyhow::Result<Self> {
        let after = with_effects(model, named.iter());
        let factor = amplitude_factor(&after, recordings.test());
        Ok(Self {
            errors: Errors::of(model, recordings, &named)?,
            log_factor: factor.map_or(f64::INFINITY, f64::ln),
            named,
        })
    }

    /// Whether no error at each instant is much larger than that of another answer.
    fn is_as_good_as(&self, other: &Self) -> bool {
        let [own, others] = [self, other].map(|one| &one.errors);
        own.unseen < FORETELLS * others.unseen && own.of_fit < FORETELLS * others.of_fit
    }
}

/// Factor by which the amplitudes of simulated swings are wrong, 1 or more; the largest of some logs. None if one of them cannot be
/// simulated.
pub(crate) fn amplitude_factor(model: &Model, recordings: &[&Recording]) -> Option<f64> {
    let of = |recording: &&Recording| {
        let signals = Signals::new(recording).ok()?;
        simulate(model, &signals)?.ok()?.amplitude_factor
    };
    let each: Option<Vec<f64>> = recordings.iter().map(of).collect();
    each?.into_iter().reduce(f64::max)
}
