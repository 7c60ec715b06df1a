//! Velocity limit of an axis.

use crate::effects::{Effect, OutOfRange, Parameter, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "velocity_saturation",
    equation: "v = clamp(u, -max_velocity_m_s, +max_velocity_m_s) (rad/s for a rotation)",
    source: "robot data sheets; reduced-velocity mode T1 of robot controllers (250 mm/s)",
    signature: "executed velocity has flat tops at one height where the command is larger",
    parameters: &[Parameter {
        name: "max_velocity_m_s",
        unit: "m/s",
        low: 0.001,
        high: 3.0,
    }],
};

/// Velocity limit of one axis.
#[derive(Clone, Copy, Debug)]
pub struct VelocitySaturation<S: Scalar> {
    max_velocity: S,
}

impl<S: Scalar> VelocitySaturation<S> {
    /// `max_velocity` in m/s (or rad/s), above 0 to 1e3.
    pub fn new(max_velocity: f64) -> Result<Self, OutOfRange> {
        let limit = in_range("max_velocity_m_s", max_velocity, 1e-6, 1e3)?;
        Ok(Self {
            max_velocity: S::of(limit),
        })
    }

    /// The limited velocity.
    pub fn apply(&self, input: S) -> S {
        input.clamp(-self.max_velocity, self.max_velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tops_are_flat() {
        let axis = VelocitySaturation::<f64>::new(0.02).unwrap();
        assert_eq!(
            [-0.03, -0.01, 0.0, 0.02, 9.0].map(|u| axis.apply(u)),
            [-0.02, -0.01, 0.0, 0.02, 0.02]
        );
    }
}
