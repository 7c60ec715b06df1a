//! Resistance of the manipulator that holds the simulated spacecraft.

use super::ABOUT_START;
use crate::effects::{Effect, Group, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "manipulator_resistance",
    title: "Resistance of a space manipulator",
    summary: "the rig's model moves against the spring and damper of a manipulator",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -(stiffness_n_per_m (p - p0) + damping_n_s_per_m v), added to the force on the simulated spacecraft",
    source: "seed paper section 3.2 (equivalent resistance of the space manipulator); textbook (spring and damper)",
    signature: "the rig's model decelerates without a measured force; sensor and executed velocity fit their models",
    typical: "1 to 100 N/m and N s/m for a compliant arm of some metres",
    parameters: &[
        Parameter::new("stiffness_n_per_m", "N/m", 0.0, 1e7).pictured(40.0),
        Parameter::new("damping_n_s_per_m", "N·s/m", 0.0, 1e7)
            .hidden(5.0, 10.0)
            .pictured(20.0),
        // The arm is relaxed at the beginning of the log, not at the model's initial position.
        ABOUT_START,
    ],
    confused_with: &["guide_viscous", "cable_stiffness", "sc_mass_error"],
    tell_apart: "look at the sensor in free flight: a guide or a cable on the rig is measured there, a resistance \
                 inside the model is not",
    law: Law::Spacecraft(|p, body| {
        body.arm_stiffness_n_per_m += p[0];
        body.arm_damping_n_s_per_m += p[1];
    }),
    ..Effect::PLAIN
};
