//! One hidden effect: its id, its true parameters, and the part of the rig in which it acts.

use std::collections::BTreeMap;

use nalgebra::{Vector3, Vector6};

use crate::actuator::{ActuatorEffect, Location};
use crate::load::LoadEffect;
use crate::sensor::{DriftShape, SensorEffect};

/// The 25 ids of the log format's catalogue, by channel.
pub const IDS: [&str; 25] = [
    "actuation_delay",
    "actuation_lag",
    "zero_cross_pause",
    "rate_limit",
    "velocity_saturation",
    "structural_resonance",
    "guide_coulomb",
    "guide_viscous",
    "guide_stribeck",
    "contact_damping",
    "hunt_crossley",
    "contact_cubic",
    "contact_deadzone",
    "tool_mass_error",
    "tool_com_error",
    "tool_inertia",
    "ft_bias_drift",
    "ft_scale",
    "ft_crosstalk",
    "ft_quantisation",
    "ft_dropout",
    "manipulator_resistance",
    "sc_mass_error",
    "cable_stiffness",
    "clock_jitter",
];

/// Effects that are in no catalogue: the right answer is "unexplained".
pub const OUTSIDE_IDS: [&str; 8] = [
    "OOL_bouc_wen",
    "OOL_force_ripple",
    "OOL_lost_motion",
    "OOL_rough_guide",
    "OOL_relaxing_contact",
    "OOL_temperature_step",
    "OOL_random_walk_bias",
    "OOL_mains_hum",
];

/// An effect in the part of the rig in which it acts. SI units.
#[derive(Clone, Debug)]
pub(crate) enum Effect {
    Actuator(ActuatorEffect),
    Load(LoadEffect),
    Sensor(SensorEffect),
    /// `tool_mass_error`: true minus nominal mass.
    ToolMass {
        delta_kg: f64,
    },
    /// `tool_com_error`: true minus nominal centre of mass.
    ToolCom {
        delta_m: Vector3<f64>,
    },
    /// `tool_inertia`: a heavy tool whose inertia the nominal model leaves out.
    ToolInertia,
    /// `manipulator_resistance`: `F -= k p + c v` in the rig computer.
    Resistance {
        stiffness: f64,
        damping: f64,
    },
    /// `sc_mass_error`: the rig computer's mass divided by the nominal one.
    SpacecraftMass {
        ratio: f64,
    },
    /// `clock_jitter`.
    Jitter {
        sigma_s: f64,
        gaussian: bool,
        intervals: bool,
    },
}

/// Parameters of one effect by name.
pub(crate) type Parameters = BTreeMap<String, f64>;

impl Effect {
    /// Id and true parameters.
    pub(crate) fn describe(&self) -> (&'static str, Parameters) {
        let (id, pairs) = match self {
            Self::Actuator(effect) => actuator(effect),
            Self::Load(effect) => load(effect),
            Self::Sensor(effect) => return sensor(effect),
            Self::ToolMass { delta_kg } => ("tool_mass_error", vec![("delta_mass_kg", *delta_kg)]),
            Self::ToolCom { delta_m } => {
                let pairs = vec![
                    ("dx_m", delta_m.x),
                    ("dy_m", delta_m.y),
                    ("dz_m", delta_m.z),
                ];
                ("tool_com_error", pairs)
            }
            Self::ToolInertia => ("tool_inertia", Vec::new()),
            Self::Resistance { stiffness, damping } => {
                let pairs = vec![("k_N_m", *stiffness), ("c_Ns_m", *damping)];
                ("manipulator_resistance", pairs)
            }
            Self::SpacecraftMass { ratio } => ("sc_mass_error", vec![("ratio", *ratio)]),
            Self::Jitter {
                sigma_s,
                gaussian,
                intervals,
            } => {
                let pairs = vec![
                    ("jitter_sigma_s", *sigma_s),
                    ("gaussian", flag(*gaussian)),
                    ("of_intervals", flag(*intervals)),
                ];
                ("clock_jitter", pairs)
            }
        };
        (id, named(&pairs))
    }
}

