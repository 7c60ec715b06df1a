//! Tool that is heavier or lighter than the model says.

use super::tool::{Tool, ToolState};
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use nalgebra::Matrix3;
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "tool_mass_error",
    title: "Mass of the tool, or of what an axis moves",
    summary: "the tool on the sensor is heavier or lighter than nominal",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "dF = mass_error_kg g, dT = com x mass_error_kg g, g in axes of S; com: nominal centre of mass",
    source: "seed paper section 3.2 (gravity of the tool)",
    signature: "an offset of the force along gravity that turns with the sensor's orientation and does not depend \
                on motion",
    typical: "10 to 200 g: a cable, a screw set, an adapter that nobody weighed; all that an axis moves, where the model knows no mass",
    parameters: &[Parameter::new("mass_error_kg", "kg", -1e4, 1e4)
        // The remaining mass is positive.
        .of_the_tool(-0.99)
        .hidden(0.1, 0.25)
        .either_sign()
        .pictured(0.2)],
    confused_with: &["ft_bias", "tool_com_error", "ft_scale", "base_tilt"],
    tell_apart: "tilt the sensor by 90 deg or more without contact: the error of the weight turns with gravity, a \
                 bias does not; without tilting the two are the same",
    law: Law::Tool(wrench),
    ..Effect::PLAIN
};

/// Weight of the additional mass, and its inertia where the model includes that.
fn wrench(p: &[f64], tool: &ToolState) -> Wrench<f64> {
    let more = Tool {
        mass_kg: p[0],
        com: tool.com,
        inertia: Matrix3::zeros(),
    };
    more.wrench(tool)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_hangs_at_the_centre_of_mass() {
        let got = wrench(&[-0.25], &ToolState::hanging(2.5, [0.01, 0.0, 0.1])).get();
        let weight = 0.25 * 9.81;
        let expected = [0.0, 0.0, weight, 0.0, -0.01 * weight, 0.0];
        for (got, expected) in got.iter().zip(expected) {
            assert!((got - expected).abs() < 1e-12);
        }
    }
}
