//! Plausible sizes: what a rig could really hide, and a diagnosis could find.
//!
//! They are made for the diagnosis scenario (200 kg at 40 mm/s between two springs of 6 kN/m, noise
//! of 0.2 N and 1 µm): each is several times the noise in the channel that shows it, and none makes
//! the closed loop run away.

use super::{Hidden, effect};
use anyhow::{Context, Result};
use softdock_analysis::statistics::RandomStream;

/// The stream of random numbers that sizes are drawn from; the rig's own begin at 0.
const STREAM: u64 = 100;

/// Range of one parameter.
#[derive(Clone, Copy, Debug)]
struct Draw {
    name: &'static str,
    low: f64,
    high: f64,
    /// Either sign.
    signed: bool,
    /// Drawn values are multiples of this; 0: any.
    step: f64,
}

const fn plain(name: &'static str, low: f64, high: f64) -> Draw {
    Draw {
        name,
        low,
        high,
        signed: false,
        step: 0.0,
    }
}

const fn signed(name: &'static str, low: f64, high: f64) -> Draw {
    Draw {
        signed: true,
        ..plain(name, low, high)
    }
}

const fn stepped(name: &'static str, low: f64, high: f64, step: f64) -> Draw {
    Draw {
        step,
        ..plain(name, low, high)
    }
}

