//! Moment of inertia about a bearing beside the nominal one.

use crate::effects::{Effect, Group, Guide, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "bearing_inertia",
    title: "Moment of inertia about the bearing",
    summary: "what turns has another moment of inertia than nominal",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "T = -inertia_error_kg_m2 dw/dt",
    source: "Newton-Euler; the rotor of a geared motor counts with the square of its ratio",
    signature: "a torque in proportion to the angular acceleration, largest where the motion turns",
    typical: "0.01 to 5 kg m2 by the rotor of a robot's joint; thousands about the first axis of a large robot",
    parameters: &[Parameter::new("inertia_error_kg_m2", "kg·m²", -1e6, 1e6)
        // The remaining inertia is positive.
        .of_the_tool(-0.99)
        .pictured(0.05)],
    confused_with: &["bearing_gravity", "cable_stiffness"],
    tell_apart: "the same swing at two frequencies: what inertia takes grows with the square, a spring's torque and a \
                 weight's stay",
    law: Law::Bearing(Guide {
        force: torque,
        reversal: Reversal::sharp,
    }),
    ..Effect::PLAIN
};

/// Torque about the bearing, against the angular acceleration, N·m.
fn torque(p: &[f64], turn: &Slide) -> f64 {
    -p[0] * turn.acceleration
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn against_the_acceleration() {
        let turn = Slide {
            acceleration: -4.0,
            ..Slide::default()
        };
        assert_eq!(torque(&[0.05], &turn), 0.2);
    }
}
