//! Inertia with which the rig integrates the spacecraft.

use crate::effects::{Effect, Group, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "sc_inertia_error",
    title: "Inertia of the spacecraft",
    summary: "the rig integrates with another inertia of the spacecraft than the model says",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "I = I_nominal + diag(ixx_kg_m2, iyy_kg_m2, izz_kg_m2); alpha = I^-1 (T - w x I w)",
    source: "Euler's equation",
    signature: "the rig's model turns by a wrong factor under torques, axis by axis, while the translation fits",
    typical: "nothing, or the difference of two versions of a settings file",
    parameters: &[
        Parameter::new("ixx_kg_m2", "kg·m^2", -1000.0, 1000.0),
        Parameter::new("iyy_kg_m2", "kg·m^2", -1000.0, 1000.0)
            .hidden(12.0, 25.0)
            .either_sign(),
        Parameter::new("izz_kg_m2", "kg·m^2", -1000.0, 1000.0)
            .hidden(12.0, 25.0)
            .either_sign()
            .pictured(-20.0),
    ],
    confused_with: &["sc_mass_error", "ft_scale", "tool_com_error"],
    tell_apart: "excite the three rotations one after the other: each axis has its own factor, and the torques in \
                 the log fit the contact",
    law: Law::Spacecraft(|p, body| {
        for (axis, error) in p.iter().enumerate() {
            body.inertia_kg_m2[axis][axis] += error;
        }
    }),
    ..Effect::PLAIN
};
