//! Velocity limit of an axis.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "velocity_saturation",
    title: "Velocity limit",
    summary: "the executed velocity is limited",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "v = clamp(u, -max_velocity_m_s, +max_velocity_m_s) (rad/s for a rotation)",
    source: "robot data sheets; reduced-velocity mode T1 of robot controllers (250 mm/s)",
    signature: "executed velocity has flat tops at one height where the command is larger",
    typical: "250 mm/s in the reduced-velocity mode; a configured limit of corrections may be some mm/s",
    parameters: &[Parameter::new("max_velocity_m_s", "m/s", 1e-5, 100.0)
        .of_rotations(1e-5, 100.0)
        .hidden(0.02, 0.03)
        .pictured(0.012)],
    confused_with: &["rate_limit", "velocity_gain"],
    tell_apart: "jogs of growing speed: below the limit the velocity is exact, above it the tops are flat; a \
                 wrong gain is wrong at every speed",
    law: Law::Actuator(Actuator {
        axis: Some(|p, _| VelocitySaturation::new(p[0]).map(AxisStage::Saturation)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Velocity limit of one axis.
#[derive(Clone, Copy, Debug)]
pub struct VelocitySaturation {
    max_velocity: f64,
}

impl VelocitySaturation {
    /// `max_velocity` in m/s (or rad/s), above 0 to 1e3.
    pub fn new(max_velocity: f64) -> Result<Self, SettingsError> {
        in_range("max_velocity_m_s", max_velocity, 1e-6, 1e3)?;
        Ok(Self { max_velocity })
    }

    /// The limited velocity.
    pub fn apply(&self, input: f64) -> f64 {
        input.clamp(-self.max_velocity, self.max_velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tops_are_flat() {
        let axis = VelocitySaturation::new(0.02).unwrap();
        assert_eq!(
            [-0.03, -0.01, 0.0, 0.02, 9.0].map(|u| axis.apply(u)),
            [-0.02, -0.01, 0.0, 0.02, 0.02]
        );
    }
}
