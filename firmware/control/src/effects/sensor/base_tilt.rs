//! Base of the robot that is not level: gravity has another direction than the model says.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, all_within};
use crate::scalar::Scalar;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "base_tilt",
    title: "Tilt of the base",
    summary: "the robot's base is not level, so that gravity has another direction",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "g = R g_nominal, R: rotation about the horizontal axes of C by (rx_rad, ry_rad, 0)",
    source: "geometry (rotation vector)",
    signature: "an offset of the wrench across gravity, proportional to the weight of the tool, that turns with the \
                sensor's orientation",
    typical: "0.1 to 1 deg on a concrete floor; 1 deg at 10 kg is 1.7 N",
    parameters: &[
        Parameter::new("rx_rad", "rad", -0.2, 0.2),
        Parameter::new("ry_rad", "rad", -0.2, 0.2),
    ],
    confused_with: &["ft_bias", "guide_offset", "ft_mounting", "tool_com_error"],
    tell_apart: "hold the sensor in six or more orientations: a bias stays in the sensor's axes, a tilt stays in \
                 the room's; a second tool of another weight changes the tilt's offset and not the bias",
};

/// Rotation of gravity.
#[derive(Clone, Copy, Debug)]
pub struct BaseTilt<S: Scalar> {
    rotation: Matrix3<S>,
}

impl<S: Scalar> BaseTilt<S> {
    /// Rotation vector (rx, ry, 0), each within ±1 rad.
    pub fn new(rx_rad: f64, ry_rad: f64) -> Result<Self, SettingsError> {
        all_within("rx_rad, ry_rad", &[rx_rad, ry_rad], 1.0)?;
        let rotation = Rotation3::from_scaled_axis(Vector3::new(rx_rad, ry_rad, 0.0));
        Ok(Self {
            rotation: rotation.matrix().map(S::of),
        })
    }

    /// Gravity (m/s², axes of C) from its nominal value.
    pub fn gravity(&self, nominal: &Vector3<S>) -> Vector3<S> {
        self.rotation * nominal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilt_about_y_turns_gravity_towards_minus_x() {
        let tilt = BaseTilt::<f64>::new(0.0, 0.1).unwrap();
        let got = tilt.gravity(&Vector3::new(0.0, 0.0, -10.0));
        let expected = Vector3::new(-10.0 * 0.1_f64.sin(), 0.0, -10.0 * 0.1_f64.cos());
        assert!((got - expected).norm() < 1e-12);
        assert!(BaseTilt::<f64>::new(f64::NAN, 0.0).is_err());
    }
}
