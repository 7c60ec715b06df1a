//! Draws a rig: masses, stiffness, gap, robot, tool, sensor.

use std::collections::BTreeMap;

use crate::actuator::{ActuatorEffect, Location};
use crate::effect::Effect;
use crate::load::LoadEffect;
use crate::meta::{
    ActuatorModel, Contact, FtSensor, Geometry, Logs, Meta, NoiseSigma, Spacecraft, Tolerance, Tool,
};
use crate::noise::Noise;

/// Limits the factor by which the contact speed grows per contact to `exp(pi/2 * GROWTH)`, about 1.14.
const GROWTH: f64 = 0.085;

/// Draws a nominal model; `light_tool` allows a tool of some grams. The model contains the inertia of a light tool too:
/// without it, that would be an effect that nobody has hidden.
pub(crate) fn draw(case: &str, light_tool: bool, noise: &mut Noise) -> Meta {
    let sample_time_s = match noise.below(10) {
        0 => 0.002,
        1 => 0.005,
        _ => 0.004,
    };
    let free = noise.chance(0.5);
    let mass_kg = noise.between(320.0, 900.0).round();
    let tool_kg = if light_tool && noise.chance(0.12) {
        noise.between(0.02, 0.1)
    } else {
        noise.between(6.0, 16.0)
    };
    let tool = tool(tool_kg, noise);
    Meta {
        format: "docking-rig-log/1".to_owned(),
        case: case.to_owned(),
        sample_time_s,
        dof_mask: if free { [1; 6] } else { [1, 0, 0, 0, 0, 0] },
        gravity_m_s2: noise.pick([[0.0, 0.0, -9.81], [0.0, 0.0, -9.81], [0.0, -9.81, 0.0]]),
        spacecraft: Spacecraft {
            mass_kg,
            inertia_kg_m2: diagonal([0.35, 0.45, 0.5], mass_kg * noise.between(0.9, 1.2)),
        },
        tool,
        ft_sensor: FtSensor {
            bias: core::array::from_fn(|i| {
                let sigma = if i < 3 { 4.0 } else { 0.3 };
                rounded(sigma * noise.normal(), 3)
            }),
            range_force_n: noise.pick([1000.0, 2500.0, 5000.0]),
            range_torque_nm: noise.pick([120.0, 400.0, 700.0]),
        },
        contact: contact(0.4, free, noise),
        geometry: Geometry {
            r_tip_m: [0.4, 0.0, 0.0],
            r_sensor_m: [rounded(noise.between(0.05, 0.12), 3), 0.0, 0.0],
            sensor_rotation: "identity".to_owned(),
        },
        actuator: actuator(sample_time_s, noise),
        noise_sigma: NoiseSigma::DATA_SHEET,
        tolerance: None,
        logs: Logs {
            train: "train.csv".to_owned(),
            test: "test.csv".to_owned(),
        },
    }
}

/// A tool of this mass with a drawn centre of mass.
pub(crate) fn tool(mass_kg: f64, noise: &mut Noise) -> Tool {
    Tool {
        mass_kg: rounded(mass_kg, 3),
        com_m: [
            rounded(noise.between(0.1, 0.18), 3),
            rounded(noise.between(-0.012, 0.012), 3),
            rounded(noise.between(-0.012, 0.012), 3),
        ],
        inertia_kg_m2: diagonal([0.005, 0.0117, 0.0117], mass_kg),
        dynamic_compensation: true,
    }
}

fn contact(tip_m: f64, free: bool, noise: &mut Noise) -> Contact {
    let k_n = (noise.between(9.0, 22.0) * 1e3).round();
    let gap = rounded(noise.between(0.014, 0.021), 4);
    let k_t = (k_n * noise.between(0.08, 0.12)).round();
    // Damping over stiffness, s: a free body needs some damping, a sliding carriage may have none.
    let ratio = if free || noise.chance(0.3) {
        noise.between(0.02, 0.035)
    } else {
        0.0
    };
    Contact {
        law: "linear".to_owned(),
        k_n,
        c_n: k_n * ratio,
        k_t,
        c_t: k_t * ratio,
        delta_c_m: noise.pick([0.003, 0.004, 0.005]),
        x_front_m: tip_m + gap,
        x_aft_m: tip_m - gap,
    }
}

/// The robot. Its delay is a whole number of samples, as a fraction has no unambiguous meaning in the sampled model.
fn actuator(sample_time_s: f64, noise: &mut Noise) -> ActuatorModel {
    let samples = (noise.between(0.004, 0.020) / sample_time_s)
        .round()
        .max(1.0);
    ActuatorModel {
        transport_delay_s: rounded(samples * sample_time_s, 6),
        lag_time_constant_s: rounded(noise.between(0.002, 0.007), 4),
    }
}

