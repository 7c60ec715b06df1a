//! Lists of cases: a mixed suite and a size sweep. A list contains only specifications; a case is simulated on demand.

use crate::case::CaseSpec;
use crate::effect::{IDS, OUTSIDE_IDS};
use crate::harder;
use crate::noise::{Noise, NoiseRange};
use crate::truth::Level;

/// Pairs of effects none of which masks the other.
const PAIRS: [[&str; 2]; 28] = [
    ["zero_cross_pause", "guide_viscous"],
    ["ft_crosstalk", "tool_com_error"],
    ["actuation_delay", "guide_coulomb"],
    ["actuation_lag", "contact_cubic"],
    ["rate_limit", "ft_bias_drift"],
    ["structural_resonance", "tool_mass_error"],
    ["manipulator_resistance", "guide_coulomb"],
    ["sc_mass_error", "contact_damping"],
    ["ft_quantisation", "actuation_delay"],
    ["ft_dropout", "guide_viscous"],
    ["clock_jitter", "guide_coulomb"],
    ["guide_coulomb", "guide_viscous"],
    ["contact_deadzone", "guide_coulomb"],
    ["ft_scale", "contact_damping"],
    ["cable_stiffness", "guide_coulomb"],
    ["actuation_delay", "zero_cross_pause"],
    ["actuation_lag", "velocity_saturation"],
    ["tool_mass_error", "hunt_crossley"],
    ["ft_bias_drift", "guide_viscous"],
    ["velocity_saturation", "cable_stiffness"],
    ["tool_inertia", "guide_coulomb"],
    ["contact_cubic", "guide_viscous"],
    ["ft_bias_drift", "tool_com_error"],
    ["structural_resonance", "contact_damping"],
    ["sc_mass_error", "actuation_delay"],
    ["manipulator_resistance", "zero_cross_pause"],
    ["ft_crosstalk", "hunt_crossley"],
    ["ft_quantisation", "guide_coulomb"],
];

/// Effects of the size sweep, all channels.
const SWEPT: [&str; 13] = [
    "actuation_delay",
    "zero_cross_pause",
    "rate_limit",
    "structural_resonance",
    "guide_coulomb",
    "guide_viscous",
    "contact_damping",
    "contact_cubic",
    "tool_mass_error",
    "ft_bias_drift",
    "ft_crosstalk",
    "manipulator_resistance",
    "cable_stiffness",
];

/// Single effects that also occur with parameters within tolerances.
const WITHIN_TOLERANCE: [&str; 17] = [
    "actuation_delay",
    "actuation_lag",
    "zero_cross_pause",
    "velocity_saturation",
    "structural_resonance",
    "guide_coulomb",
    "guide_viscous",
    "guide_stribeck",
    "contact_damping",
    "hunt_crossley",
    "contact_cubic",
    "tool_mass_error",
    "ft_bias_drift",
    "ft_crosstalk",
    "ft_quantisation",
    "manipulator_resistance",
    "cable_stiffness",
];

/// The mixed suite, shuffled: 125 single effects, 28 pairs, 24 exact nulls, 20 nulls and 17 singles within declared
/// tolerances, 24 cases outside the catalogue. After these 12 triples, 24 cases with an effect in one log, 30 small effects.
/// Sizes 0.7 to 3, small ones 0.1 to 0.33 of the noise.
#[must_use]
pub fn suite(seed: u64) -> Vec<CaseSpec> {
    let mut noise = Noise::new(seed, 10);
    let mut list: Vec<(Level, Vec<&'static str>)> = Vec::new();
    for id in IDS {
        list.extend((0..5).map(|_| (Level::Single, vec![id])));
    }
    list.extend(PAIRS.map(|pair| (Level::Compound, pair.to_vec())));
    list.extend((0..24).map(|_| (Level::Null, Vec::new())));
    list.extend((0..20).map(|_| (Level::NullWithinTolerance, Vec::new())));
    list.extend(WITHIN_TOLERANCE.map(|id| (Level::SingleWithinTolerance, vec![id])));
    for id in OUTSIDE_IDS {
        list.extend((0..3).map(|_| (Level::Outside, vec![id])));
    }
    for last in (1..list.len()).rev() {
        list.swap(last, noise.below(last + 1));
    }
    list.extend(harder::list());
    list.into_iter()
        .enumerate()
        .map(|(i, (level, effects))| CaseSpec {
            name: format!("h{:03}", i + 1),
            seed: mix(seed, i as u64),
            size: size(level, effects.len(), &mut noise),
            level,
            effects,
            noise: NoiseRange::Usual,
        })
        .collect()
}

/// Logs with nothing hidden. Half of them have parameters that are off within declared tolerances; a third has each
/// [`NoiseRange`].
#[must_use]
pub fn nothing_hidden(seed: u64, count: usize) -> Vec<CaseSpec> {
    let levels = [Level::Null, Level::NullWithinTolerance];
    let ranges = [
        NoiseRange::Usual,
        NoiseRange::Wide,
        NoiseRange::ColouredVelocity,
    ];
    let spec = |i: usize| CaseSpec {
        name: format!("n{:03}", i + 1),
        seed: mix(seed, 20_000 + i as u64),
        level: levels[i % 2],
        effects: Vec::new(),
        size: 0.0,
        noise: ranges[i / 2 % 3],
    };
    (0..count).map(spec).collect()
}

/// Size of a case. With several effects, changes between logs and effects outside the catalogue it is never small, so that a
/// miss is due to the tool and not to the data.
fn size(level: Level, effects: usize, noise: &mut Noise) -> f64 {
    let (low, high): (f64, f64) = match level {
        _ if effects == 0 => return 0.0,
        Level::Compound | Level::Triple | Level::OneLog | Level::Outside => (1.0, 2.0),
        Level::Small => (0.1, 0.33),
        _ => (0.7, 3.0),
    };
    noise.between(low.ln(), high.ln()).exp()
}

/// The size sweep: each effect at 1, 0.3, 0.1 and 0.05 of its size, on one rig and motion per
/// effect (only the wall damping follows the effect, to keep the loop stable).
#[must_use]
pub fn size_sweep(seed: u64) -> Vec<CaseSpec> {
    let steps = [1.0, 0.3, 0.1, 0.05];
    SWEPT
        .iter()
        .enumerate()
        .flat_map(|(i, id)| {
            steps.map(|size| CaseSpec {
                name: format!("{id}_x{size}"),
                seed: mix(seed, 10_000 + i as u64),
                level: Level::Single,
                effects: vec![*id],
                size,
                noise: NoiseRange::Usual,
            })
        })
        .collect()
}

/// Seeds of the cases, far apart (`SplitMix64`).
fn mix(seed: u64, index: u64) -> u64 {
    let mut z = seed.wrapping_add((index + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