fn named(pairs: &[(&str, f64)]) -> Parameters {
    pairs.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect()
}

fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}

type Pairs = (&'static str, Vec<(&'static str, f64)>);

fn actuator(effect: &ActuatorEffect) -> Pairs {
    let behind = |place: &Location| ("behind_lag", flag(*place == Location::Output));
    match effect {
        ActuatorEffect::Delay { extra_s } => ("actuation_delay", vec![("extra_delay_s", *extra_s)]),
        ActuatorEffect::Lag { extra_s } => ("actuation_lag", vec![("extra_lag_s", *extra_s)]),
        ActuatorEffect::Pause {
            pause_s,
            trigger,
            reset,
        } => {
            let on_output = ("trigger_on_output", flag(*trigger == Location::Output));
            let pairs = vec![("pause_s", *pause_s), on_output, ("reset", flag(*reset))];
            ("zero_cross_pause", pairs)
        }
        ActuatorEffect::RateLimit {
            linear,
            angular,
            place,
        } => {
            let limits = [
                ("accel_limit_m_s2", *linear),
                ("accel_limit_rad_s2", *angular),
            ];
            ("rate_limit", vec![limits[0], limits[1], behind(place)])
        }
        ActuatorEffect::Saturation {
            linear,
            angular,
            place,
        } => {
            let limits = [
                ("speed_limit_m_s", *linear),
                ("speed_limit_rad_s", *angular),
            ];
            (
                "velocity_saturation",
                vec![limits[0], limits[1], behind(place)],
            )
        }
        ActuatorEffect::Resonance {
            frequency_hz,
            damping,
        } => {
            let pairs = vec![("freq_Hz", *frequency_hz), ("zeta", *damping)];
            ("structural_resonance", pairs)
        }
    }
}

fn load(effect: &LoadEffect) -> Pairs {
    match effect {
        LoadEffect::Coulomb { force, smooth } => (
            "guide_coulomb",
            vec![("F_c_N", *force), ("smooth_m_s", *smooth)],
        ),
        LoadEffect::Viscous { coefficient } => ("guide_viscous", vec![("b_Ns_m", *coefficient)]),
        LoadEffect::Stribeck {
            force,
            extra,
            speed,
            exponent,
            smooth,
        } => {
            let pairs = vec![
                ("F_c_N", *force),
                ("F_s_minus_F_c_N", *extra),
                ("v_s_m_s", *speed),
                ("exponent", *exponent),
                ("smooth_m_s", *smooth),
            ];
            ("guide_stribeck", pairs)
        }
        LoadEffect::ContactDamping { coefficient } => {
            ("contact_damping", vec![("c_Ns_m", *coefficient)])
        }
        LoadEffect::HuntCrossley { lambda, exponent } => (
            "hunt_crossley",
            vec![("lambda", *lambda), ("exponent", *exponent)],
        ),
        LoadEffect::Cubic { stiffness } => ("contact_cubic", vec![("k3_N_m3", *stiffness)]),
        LoadEffect::DeadZone { gap } => ("contact_deadzone", vec![("gap_m", *gap)]),
        LoadEffect::Cable {
            stiffness,
            at_sensor,
        } => {
            let pairs = vec![("k_N_m", *stiffness), ("at_sensor", flag(*at_sensor))];
            ("cable_stiffness", pairs)
        }
        outside => load_outside(outside),
    }
}

