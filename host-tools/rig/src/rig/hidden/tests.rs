//! Known answers for motion, clocks and spacecraft, computed here by hand, and refused entries.

use super::*;
use crate::rig::Rig;
use crate::rig::settings::{ActuatorSettings, WallSettings};
use softdock_control::settings::Settings;

pub(super) fn hide(id: &str, parameters: &[(&str, f64)]) -> Hidden {
    let parameters = parameters.iter().map(|(name, v)| ((*name).to_owned(), *v));
    Hidden {
        id: id.to_owned(),
        parameters: parameters.collect(),
    }
}

/// A robot that obeys at once, a tool of 2 kg, a wall of 1 N/mm at x = 0 and a fine sensor.
pub(super) fn rig_with(hidden: &[Hidden]) -> RigSettings {
    let mut settings = RigSettings {
        gravity_m_s2: [0.0, 0.0, -10.0],
        hidden: hidden.to_vec(),
        ..RigSettings::default()
    };
    settings.robot.actuator = ActuatorSettings {
        delay_s: 0.0,
        pause_s: 0.0,
        ..ActuatorSettings::default()
    };
    let sensor = &mut settings.sensor;
    (sensor.noise_force_n, sensor.noise_torque_nm) = (0.0, 0.0);
    (sensor.tool_mass_kg, sensor.tool_com_m) = (2.0, [0.0, 0.0, 0.1]);
    sensor.calibration =
        std::array::from_fn(|row| std::array::from_fn(|column| f64::from(row == column)));
    settings.mechanism.walls = vec![WallSettings {
        point_m: [0.0; 3],
        normal: [-1.0, 0.0, 0.0],
        tip_m: [0.0; 3],
        stiffness_n_per_m: 1000.0,
        damping_n_s_per_m: 0.0,
        damping_onset_m: 0.0,
        gap_m: 0.0,
        friction_coefficient: 0.0,
        smoothing_speed_m_s: 1e-3,
    }];
    settings
}

/// A rig after so many cycles with velocities (mm/s along x, and half of it along y), at the
/// instant of the next telegram.
pub(super) fn moved(settings: &RigSettings, cycles: u64, velocity: impl Fn(u64) -> f64) -> Rig {
    let mut rig = Rig::new(settings, [0.0; 6], 5).unwrap();
    for cycle in 0..cycles {
        rig.begin_cycle().unwrap();
        let step = velocity(cycle) * 4e-6;
        rig.answer([step, 0.5 * step, 0.0, 0.0, 0.0, 0.0], false);
    }
    rig.advance_to(cycles * 4000);
    rig
}

