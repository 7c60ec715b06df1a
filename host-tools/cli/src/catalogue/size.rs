//! How large each effect is in its picture: large enough to be seen.

use anyhow::{Context, Result};
use softdock_control::effects::Effect;

/// Parameters that are not zero in the picture of an effect.
type Chosen = &'static [(&'static str, f64)];

/// Every effect with its size.
const SIZES: &[(&str, Chosen)] = &[
    ("command_quantisation", &[("step_m_s", 0.005)]),
    ("actuation_delay", &[("extra_delay_s", 0.032)]),
    ("actuation_lag", &[("extra_lag_s", 0.03)]),
    (
        "second_order_servo",
        &[("frequency_hz", 8.0), ("damping_ratio", 0.5)],
    ),
    (
        "structural_resonance",
        &[("frequency_hz", 14.0), ("damping_ratio", 0.06)],
    ),
    ("zero_cross_pause", &[("pause_s", 0.03)]),
    ("rate_limit", &[("max_acceleration_m_s2", 0.4)]),
    ("jerk_limit", &[("max_jerk_m_s3", 10.0)]),
    ("velocity_saturation", &[("max_velocity_m_s", 0.012)]),
    ("velocity_gain", &[("gain_error", -0.15)]),
    ("backlash", &[("width_m", 0.0005)]),
    ("guide_coulomb", &[("force_n", 2.0)]),
    ("guide_viscous", &[("damping_n_s_per_m", 120.0)]),
    (
        "guide_stribeck",
        &[
            ("coulomb_n", 2.0),
            ("excess_n", 1.5),
            ("stribeck_speed_m_s", 0.004),
        ],
    ),
    (
        "guide_asymmetry",
        &[("forward_n", 3.0), ("backward_n", 1.5)],
    ),
    ("guide_offset", &[("force_n", -3.0)]),
    (
        "guide_hysteresis",
        &[("force_n", 5.0), ("displacement_m", 0.001)],
    ),
    ("wall_position", &[("shift_m", 0.0015)]),
    ("contact_deadzone", &[("gap_m", 0.0015)]),
    ("contact_stiffness", &[("stiffness_error_n_per_m", 1500.0)]),
    ("contact_cubic", &[("stiffness_n_per_m3", 2.5e8)]),
    ("contact_damping", &[("damping_n_s_per_m", 100.0)]),
    (
        "hunt_crossley",
        &[("damping_n_s_per_m2", 7e4), ("exponent", 1.0)],
    ),
    (
        "contact_coulomb",
        &[
            ("friction_coefficient", 0.3),
            ("smoothing_speed_m_s", 0.001),
        ],
    ),
    ("cable_stiffness", &[("stiffness_n_per_m", 150.0)]),
    (
        "manipulator_resistance",
        &[("stiffness_n_per_m", 40.0), ("damping_n_s_per_m", 20.0)],
    ),
    ("base_tilt", &[("ry_rad", 0.03)]),
    ("tool_mass_error", &[("mass_error_kg", 0.2)]),
    ("tool_com_error", &[("com_x_m", 0.002), ("com_z_m", 0.005)]),
    ("tool_inertia", &[("mass_kg", 5.0)]),
    ("ft_mounting", &[("ry_rad", 0.05)]),
    ("ft_crosstalk", &[("fy_from_fx", 0.03)]),
    ("ft_scale", &[("fx", 0.1)]),
    ("ft_bias", &[("fx_n", 1.5)]),
    ("ft_bias_drift", &[("fx_n", 2.0), ("time_constant_s", 15.0)]),
    ("ft_low_pass", &[("time_constant_s", 0.03)]),
    ("ft_saturation", &[("limit_n", 10.0)]),
    ("ft_quantisation", &[("lsb_force_n", 2.0)]),
    ("ft_dropout", &[("held_share", 0.6)]),
    ("ft_latency", &[("latency_s", 0.02)]),
    ("sc_mass_error", &[("mass_error_kg", 25.0)]),
    ("sc_inertia_error", &[("izz_kg_m2", -20.0)]),
    ("clock_jitter", &[("jitter_s", 0.0004)]),
    ("clock_offset", &[("offset_s", -0.02)]),
    ("clock_rate", &[("rate_error", 0.08)]),
];

/// The size of one effect.
#[derive(Clone, Debug)]
pub(super) struct Size {
    chosen: Chosen,
}

impl Size {
    /// The size of this effect.
    pub(super) fn of(effect: &Effect) -> Result<Self> {
        let found = SIZES.iter().find(|(id, _)| *id == effect.id);
        let (_, chosen) =
            found.with_context(|| format!("no picture size is known for `{}`", effect.id))?;
        Ok(Self { chosen })
    }

    /// The value of a parameter; one that is not listed is 0.
    pub(super) fn get(&self, parameter: &str) -> f64 {
        let found = self.chosen.iter().find(|(name, _)| *name == parameter);
        found.map_or(0.0, |(_, value)| *value)
    }

    /// The values of several parameters.
    pub(super) fn all<const N: usize>(&self, parameters: [&str; N]) -> [f64; N] {
        parameters.map(|name| self.get(name))
    }

    /// The size in words, as `pause_s = 0.03`.
    pub(super) fn describe(&self) -> String {
        let values: Vec<String> = self
            .chosen
            .iter()
            .map(|(name, value)| format!("{name} = {value}"))
            .collect();
        values.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_control::effects::CATALOGUE;

    #[test]
    fn sizes_are_plausible_values_of_the_catalogues_parameters() {
        assert_eq!(SIZES.len(), CATALOGUE.len());
        for effect in CATALOGUE {
            for (name, value) in Size::of(effect).unwrap().chosen {
                let known = effect.parameters.iter().find(|p| p.name == *name);
                let plausible = known.is_some_and(|p| p.is_plausible(*value));
                assert!(plausible, "{} {name} = {value}", effect.id);
            }
        }
    }
}
