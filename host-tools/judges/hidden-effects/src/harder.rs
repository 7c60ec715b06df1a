//! Harder cases in addition to the mixed suite: three effects at once, an effect in one log only, and effects far below the
//! noise.

use crate::truth::Level;

/// Three effects of different parts of the rig, none of which masks another.
const TRIPLES: [[&str; 3]; 12] = [
    ["actuation_delay", "guide_coulomb", "ft_bias_drift"],
    ["zero_cross_pause", "guide_viscous", "tool_mass_error"],
    ["structural_resonance", "contact_damping", "ft_bias_drift"],
    ["guide_coulomb", "guide_viscous", "contact_cubic"],
    ["actuation_lag", "cable_stiffness", "sc_mass_error"],
    [
        "manipulator_resistance",
        "contact_damping",
        "velocity_saturation",
    ],
    ["tool_com_error", "hunt_crossley", "zero_cross_pause"],
    ["ft_crosstalk", "guide_viscous", "actuation_delay"],
    ["ft_quantisation", "guide_coulomb", "actuation_lag"],
    ["rate_limit", "ft_bias_drift", "manipulator_resistance"],
    ["tool_mass_error", "contact_cubic", "guide_coulomb"],
    ["sc_mass_error", "ft_scale", "guide_viscous"],
];

/// Effects that may differ between two logs of a rig.
const CHANGING: [&str; 12] = [
    "actuation_delay",
    "actuation_lag",
    "zero_cross_pause",
    "guide_coulomb",
    "guide_viscous",
    "contact_damping",
    "contact_cubic",
    "tool_mass_error",
    "ft_scale",
    "cable_stiffness",
    "manipulator_resistance",
    "sc_mass_error",
];

/// Effects whose residual vanishes with their size, in the channels with noise.
const SHRINKING: [&str; 15] = [
    "actuation_delay",
    "actuation_lag",
    "guide_coulomb",
    "guide_viscous",
    "guide_stribeck",
    "contact_damping",
    "hunt_crossley",
    "contact_cubic",
    "contact_deadzone",
    "tool_mass_error",
    "tool_com_error",
    "ft_bias_drift",
    "ft_scale",
    "ft_crosstalk",
    "cable_stiffness",
];

/// Levels and effects: 12 triples, 24 with an effect in one log, 30 small ones.
pub(crate) fn list() -> Vec<(Level, Vec<&'static str>)> {
    let mut list = Vec::new();
    list.extend(TRIPLES.map(|ids| (Level::Triple, ids.to_vec())));
    for _ in 0..2 {
        list.extend(CHANGING.map(|id| (Level::OneLog, vec![id])));
        list.extend(SHRINKING.map(|id| (Level::Small, vec![id])));
    }
    list
}
