//! Tests with known answers: readings of the sensor, computed by hand.

use super::tests::{hide, moved, rig_with};
use crate::rig::{Hidden, Rig};

/// N and N·m: the sensor of [`rig_with`] counts thousandths.
fn reading(rig: &mut Rig) -> [f64; 6] {
    rig.gauges().counts.map(|count| f64::from(count) * 1e-3)
}

/// One entry: the effect and by how much it changes the six readings after 2 mm in 0.2 s.
type LoadCase = (&'static str, &'static [(&'static str, f64)], [f64; 6]);

/// At the end: 2 mm deep, 10 mm/s along x, 1 mm and 5 mm/s along y. The nominal reading is
/// [-2, 0, -20] N.
const LOADS: &[LoadCase] = &[
    (
        "guide_coulomb",
        &[("force_n", 1.5)],
        [-1.5, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "guide_viscous",
        &[("damping_n_s_per_m", 100.0)],
        [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "guide_stribeck", // 1 + exp(-1)
        &[
            ("coulomb_n", 1.0),
            ("excess_n", 1.0),
            ("stribeck_speed_m_s", 0.01),
        ],
        [-1.36788, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "guide_asymmetry",
        &[
            ("forward_n", 2.0),
            ("backward_n", 1.0),
            ("viscous_difference_n_s_per_m", 50.0),
        ],
        [-2.5, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "guide_offset",
        &[("force_n", -1.2)],
        [-1.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "guide_hysteresis", // 1 - exp(-2)
        &[("force_n", 1.0), ("displacement_m", 1e-3)],
        [-0.86466, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "wall_position",
        &[("shift_m", 5e-4)],
        [0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "contact_deadzone",
        &[("gap_m", 5e-4)],
        [0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "contact_stiffness",
        &[("stiffness_error_n_per_m", 200.0)],
        [-0.4, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "contact_cubic",
        &[("stiffness_n_per_m3", 1e8)],
        [-0.8, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "contact_damping",
        &[("damping_n_s_per_m", 50.0)],
        [-0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "hunt_crossley",
        &[("damping_n_s_per_m2", 2e4), ("exponent", 1.0)],
        [-0.4, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "contact_coulomb", // 0.5 · 2 N · 5 / √26
        &[("friction_coefficient", 0.5), ("smoothing_speed_m_s", 1e-3)],
        [0.0, -0.98058, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "cable_stiffness",
        &[("stiffness_n_per_m", 100.0)],
        [-0.2, -0.1, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "base_tilt", // 20 N turned by 0.1 rad, with a lever of 0.1 m
        &[("ry_rad", 0.1)],
        [-1.99667, 0.0, 0.09992, 0.0, -0.19967, 0.0],
    ),
    (
        "tool_mass_error",
        &[("mass_error_kg", 0.3)],
        [0.0, 0.0, -3.0, 0.0, 0.0, 0.0],
    ),
    (
        "tool_com_error",
        &[("com_x_m", 0.01)],
        [0.0, 0.0, 0.0, 0.0, 0.2, 0.0],
    ),
    (
        "ft_mounting",
        &[("rz_rad", 0.1)],
        [0.00999, 0.19967, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "ft_crosstalk",
        &[("fy_from_fz", 0.05)],
        [0.0, -1.0, 0.0, 0.0, 0.0, 0.0],
    ),
    ("ft_scale", &[("fz", 0.1)], [0.0, 0.0, -2.0, 0.0, 0.0, 0.0]),
    (
        "ft_bias",
        &[("tx_n_m", 0.5)],
        [0.0, 0.0, 0.0, 0.5, 0.0, 0.0],
    ),
    (
        "ft_bias_drift", // 2 N (1 - exp(-0.2))
        &[("fz_n", 2.0), ("time_constant_s", 1.0)],
        [0.0, 0.0, 0.36254, 0.0, 0.0, 0.0],
    ),
    (
        "ft_low_pass",
        &[("time_constant_s", 0.02)],
        [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        "ft_saturation",
        &[("limit_n", 10.0)],
        [0.0, 0.0, 10.0, 0.0, 0.0, 0.0],
    ),
    (
        "ft_quantisation",
        &[("lsb_force_n", 1.5)],
        [0.5, 0.0, 0.5, 0.0, 0.0, 0.0],
    ),
    (
        "ft_latency",
        &[("latency_s", 0.02)],
        [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    ),
];

#[test]
fn the_reading_changes_by_what_the_effect_says() {
    let nominal = reading(&mut moved(&rig_with(&[]), 50, |_| 10.0));
    for (id, parameters, expected) in LOADS {
        let hidden = hide(id, parameters);
        let changed = reading(&mut moved(&rig_with(&[hidden]), 50, |_| 10.0));
        for axis in 0..6 {
            let change = changed[axis] - nominal[axis];
            // Two counts of a thousandth; the filter holds its input for an integration step.
            let tolerance = if *id == "ft_low_pass" { 0.005 } else { 0.002 };
            assert!(
                (change - expected[axis]).abs() < tolerance,
                "{id}, axis {axis}: {change}, expected {}",
                expected[axis]
            );
        }
    }
}

#[test]
fn lost_samples_repeat_the_one_before() {
    let mut settings = rig_with(&[hide("ft_dropout", &[("held_share", 0.3)])]);
    settings.sensor.noise_force_n = 0.5;
    let mut rig = Rig::new(&settings, [0.0; 6], 1).unwrap();
    let samples: Vec<[i16; 6]> = (0..4000).map(|_| rig.gauges().counts).collect();
    let held = samples.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let share = held as f64 / samples.len() as f64;
    assert!((share - 0.3).abs() < 0.03, "{share}");
}

/// 5 kg on the sensor at 0.25 m/s²: 1 mm/s more in each cycle.
#[test]
fn the_inertia_of_the_tool_follows_the_acceleration() {
    let change = |cycles| {
        let ramp = |cycle| cycle as f64;
        let reads = |hidden: &[Hidden]| reading(&mut moved(&rig_with(hidden), cycles, ramp))[0];
        reads(&[hide("tool_inertia", &[("mass_kg", 5.0)])]) - reads(&[])
    };
    assert!((change(20) + 1.25).abs() < 0.002, "{}", change(20));
}
