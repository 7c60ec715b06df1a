//! True parameters of hidden effects: the generator's values under the names of this catalogue.

use serde::Serialize;
use softdock_analysis::diagnose::Diagnosis;
use softdock_hidden_effects::Truth;
use softdock_physics::model::Model;
use std::collections::BTreeMap;

/// A confidence interval and the true value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Id of the effect.
    pub effect: String,
    /// Name of the parameter.
    pub parameter: String,
    /// True value.
    pub truth: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Whether the interval contains the true value.
    pub fn covers(&self) -> bool {
        (self.low..=self.high).contains(&self.truth)
    }
}

/// Intervals of the hidden effects that were named, with their true values.
pub fn intervals(diagnosis: &Diagnosis, truth: &Truth, model: &Model) -> Vec<Interval> {
    let found = diagnosis.effects.iter();
    let found = found.filter(|id| truth.effects.contains(id));
    let mut all = Vec::new();
    for id in found {
        let values = values(id, truth.parameters.get(id), model);
        let said = diagnosis.parameters.get(id).into_iter().flatten();
        all.extend(said.filter_map(|(name, estimate)| {
            Some(Interval {
                effect: id.clone(),
                parameter: name.clone(),
                truth: values.of(name)?,
                low: estimate.low,
                high: estimate.high,
            })
        }));
    }
    all
}

/// True values by the parameter's name in this catalogue.
struct Values {
    known: BTreeMap<String, f64>,
    /// Whether a parameter without a value is 0: the effect is a matrix, of which only some entries are given.
    others_zero: bool,
}

impl Values {
    fn of(&self, name: &str) -> Option<f64> {
        let known = self.known.get(name).copied();
        known.or(self.others_zero.then_some(0.0))
    }
}

/// Names of components of the reading.
const AXES: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];

fn values(id: &str, hidden: Option<&BTreeMap<String, f64>>, model: &Model) -> Values {
    let get = |name: &str| hidden.and_then(|h| h.get(name)).copied();
    let mut known: BTreeMap<String, f64> = NAMES
        .iter()
        .filter(|name| name.0 == id)
        .filter_map(|(_, theirs, ours)| Some(((*ours).to_owned(), get(theirs)?)))
        .collect();
    let derived = derived(id, &get, model).into_iter();
    known.extend(derived.filter_map(|(name, value)| Some((name, value?))));
    Values {
        others_zero: id == "ft_crosstalk" && !known.is_empty(),
        known,
    }
}

/// Looks a value of the generator up by its name.
type Get<'a> = &'a dyn Fn(&str) -> Option<f64>;
/// Values under the names of this catalogue.
type Named = Vec<(String, Option<f64>)>;

/// Values that have to be computed from those of the generator or the model.
fn derived(id: &str, get: Get<'_>, model: &Model) -> Named {
    let one = |name: &str, value| vec![(name.to_owned(), value)];
    match id {
        "tool_inertia" => one("mass_kg", Some(model.tool.mass_kg)),
        "sc_mass_error" => {
            let known = get("ratio").zip(model.bodies.k.mass_kg);
            one("mass_error_kg", known.map(|(r, m)| (r - 1.0) * m))
        }
        "ft_dropout" => {
            let share = |p| held_share(p, get("run_ticks"));
            one("held_share", get("probability").map(share))
        }
        // The generator's jitter displaces each instant; this catalogue has none whose intervals scatter.
        "clock_jitter" if get("of_intervals") != Some(1.0) => {
            one("jitter_s", get("jitter_sigma_s"))
        }
        "ft_scale" => scale(get),
        // The end of a linear ramp is not the asymptote that is the parameter of this catalogue.
        "ft_bias_drift" if get("tau_s").is_some() => drift(get),
        "ft_crosstalk" => crosstalk(get),
        _ => Vec::new(),
    }
}

/// Errors of the gains.
fn scale(get: Get<'_>) -> Named {
    let gains = AXES.map(|axis| get(&format!("gain_{axis}")).map(|gain| gain - 1.0));
    let alike = gains.iter().all(|gain| *gain == gains[0]);
    let names = AXES.map(str::to_owned).into_iter();
    let all_axes = ("all_axes".to_owned(), gains[0].filter(|_| alike));
    names.zip(gains).chain([all_axes]).collect()
}

