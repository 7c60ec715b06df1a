//! Sensor that is turned on the flange against what the model says.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::Wrench;
use crate::range::{SettingsError, all_within};
use crate::scalar::Scalar;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_mounting",
    title: "Mounting angle of the sensor",
    summary: "the sensor is turned on the flange against its nominal orientation",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W = R^T W_nominal, R = rotation by the vector (rx_rad, ry_rad, rz_rad) in axes of S",
    source: "geometry (rotation vector)",
    signature: "a share of each force appears on another axis, antisymmetric: +x on y goes with -y on x, and the \
                torques turn in the same way",
    typical: "0.2 to 2 deg from the play of the dowel pins; 30, 45 or 90 deg by mistake",
    parameters: &[
        Parameter::new("rx_rad", "rad", -0.2, 0.2),
        Parameter::new("ry_rad", "rad", -0.2, 0.2),
        Parameter::new("rz_rad", "rad", -0.2, 0.2),
    ],
    confused_with: &["ft_crosstalk", "base_tilt", "tool_com_error"],
    tell_apart: "load the axes one after the other, with known weights in six orientations: a rotation needs three \
                 numbers for all couplings, cross-talk is any of thirty",
};

/// Rotation of what the sensor reads.
#[derive(Clone, Copy, Debug)]
pub struct Mounting<S: Scalar> {
    nominal_into_actual: Matrix3<S>,
}

impl<S: Scalar> Mounting<S> {
    /// Rotation vector in axes of the nominal S, each component within ±3.2 rad.
    pub fn new(rotation_vector_rad: &[f64; 3]) -> Result<Self, SettingsError> {
        all_within("rx_rad, ry_rad, rz_rad", rotation_vector_rad, 3.2)?;
        let [x, y, z] = *rotation_vector_rad;
        let rotation = Rotation3::from_scaled_axis(Vector3::new(x, y, z));
        Ok(Self {
            nominal_into_actual: rotation.inverse().matrix().map(S::of),
        })
    }

    /// What the turned sensor reads of a wrench in nominal axes.
    pub fn apply(&self, wrench: &Wrench<S>) -> Wrench<S> {
        wrench.map(|part| self.nominal_into_actual * part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turned by a right angle about z, the sensor's x is the nominal y.
    #[test]
    fn a_right_angle() {
        let sensor = Mounting::<f64>::new(&[0.0, 0.0, std::f64::consts::FRAC_PI_2]).unwrap();
        let got = sensor
            .apply(&Wrench::of(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
            .get();
        for (got, expected) in got.iter().zip([2.0, -1.0, 3.0, 5.0, -4.0, 6.0]) {
            assert!((got - expected).abs() < 1e-12);
        }
    }
}
