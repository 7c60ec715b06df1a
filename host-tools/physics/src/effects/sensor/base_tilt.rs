//! Base of the robot that is not level: gravity has another direction than in the model.

use super::tool::ToolState;
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use nalgebra::{Rotation3, Vector3};
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "base_tilt",
    title: "Tilt of the base",
    summary: "the robot's base is not level, so that gravity has another direction",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "g = R g_nominal, R: rotation by rx_rad and ry_rad about the axes across g_nominal, x and y of C where \
               that points along -z",
    source: "geometry (rotation vector)",
    signature: "an offset of the wrench across gravity, proportional to the weight of the tool, that turns with the \
                sensor's orientation",
    typical: "0.1 to 1 deg on a concrete floor; 1 deg at 10 kg is 1.7 N",
    parameters: &[
        Parameter::new("rx_rad", "rad", -0.2, 0.2)
            .hidden(0.02, 0.05)
            .either_sign(),
        Parameter::new("ry_rad", "rad", -0.2, 0.2)
            .hidden(0.02, 0.05)
            .either_sign()
            .pictured(0.03),
    ],
    confused_with: &["ft_bias", "guide_offset", "ft_mounting", "tool_com_error"],
    tell_apart: "hold the sensor in six or more orientations: a bias stays in the sensor's axes, a tilt stays in \
                 the room's; a second tool of another weight changes the tilt's offset and not the bias",
    law: Law::Tool(wrench),
    separable: true,
    ..Effect::PLAIN
};

/// The weight in rotated gravity minus that in nominal gravity.
fn wrench(p: &[f64], tool: &ToolState) -> Wrench<f64> {
    // The shortest rotation from -z to gravity takes x and y to the axes across gravity; upside down they are across it already.
    let level = Rotation3::rotation_between(&-Vector3::z(), &tool.gravity).unwrap_or_default();
    let tilt = level * Vector3::new(p[0], p[1], 0.0);
    let turned = Rotation3::from_scaled_axis(tilt) * tool.gravity;
    tool.weight_in(&(tool.s_from_c * (turned - tool.gravity)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilt_about_y_turns_gravity_towards_minus_x() {
        let got = wrench(&[0.0, 0.1], &ToolState::hanging(2.0, [0.0; 3])).force;
        let expected = Vector3::new(-0.1_f64.sin(), 0.0, 1.0 - 0.1_f64.cos()) * (2.0 * 9.81);
        assert!((got - expected).norm() < 1e-12);
    }

    /// On a wall, with gravity along x, both rotations are tilts: each rotates the weight by its angle.
    #[test]
    fn both_tilts_turn_gravity_wherever_it_points() {
        for gravity in [Vector3::x(), -Vector3::y(), Vector3::z()] {
            let tool = ToolState {
                gravity: gravity * 9.81,
                ..ToolState::hanging(2.0, [0.0; 3])
            };
            for tilt in [[0.1, 0.0], [0.0, 0.1]] {
                let size = wrench(&tilt, &tool).force.norm();
                let expected = 2.0 * 2.0 * 9.81 * 0.05_f64.sin();
                assert!((size - expected).abs() < 1e-9, "{gravity} {size}");
            }
        }
    }
}