/// One entry: the effect and its parameters, whether the motion reverses half-way, the change of the position after 50 cycles at
/// 10 mm/s, mm, and the tolerance of rounding.
type MotionCase = (&'static str, &'static [(&'static str, f64)], bool, f64, f64);

const MOTIONS: &[MotionCase] = &[
    (
        "command_quantisation",
        &[("step_m_s", 3e-3)],
        false,
        -0.2,
        1e-9,
    ), // 9 mm/s
    (
        "actuation_delay",
        &[("extra_delay_s", 0.02)],
        false,
        -0.2,
        1e-9,
    ),
    ("actuation_lag", &[("extra_lag_s", 0.01)], false, -0.1, 1e-6),
    (
        "second_order_servo", // late by 2 ζ/ω
        &[("frequency_hz", 10.0), ("damping_ratio", 0.6)],
        false,
        -0.19099,
        2e-4,
    ),
    (
        "structural_resonance",
        &[("frequency_hz", 20.0), ("damping_ratio", 0.5)],
        false,
        -0.07958,
        1e-4,
    ),
    ("zero_cross_pause", &[("pause_s", 0.02)], true, 0.2, 1e-9),
    (
        "rate_limit",
        &[("max_acceleration_m_s2", 0.2)],
        false,
        -0.25,
        3e-3,
    ), // 50 ms
    (
        "jerk_limit",
        &[("max_jerk_m_s3", 8.0)],
        false,
        -0.35355,
        0.01,
    ), // 2 √(v/j)
    (
        "velocity_saturation",
        &[("max_velocity_m_s", 0.006)],
        false,
        -0.8,
        1e-9,
    ),
    ("velocity_gain", &[("gain_error", 0.1)], false, 0.2, 1e-9),
    ("backlash", &[("width_m", 4e-4)], false, -0.2, 1e-9),
    (
        "command_deadzone",
        &[("width_m_s", 4e-3), ("centre_m_s", 1e-3)],
        false,
        -0.6,
        1e-9,
    ),
    ("gain_by_direction", &[("asymmetry", 0.1)], false, 0.2, 1e-9),
    ("clock_rate", &[("rate_error", 0.05)], false, 0.1, 1e-9),
];

#[test]
fn the_motion_changes_by_what_the_effect_says() {
    for (id, parameters, reverses, expected_mm, tolerance_mm) in MOTIONS {
        let velocity = |cycle| {
            if *reverses && cycle >= 25 {
                -10.0
            } else {
                10.0
            }
        };
        let x_mm = |hidden: &[Hidden]| {
            let rig = moved(&rig_with(hidden), 50, velocity);
            rig.truth().pose.translation.x * 1e3
        };
        let change = x_mm(&[hide(id, parameters)]) - x_mm(&[]);
        assert!(
            (change - expected_mm).abs() < *tolerance_mm,
            "{id}: {change} mm, expected {expected_mm}"
        );
    }
}

#[test]
fn hidden_effects_and_their_nominal_counterparts_add_up() {
    let mut settings = rig_with(&[hide("actuation_delay", &[("extra_delay_s", 0.02)])]);
    settings.robot.actuator.delay_s = 0.012;
    let rig = moved(&settings, 50, |_| 10.0);
    assert!((rig.truth().pose.translation.x - (0.2 - 0.032) * 0.01).abs() < 1e-12);
}

#[test]
fn a_pose_with_another_clock_shows_another_instant() {
    for (offset_s, expected_mm) in [(0.02, -0.2), (0.0025, -0.025), (-0.01, 0.1)] {
        let mut settings = rig_with(&[hide("clock_offset", &[("offset_s", offset_s)])]);
        settings.robot.actuator.delay_s = 0.012;
        let mut rig = moved(&settings, 50, |_| 10.0);
        let shown = rig.begin_cycle().unwrap().actual_pose[0];
        let shift_mm = (shown - rig.truth().pose.translation.x) * 1e3;
        assert!(
            (shift_mm - expected_mm).abs() < 1e-9,
            "{offset_s}: {shift_mm}"
        );
    }
}

#[test]
fn jitter_scatters_the_pose_in_proportion_to_the_velocity() {
    let mut settings = rig_with(&[hide("clock_jitter", &[("jitter_s", 3e-4)])]);
    settings.robot.actuator.delay_s = 0.012;
    let mut rig = Rig::new(&settings, [0.0; 6], 1).unwrap();
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for cycle in 0..1000 {
        let shown = rig.begin_cycle().unwrap().actual_pose[0];
        let scatter_s = (shown - rig.truth().pose.translation.x) / 1e-3;
        if cycle > 10 {
            (sum, squares, count) = (
                sum + scatter_s,
                squares + scatter_s * scatter_s,
                count + 1.0,
            );
        }
        rig.answer([4e-6, 0.0, 0.0, 0.0, 0.0, 0.0], false); // 1 mm/s
    }
    let (mean_s, sigma_s): (f64, f64) = (sum / count, (squares / count).sqrt());
    assert!(mean_s.abs() < 3e-5, "{mean_s}");
    assert!((sigma_s / 3e-4 - 1.0).abs() < 0.08, "{sigma_s}");
}

#[test]
fn errors_of_the_spacecraft_are_errors_of_the_boards_settings() {
    let mut settings = Settings::default();
    let hidden = [
        hide("sc_mass_error", &[("mass_error_kg", -50.0)]),
        hide("sc_inertia_error", &[("izz_kg_m2", 20.0)]),
        hide(
            "manipulator_resistance",
            &[("stiffness_n_per_m", 40.0), ("damping_n_s_per_m", 25.0)],
        ),
    ];
    spacecraft::apply(&hidden, &mut settings).unwrap();
    for nothing_left in [
        hide("sc_mass_error", &[("mass_error_kg", -500.0)]),
        hide("sc_inertia_error", &[("ixx_kg_m2", -100.0)]),
    ] {
        let refused = spacecraft::apply(
            std::slice::from_ref(&nothing_left),
            &mut Settings::default(),
        );
        let refused = format!("{:#}", refused.unwrap_err());
        let with = format!("with [[rig.hidden]] {}: `body_k.", nothing_left.id);
        assert!(refused.starts_with(&with), "{refused}");
    }
    let body = &settings.body_k;
    assert_eq!(body.mass_kg, 450.0);
    assert_eq!(
        [0, 1, 2].map(|i| body.inertia_kg_m2[i][i]),
        [100.0, 100.0, 120.0]
    );
    assert_eq!(
        [body.arm_stiffness_n_per_m, body.arm_damping_n_s_per_m],
        [40.0, 25.0]
    );
}

#[test]
fn mistakes_are_named_with_what_was_probably_meant() {
    let offset = ("offset_s", -0.02);
    for (hidden, expected) in [
        (
            hide("guide_colomb", &[]),
            "there is no effect `guide_colomb`; did you mean `guide_coulomb`?",
        ),
        (
            hide("guide_coulomb", &[("force", 1.0)]),
            "`guide_coulomb` has no parameter `force`; did you mean `force_n`?",
        ),
        (
            hide("guide_coulomb", &[("force_n", -1.0)]),
            "`force_n` is -1; allowed is 0 to 10000",
        ),
        (
            hide("structural_resonance", &[("frequency_hz", 12.0)]),
            "`damping_ratio` is missing; allowed is 0.005 to 0.5",
        ),
        (
            hide("clock_offset", &[offset]),
            "`offset_s` is -0.02: the pose would show",
        ),
    ] {
        let error = format!("{:#}", rig_with(&[hidden]).validate().unwrap_err());
        let at = "in [[rig.hidden]] number 1: ";
        assert!(error.starts_with(&format!("{at}{expected}")), "{error}");
    }
    let once = hide("ft_bias", &[("fx_n", 1.0)]);
    let twice = rig_with(&[once.clone(), once]).validate().unwrap_err();
    assert!(
        twice
            .to_string()
            .contains("`ft_bias` is in [[rig.hidden]] twice")
    );
    let mut no_wall = rig_with(&[hide("contact_cubic", &[("stiffness_n_per_m3", 1.0)])]);
    no_wall.mechanism.walls.clear();
    assert!(format!("{:#}", no_wall.validate().unwrap_err()).contains("the rig has no wall"));
    let drive = rig_with(&[hide("input_gain", &[("surplus", 0.1)])]);
    assert!(format!("{:#}", drive.validate().unwrap_err()).contains("input of a drive"));
}

/// Every effect has a size, a rig accepts it, the same seed draws the same and another does not.
#[test]
fn suggested_sizes_are_plausible_and_differ_by_seed() {
    let elsewhere = |e: &Effect| e.is_of_a_bearing() || e.is_of_a_docking() || e.is_of_a_drive();
    for effect in CATALOGUE.iter().filter(|e| !elsewhere(e)) {
        let [first, again, other, third] =
            [1, 1, 2, 3].map(|seed| suggest(effect.id, seed).unwrap());
        first.check().unwrap();
        assert_eq!(first, again);
        assert!(first != other || first != third, "{}", effect.id);
    }
    assert!(suggest("nothing", 1).is_err());
}
