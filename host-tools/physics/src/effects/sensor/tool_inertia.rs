//! Inertia of the tool that the sensor has to accelerate.

use super::tool::{Tool, ToolState};
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "tool_inertia",
    title: "Inertia of the tool",
    summary: "the sensor feels the inertia of the tool behind it, which the model leaves out",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "F = -mass_kg a_com; T = -(I alpha + w x I w) - com x mass_kg a_com; \
               a_com = a + alpha x com + w x (w x com)",
    source: "Newton-Euler; seed paper section 3.2 (printed there, then neglected)",
    signature: "wrench proportional to minus the measured acceleration, strongest at jogs and at contact",
    typical: "the mass of the tool, 1 to 20 kg, or of what an axis moves",
    parameters: &[
        // A neglected inertia is at least half of the weighed mass.
        Parameter::new("mass_kg", "kg", 0.0, 1e4)
            .of_the_tool(0.5)
            .hidden(4.0, 8.0)
            .pictured(5.0),
    ],
    confused_with: &[
        "tool_mass_error",
        "contact_damping",
        "sc_mass_error",
        "ft_latency",
    ],
    tell_apart: "jog without contact, with a fixed orientation: the force follows acceleration and never velocity; \
                 a negative mass is noise of the differentiated velocity, not an effect",
    law: Law::Tool(wrench),
    ..Effect::PLAIN
};

/// The inertial reaction of a tool of this mass, with the shape of the nominal tool, if the model leaves it out. For a nominal
/// tool without mass the moment of inertia has no scale and is left out.
fn wrench(p: &[f64], tool: &ToolState) -> Wrench<f64> {
    if tool.inertial {
        return Wrench::zero();
    }
    let share = if tool.mass_kg > 0.0 {
        p[0] / tool.mass_kg
    } else {
        0.0
    };
    let moving = Tool {
        mass_kg: p[0],
        com: tool.com,
        inertia: tool.inertia * share,
    };
    moving.inertial_wrench(&tool.motion)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_grows_with_the_mass_and_is_not_counted_twice() {
        let mut state = ToolState::hanging(2.0, [0.0, 0.0, 0.1]);
        state.motion.acceleration.x = 3.0;
        let got = wrench(&[4.0], &state).get();
        assert_eq!(
            got.map(|v| (v * 1e9).round() / 1e9),
            [-12.0, 0.0, 0.0, 0.0, -1.2, 0.0]
        );
        state.mass_kg = 0.0;
        state.motion.acceleration.x = 0.0;
        state.inertia.m33 = 5.0;
        state.motion.angular_acceleration.z = 2.0;
        assert_eq!(wrench(&[0.0], &state).get(), [0.0; 6]);
        state.inertial = true;
        assert_eq!(wrench(&[4.0], &state).get(), [0.0; 6]);
    }
}