const SIZES: &[(&str, &[Draw])] = &[
    ("command_quantisation", &[plain("step_m_s", 2e-3, 4e-3)]),
    ("actuation_delay", &[plain("extra_delay_s", 0.012, 0.022)]),
    ("actuation_lag", &[plain("extra_lag_s", 0.012, 0.022)]),
    (
        "second_order_servo",
        &[
            plain("frequency_hz", 11.0, 16.0),
            plain("damping_ratio", 0.5, 0.7),
        ],
    ),
    (
        "structural_resonance",
        &[
            plain("frequency_hz", 9.0, 16.0),
            plain("damping_ratio", 0.02, 0.08),
        ],
    ),
    ("zero_cross_pause", &[plain("pause_s", 0.02, 0.032)]),
    ("rate_limit", &[plain("max_acceleration_m_s2", 0.4, 0.8)]),
    ("jerk_limit", &[plain("max_jerk_m_s3", 15.0, 30.0)]),
    (
        "velocity_saturation",
        &[plain("max_velocity_m_s", 0.02, 0.03)],
    ),
    ("velocity_gain", &[signed("gain_error", 0.04, 0.1)]),
    ("backlash", &[plain("width_m", 2e-4, 5e-4)]),
    ("guide_coulomb", &[plain("force_n", 0.7, 1.4)]),
    ("guide_viscous", &[plain("damping_n_s_per_m", 20.0, 40.0)]),
    (
        "guide_stribeck",
        &[
            plain("coulomb_n", 0.4, 0.7),
            plain("excess_n", 0.6, 1.0),
            plain("stribeck_speed_m_s", 0.006, 0.012),
        ],
    ),
    (
        "guide_asymmetry",
        &[plain("forward_n", 0.9, 1.4), plain("backward_n", 0.2, 0.5)],
    ),
    ("guide_offset", &[signed("force_n", 0.8, 1.6)]),
    (
        "guide_hysteresis",
        &[
            plain("force_n", 0.8, 1.4),
            plain("displacement_m", 5e-4, 2e-3),
        ],
    ),
    ("wall_position", &[signed("shift_m", 4e-4, 1e-3)]),
    ("contact_deadzone", &[plain("gap_m", 3e-4, 8e-4)]),
    (
        "contact_stiffness",
        &[signed("stiffness_error_n_per_m", 500.0, 1200.0)],
    ),
    (
        "contact_cubic",
        &[plain("stiffness_n_per_m3", 1.2e7, 2.5e7)],
    ),
    (
        "contact_damping",
        &[plain("damping_n_s_per_m", 60.0, 150.0)],
    ),
    (
        "hunt_crossley",
        &[
            plain("damping_n_s_per_m2", 2e4, 4e4),
            plain("exponent", 1.0, 1.0),
        ],
    ),
    (
        "contact_coulomb",
        &[
            plain("friction_coefficient", 0.15, 0.3),
            plain("smoothing_speed_m_s", 1e-3, 1e-3),
        ],
    ),
    (
        "cable_stiffness",
        &[plain("stiffness_n_per_m", 40.0, 100.0)],
    ),
    (
        "manipulator_resistance",
        &[plain("damping_n_s_per_m", 5.0, 10.0)],
    ),
    (
        "base_tilt",
        &[signed("rx_rad", 0.02, 0.05), signed("ry_rad", 0.02, 0.05)],
    ),
    ("tool_mass_error", &[signed("mass_error_kg", 0.1, 0.25)]),
    (
        "tool_com_error",
        &[
            signed("com_x_m", 0.005, 0.012),
            signed("com_z_m", 0.005, 0.012),
        ],
    ),
    ("tool_inertia", &[plain("mass_kg", 4.0, 8.0)]),
    (
        "ft_mounting",
        &[signed("ry_rad", 0.03, 0.06), signed("rz_rad", 0.03, 0.06)],
    ),
    (
        "ft_crosstalk",
        &[
            signed("fy_from_fx", 0.03, 0.06),
            signed("ty_from_fx", 0.005, 0.01),
        ],
    ),
    ("ft_scale", &[signed("fx", 0.05, 0.12)]),
    (
        "ft_bias",
        &[signed("fx_n", 0.6, 1.2), signed("fy_n", 0.6, 1.2)],
    ),
    (
        "ft_bias_drift",
        &[signed("fx_n", 1.0, 2.0), plain("time_constant_s", 3.0, 8.0)],
    ),
    ("ft_low_pass", &[plain("time_constant_s", 0.012, 0.022)]),
    ("ft_saturation", &[plain("limit_n", 21.0, 28.0)]),
    (
        "ft_quantisation",
        &[
            stepped("lsb_force_n", 0.5, 1.5, 0.05),
            stepped("lsb_torque_n_m", 0.04, 0.08, 0.005),
        ],
    ),
    ("ft_dropout", &[plain("held_share", 0.15, 0.3)]),
    ("ft_latency", &[plain("latency_s", 0.012, 0.022)]),
    ("sc_mass_error", &[signed("mass_error_kg", 15.0, 35.0)]),
    (
        "sc_inertia_error",
        &[
            signed("iyy_kg_m2", 12.0, 25.0),
            signed("izz_kg_m2", 12.0, 25.0),
        ],
    ),
    ("clock_jitter", &[plain("jitter_s", 1.5e-4, 4e-4)]),
    ("clock_offset", &[signed("offset_s", 0.006, 0.012)]),
    ("clock_rate", &[signed("rate_error", 0.03, 0.06)]),
];

/// An effect of a plausible size; the same seed draws the same.
///
/// # Errors
/// There is no such effect; the error offers the nearest id.
pub fn suggest(id: &str, seed: u64) -> Result<Hidden> {
    effect(id)?;
    let mut places = SIZES.iter().enumerate();
    let (place, (_, draws)) = places
        .find(|(_, (known, _))| *known == id)
        .with_context(|| format!("no size is known for `{id}`"))?;
    let mut noise = RandomStream::new(seed, STREAM + place as u64);
    let parameters = draws
        .iter()
        .map(|draw| (draw.name.to_owned(), drawn(draw, &mut noise)));
    Ok(Hidden {
        id: id.to_owned(),
        parameters: parameters.collect(),
    })
}

fn drawn(draw: &Draw, noise: &mut RandomStream) -> f64 {
    let value = draw.low + (draw.high - draw.low) * noise.uniform();
    let value = if draw.step > 0.0 {
        (value / draw.step).round() * draw.step
    } else {
        value
    };
    // Sizes are told to people: three digits are enough.
    let value = format!("{value:.2e}").parse().unwrap_or(value);
    if draw.signed && noise.uniform() > 0.5 {
        -value
    } else {
        value
    }
}
