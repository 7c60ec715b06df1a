//! Hidden errors of the simulated spacecraft: the board computes another spacecraft than the model says.

use super::Hidden;
use anyhow::{Context, Result};
use softdock_control::settings::Settings;
use softdock_physics::effects::Law;

/// Whether an effect is one of the spacecraft, which the board computes and no rig can hide.
pub fn concerns(hidden: &Hidden) -> bool {
    let effect = hidden.effect();
    effect.is_ok_and(|effect| matches!(effect.law, Law::Spacecraft(_)))
}

/// Changes the settings of spacecraft K, the one that the robot moves, as hidden effects say.
///
/// # Errors
/// The spacecraft would have no positive mass or inertia, or a resistance that pushes.
pub fn apply(hidden: &[Hidden], settings: &mut Settings) -> Result<()> {
    let mut changed = settings.clone();
    let mut ids: Vec<&str> = Vec::new();
    for one in hidden {
        let effect = one.effect()?;
        if let Law::Spacecraft(law) = effect.law {
            law(&effect.values(&one.parameters), &mut changed.body_k);
            ids.push(effect.id);
        }
    }
    // Settings that were invalid before are no error of these effects.
    if settings.validate().is_ok() {
        let with = || format!("with [[rig.hidden]] {}", ids.join(", "));
        changed.validate().with_context(with)?;
    }
    *settings = changed;
    Ok(())
}
