//! The parameters that foretell best.
//!
//! Names are decided by the likelihood of the noise as it is, which weighs a slow error less where the noise is slow. Where a
//! law's form is wrong, that likelihood fits the parameters to the fast part of what is left, and others foretell the wrench
//! better: those of least squares, in which each error counts as it is.

use super::engine::{Logs, predict_all};
use super::error_reduction::with_effects;
use super::evidence::RISES;
use super::named::Named;
use crate::fit::refit_effects;
use crate::levels::ChannelLevels;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;

/// Effects with other parameters, and the error on unseen data before and with them.
pub(super) type Better = (Vec<Named>, [f64; 2]);

/// The effects with the parameters of least squares, if these foretell unseen data better. Each interval holds what both
/// likelihoods say.
pub(super) fn refit(
    model: &Model,
    recordings: &Logs<&Recording>,
    named: &[Named],
) -> anyhow::Result<Option<Better>> {
    if named.is_empty() {
        return Ok(None);
    }
    let now = with_effects(model, named.iter());
    let first = model.effects.len();
    let found = refit_effects(&now, first, recordings.train())?;
    let others = Model {
        effects: found.after.effects,
        ..model.clone()
    };
    let error = |model: &Model| -> anyhow::Result<f64> {
        Ok(ChannelLevels::of(predict_all(model, recordings)?.test()).rms())
    };
    let errors = [error(&now)?, error(&others)?];
    let is_better = errors[1] * RISES < errors[0]; // not so for NaN
    Ok(is_better.then(|| {
        let fitted = named.iter().zip(&others.effects[first..]);
        let better = fitted.map(|(named, fitted)| named.clone().refitted(fitted));
        (better.collect(), errors)
    }))
}