/// Adapts the walls to the robot. A robot that cannot follow a bounce makes the loop unstable. So the walls are softened
/// until the acceleration of a contact at 0.12 m/s, `v W` with `W = sqrt(k/m)`, stays below the robot's limit. Then the wall
/// damping is raised until the delay of the loop cannot make the motion grow: with the ratio `c/k` and the total delay `tau`
/// a contact multiplies the speed by about `exp(pi/2 W (tau - c/k))`.
pub(crate) fn settle(meta: &mut Meta, effects: &[Effect]) {
    for effect in effects {
        if let Effect::Actuator(ActuatorEffect::RateLimit { linear, place, .. }) = effect {
            let steeper = match place {
                Location::Input => 1.0,
                Location::Output => staircase(meta),
            };
            let softest = meta.spacecraft.mass_kg * (linear / (0.12 * steeper)).powi(2);
            meta.contact.k_n = meta.contact.k_n.min(softest.round().max(4e3));
        }
    }
    let extra: f64 = effects.iter().map(phase_lag_s).sum();
    let actuator = &meta.actuator;
    let tau =
        actuator.transport_delay_s + actuator.lag_time_constant_s + meta.sample_time_s + extra;
    let needed = |stiffness: f64| {
        let frequency = (stiffness / meta.spacecraft.mass_kg).sqrt();
        (stiffness * (tau - GROWTH / frequency)).max(0.0)
    };
    let contact = &meta.contact;
    // The ramp of the damping reduces its effect: a third more is needed.
    let (c_n, c_t) = (1.3 * needed(contact.k_n), needed(contact.k_t));
    meta.contact.c_n = rounded(contact.c_n.max(c_n), 3);
    let free = meta.dof_mask[1] == 1;
    meta.contact.c_t = rounded(meta.contact.c_t.max(if free { c_t } else { 0.0 }), 3);
}

/// Largest over mean slope of a lag that follows a staircase: `x / (1 - exp(-x))`, `x = Ts/T`.
fn staircase(meta: &Meta) -> f64 {
    let x = meta.sample_time_s / meta.actuator.lag_time_constant_s;
    x / (1.0 - (-x).exp())
}

/// Approximate delay that an effect adds to the loop, s.
fn phase_lag_s(effect: &Effect) -> f64 {
    match effect {
        Effect::Actuator(inner) => match inner {
            ActuatorEffect::Delay { extra_s } | ActuatorEffect::Lag { extra_s } => *extra_s,
            ActuatorEffect::Pause { pause_s, .. } => 0.2 * pause_s,
            ActuatorEffect::RateLimit { .. } | ActuatorEffect::Resonance { .. } => 0.004,
            ActuatorEffect::Saturation { .. } => 0.03,
        },
        // A cubic stiffness bounces faster than sqrt(k/m).
        Effect::Load(LoadEffect::Cubic { .. }) => 0.008,
        _ => 0.0,
    }
}

/// Draws the true plant within tolerances of the nominal one, and declares these tolerances in the nominal one.
pub(crate) fn draw_tolerance(nominal: &mut Meta, noise: &mut Noise) -> Meta {
    let stiffness = 0.003 * nominal.contact.k_n;
    let delay = noise.between(5e-5, 1e-4);
    let bias: [f64; 6] = core::array::from_fn(|i| if i < 3 { 0.1 } else { 0.01 });
    let declared = [
        ("contact.k_n_N_m", Tolerance::One(rounded(stiffness, 3))),
        ("tool.mass_kg", Tolerance::One(0.01)),
        ("tool.com_m", Tolerance::One(1e-4)),
        ("ft_sensor.bias", Tolerance::Six(bias)),
        (
            "actuator.transport_delay_s",
            Tolerance::One(rounded(delay, 6)),
        ),
    ];
    nominal.tolerance = Some(BTreeMap::from(declared.map(|(k, v)| (k.to_owned(), v))));
    let mut plant = nominal.clone();
    plant.contact.k_n += stiffness * noise.normal();
    plant.tool.mass_kg += 0.01 * noise.normal();
    for com in &mut plant.tool.com_m {
        *com += 1e-4 * noise.normal();
    }
    for (value, sigma) in plant.ft_sensor.bias.iter_mut().zip(bias) {
        *value += sigma * noise.normal();
    }
    plant.actuator.transport_delay_s += delay * noise.normal();
    plant
}

fn diagonal(values: [f64; 3], scale: f64) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            if i == j {
                rounded(values[i] * scale, 6)
            } else {
                0.0
            }
        })
    })
}

/// Rounds to decimals: a model file contains numbers as a user would type them.
fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10.0_f64.powi(decimals);
    (value * scale).round() / scale
}
