//! Sensor that is mounted at another angle on the flange than in the model.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use nalgebra::{Rotation3, Vector3};
use softdock_control::frames::Wrench;

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
        Parameter::new("ry_rad", "rad", -0.2, 0.2)
            .hidden(0.03, 0.06)
            .either_sign()
            .pictured(0.05),
        Parameter::new("rz_rad", "rad", -0.2, 0.2)
            .hidden(0.03, 0.06)
            .either_sign(),
    ],
    confused_with: &["ft_crosstalk", "base_tilt", "tool_com_error"],
    tell_apart: "load the axes one after the other, with known weights in six orientations: a rotation needs three \
                 numbers for all couplings, cross-talk is any of thirty",
    law: Law::SensorGain(read),
    separable: true,
    ..Effect::PLAIN
};

/// The load in axes of the turned sensor; p is a rotation vector in axes of the nominal S.
fn read(p: &[f64], load: &Wrench<f64>) -> Wrench<f64> {
    let turned = Rotation3::from_scaled_axis(Vector3::new(p[0], p[1], p[2])).inverse();
    load.map(|part| turned * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turned by a right angle about z, the sensor's x is the nominal y.
    #[test]
    fn a_right_angle() {
        let quarter = [0.0, 0.0, std::f64::consts::FRAC_PI_2];
        let got = read(&quarter, &Wrench::of(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])).get();
        for (got, expected) in got.iter().zip([2.0, -1.0, 3.0, 5.0, -4.0, 6.0]) {
            assert!((got - expected).abs() < 1e-12);
        }
    }
}
