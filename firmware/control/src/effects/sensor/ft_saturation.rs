//! Range of the sensor.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::{Wrench, saturated};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_saturation",
    title: "Range of the sensor",
    summary: "the forces are cut off at the limit of the sensor's range",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "F_i = clamp(F_nominal,i, -limit_n, limit_n) for each axis",
    source: "sensor data sheets (measuring range)",
    signature: "flat tops of the force at one height, while pose and velocity run on",
    typical: "the range of the data sheet, or of a smaller calibration that was loaded",
    parameters: &[Parameter::new("limit_n", "N", 1.0, 10000.0)],
    confused_with: &["ft_scale", "contact_stiffness", "ft_dropout"],
    tell_apart: "bounces of growing speed: below the limit every force is right, above it the tops are flat",
};

/// Limit of the forces.
#[derive(Clone, Copy, Debug)]
pub struct ForceSaturation {
    limit_n: f64,
}

impl ForceSaturation {
    /// `limit_n` 1e-3 to 1e6 N.
    pub fn new(limit_n: f64) -> Result<Self, SettingsError> {
        in_range("limit_n", limit_n, 1e-3, 1e6)?;
        Ok(Self { limit_n })
    }

    /// What the sensor reads of a wrench; torques pass.
    pub fn apply<S: Scalar>(&self, wrench: &Wrench<S>) -> Wrench<S> {
        Wrench {
            force: saturated(&wrench.force, self.limit_n),
            torque: wrench.torque,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_cut_off() {
        let sensor = ForceSaturation::new(200.0).unwrap();
        let got = sensor.apply(&Wrench::<f64>::of(&[250.0, -300.0, 5.0, 900.0, 0.0, 0.0]));
        assert_eq!(got.get(), [200.0, -200.0, 5.0, 900.0, 0.0, 0.0]);
    }
}
