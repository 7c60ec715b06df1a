//! Mass with which the rig integrates the spacecraft.

use crate::effects::{Effect, Group, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "sc_mass_error",
    title: "Mass of the spacecraft",
    summary: "the rig integrates with another mass of the spacecraft than the model says",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "a = F / (m + mass_error_kg), m: nominal mass",
    source: "Newton's second law",
    signature: "the rig's model accelerates by a wrong factor under every force, in all directions alike",
    typical: "nothing, or the difference of two versions of a settings file",
    parameters: &[Parameter::new("mass_error_kg", "kg", -1000.0, 1000.0)
        .hidden(15.0, 35.0)
        .either_sign()
        .pictured(25.0)],
    confused_with: &[
        "ft_scale",
        "sc_inertia_error",
        "manipulator_resistance",
        "contact_stiffness",
    ],
    tell_apart: "compare the rig's model with the logged force: with a wrong mass the logged force fits the \
                 contact; with a wrong gain of the sensor it does not",
    law: Law::Spacecraft(|p, body| body.mass_kg += p[0]),
    ..Effect::PLAIN
};
