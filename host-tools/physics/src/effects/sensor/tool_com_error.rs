//! Tool whose centre of mass lies elsewhere than the model says.

use super::tool::{Tool, ToolState};
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use nalgebra::Vector3;
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "tool_com_error",
    title: "Centre of mass of the tool",
    summary: "the tool's centre of mass lies elsewhere than nominal",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "dF = 0, dT = (com_x_m, com_y_m, com_z_m) x m g, g in axes of S; m: nominal mass",
    source: "seed paper section 3.2 (gravity of the tool)",
    signature: "torques that turn with the sensor's orientation, while the forces fit",
    typical: "0.5 to 10 mm; 1 mm at 10 kg is 0.1 N m",
    parameters: &[
        Parameter::new("com_x_m", "m", -0.2, 0.2)
            .hidden(0.005, 0.012)
            .either_sign()
            .pictured(0.002),
        Parameter::new("com_y_m", "m", -0.2, 0.2),
        Parameter::new("com_z_m", "m", -0.2, 0.2)
            .hidden(0.005, 0.012)
            .either_sign()
            .pictured(0.005),
    ],
    confused_with: &["tool_mass_error", "ft_crosstalk", "ft_bias", "base_tilt"],
    tell_apart: "tilt the sensor about two axes without contact: no torque about gravity, and none of the forces \
                 is touched; cross-talk follows the forces of a contact too",
    law: Law::Tool(wrench),
    separable: true,
    ..Effect::PLAIN
};

/// The change by the lever alone, with the mass of the load.
fn wrench(p: &[f64], tool: &ToolState) -> Wrench<f64> {
    let at = |com| Tool {
        mass_kg: tool.hanging_kg,
        com,
        inertia: tool.inertia,
    };
    let shifted = tool.com + Vector3::new(p[0], p[1], p[2]);
    at(shifted).wrench(tool) - at(tool.com).wrench(tool)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lever_of_one_millimetre() {
        let got = wrench(&[0.001, 0.0, 0.0], &ToolState::hanging(10.0, [0.0; 3])).get();
        for (got, expected) in got.iter().zip([0.0, 0.0, 0.0, 0.0, 0.0981, 0.0]) {
            assert!((got - expected).abs() < 1e-12);
        }
    }
}
