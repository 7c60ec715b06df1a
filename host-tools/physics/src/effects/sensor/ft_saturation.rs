//! Range of the sensor.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::frames::Wrench;

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
    parameters: &[Parameter::new("limit_n", "N", 1.0, 10000.0)
        .shape(
            &[
                2.0, 3.0, 4.0, 5.5, 7.5, 10.0, 13.0, 17.0, 22.0, 28.0, 36.0, 46.0, 60.0, 80.0,
                105.0, 140.0, 190.0, 250.0, 330.0, 450.0, 600.0, 1e3, 2e3, 5e3,
            ],
            1e4,
        )
        .hidden(21.0, 28.0)
        .pictured(10.0)],
    confused_with: &["ft_scale", "contact_stiffness", "ft_dropout"],
    tell_apart: "bounces of growing speed: below the limit every force is right, above it the tops are flat",
    law: Law::Saturation(read),
    ..Effect::PLAIN
};

/// Forces are cut off; torques pass.
fn read(p: &[f64], wrench: &Wrench<f64>) -> Wrench<f64> {
    Wrench {
        force: wrench.force.map(|force| force.clamp(-p[0], p[0])),
        torque: wrench.torque,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_cut_off() {
        let got = read(
            &[200.0],
            &Wrench::of(&[250.0, -300.0, 5.0, 900.0, 0.0, 0.0]),
        );
        assert_eq!(got.get(), [200.0, -200.0, 5.0, 900.0, 0.0, 0.0]);
    }
}