fn load_outside(effect: &LoadEffect) -> Pairs {
    match effect {
        LoadEffect::BoucWen {
            force,
            distance,
            exponent,
        } => {
            let pairs = vec![
                ("F_N", *force),
                ("x_char_m", *distance),
                ("exponent", *exponent),
            ];
            ("OOL_bouc_wen", pairs)
        }
        LoadEffect::Ripple {
            force,
            pitch,
            phase,
        } => {
            let pairs = vec![("F_N", *force), ("pitch_m", *pitch), ("phase_rad", *phase)];
            ("OOL_force_ripple", pairs)
        }
        LoadEffect::LostMotion {
            stiffness,
            half_width,
        } => {
            let pairs = vec![("k_N_m", *stiffness), ("half_width_m", *half_width)];
            ("OOL_lost_motion", pairs)
        }
        LoadEffect::RoughGuide {
            force,
            depth,
            pitch,
            phase,
        } => {
            let shape = [("pitch_m", *pitch), ("phase_rad", *phase)];
            let pairs = vec![("F_N", *force), ("depth", *depth), shape[0], shape[1]];
            ("OOL_rough_guide", pairs)
        }
        LoadEffect::Relaxing { stiffness, tau } => (
            "OOL_relaxing_contact",
            vec![("k_N_m", *stiffness), ("tau_s", *tau)],
        ),
        _ => ("OOL_unknown", Vec::new()),
    }
}

/// Six components under `prefix_fx` .. `prefix_tz`.
fn six(prefix: &str, v: &Vector6<f64>) -> Parameters {
    (0..6)
        .map(|i| (format!("{prefix}_{}", AXES[i]), v[i]))
        .collect()
}

/// Names of the wrench components.
const AXES: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];

fn sensor(effect: &SensorEffect) -> (&'static str, Parameters) {
    match effect {
        SensorEffect::Scale { gain, with_bias } => {
            let mut parameters = six("gain", gain);
            parameters.insert("with_bias".to_owned(), flag(*with_bias));
            ("ft_scale", parameters)
        }
        SensorEffect::CrossTalk { entries, with_bias } => {
            let mut parameters: Parameters = entries
                .iter()
                .map(|(to, from, value)| (format!("{}_from_{}", AXES[*to], AXES[*from]), *value))
                .collect();
            parameters.insert("with_bias".to_owned(), flag(*with_bias));
            ("ft_crosstalk", parameters)
        }
        SensorEffect::Drift { last, shape } => {
            let mut parameters = six("last", last);
            let (name, time) = match shape {
                DriftShape::Exponential(tau) => ("tau_s", *tau),
                DriftShape::Ramp(duration) => ("ramp_s", *duration),
            };
            parameters.insert(name.to_owned(), time);
            ("ft_bias_drift", parameters)
        }
        SensorEffect::Quantisation {
            force,
            torque,
            down,
        } => {
            let pairs = [("lsb_force_N", *force), ("lsb_torque_Nm", *torque)];
            (
                "ft_quantisation",
                named(&[pairs[0], pairs[1], ("down", flag(*down))]),
            )
        }
        SensorEffect::DropOut { probability, run } => {
            let pairs = [("probability", *probability), ("run_ticks", *run as f64)];
            ("ft_dropout", named(&pairs))
        }
        outside => sensor_outside(outside),
    }
}

fn sensor_outside(effect: &SensorEffect) -> (&'static str, Parameters) {
    match effect {
        SensorEffect::TemperatureStep {
            axis,
            size,
            at,
            rise,
        } => {
            let pairs = [
                ("axis", *axis as f64),
                ("size", *size),
                ("at_s", *at),
                ("rise_s", *rise),
            ];
            ("OOL_temperature_step", named(&pairs))
        }
        SensorEffect::RandomWalk { per_root_second } => {
            ("OOL_random_walk_bias", six("per_root_s", per_root_second))
        }
        SensorEffect::Hum {
            frequency,
            amplitude,
            ..
        } => {
            let mut parameters = six("amplitude", amplitude);
            parameters.insert("frequency_Hz".to_owned(), *frequency);
            ("OOL_mains_hum", parameters)
        }
        _ => ("OOL_unknown", Parameters::new()),
    }
}