/// A drift towards an asymptote.
fn drift(get: Get<'_>) -> Named {
    let of_axis = |(i, axis): (usize, &str)| {
        let unit = if i < 3 { "n" } else { "n_m" };
        let last = get(&format!("last_{axis}")).or(get(&format!("drift_final_{i}")));
        (format!("{axis}_{unit}"), last)
    };
    let time_constant = ("time_constant_s".to_owned(), get("tau_s"));
    let of_axes = AXES.into_iter().enumerate().map(of_axis);
    [time_constant].into_iter().chain(of_axes).collect()
}

/// Entries of the matrix.
fn crosstalk(get: Get<'_>) -> Named {
    let mut all = Vec::new();
    for (row, to) in AXES.into_iter().enumerate() {
        for (column, from) in AXES.into_iter().enumerate() {
            let name = format!("{to}_from_{from}");
            let value = get(&name).or(get(&format!("C_{row}_{column}")));
            all.push((name, value));
        }
    }
    all
}

/// Share of readings that repeat the previous one: a fresh reading is followed by `run` held ones with the probability `p /
/// run`.
fn held_share(p: f64, run: Option<f64>) -> f64 {
    let run = run.unwrap_or(1.0);
    let begins = p / run;
    run * begins / (run * begins + 1.0 - begins)
}

/// Id of the effect, the generator's name of a parameter, and this catalogue's name.
const NAMES: [(&str, &str, &str); 27] = [
    ("actuation_delay", "extra_delay_s", "extra_delay_s"),
    ("actuation_lag", "extra_lag_s", "extra_lag_s"),
    ("zero_cross_pause", "pause_s", "pause_s"),
    ("rate_limit", "accel_limit_m_s2", "max_acceleration_m_s2"),
    (
        "rate_limit",
        "accel_limit_rad_s2",
        "max_acceleration_rad_s2",
    ),
    ("velocity_saturation", "speed_limit_m_s", "max_velocity_m_s"),
    (
        "velocity_saturation",
        "speed_limit_rad_s",
        "max_velocity_rad_s",
    ),
    ("structural_resonance", "freq_Hz", "frequency_hz"),
    ("structural_resonance", "zeta", "damping_ratio"),
    ("guide_coulomb", "F_c_N", "force_n"),
    ("guide_viscous", "b_Ns_m", "damping_n_s_per_m"),
    ("guide_stribeck", "F_c_N", "coulomb_n"),
    ("guide_stribeck", "F_s_minus_F_c_N", "excess_n"),
    ("guide_stribeck", "v_s_m_s", "stribeck_speed_m_s"),
    ("contact_damping", "c_Ns_m", "damping_n_s_per_m"),
    ("hunt_crossley", "lambda", "damping_n_s_per_m2"),
    ("contact_cubic", "k3_N_m3", "stiffness_n_per_m3"),
    ("contact_deadzone", "gap_m", "gap_m"),
    ("cable_stiffness", "k_N_m", "stiffness_n_per_m"),
    ("manipulator_resistance", "k_N_m", "stiffness_n_per_m"),
    ("manipulator_resistance", "c_Ns_m", "damping_n_s_per_m"),
    ("tool_mass_error", "delta_mass_kg", "mass_error_kg"),
    ("tool_com_error", "dx_m", "com_x_m"),
    ("tool_com_error", "dy_m", "com_y_m"),
    ("tool_com_error", "dz_m", "com_z_m"),
    ("ft_quantisation", "lsb_force_N", "lsb_force_n"),
    ("ft_quantisation", "lsb_torque_Nm", "lsb_torque_n_m"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_one_of_the_catalogue() {
        for (effect, _, ours) in NAMES.iter().filter(|n| !n.2.contains("rad")) {
            let entry = softdock_physics::effects::by_id(effect).unwrap();
            assert!(
                entry.parameters.iter().any(|p| p.name == *ours),
                "{effect}: {ours}"
            );
        }
    }

    #[test]
    fn runs_of_held_readings_are_as_likely_as_single_ones_nearly() {
        assert!((held_share(0.1, Some(1.0)) - 0.1).abs() < 1e-12);
        let runs = held_share(0.1, Some(4.0));
        assert!((runs - 0.1 / 1.075).abs() < 1e-12, "{runs}");
    }
}
