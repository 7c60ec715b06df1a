//! Hidden errors of the simulated spacecraft: the board computes another spacecraft than the model says.

use super::Hidden;
use crate::rig::checks::prefixed;
use anyhow::Result;
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
    for one in hidden {
        let effect = one.effect()?;
        if let Law::Spacecraft(law) = effect.law {
            law(&effect.values(&one.parameters), &mut settings.body_k);
            prefixed(
                &format!("with rig.hidden {}: ", one.id),
                settings.validate(),
            )?;
        }
    }
    Ok(())
}
