//! Readings of the gauges, converted back to a wrench.

use super::settings::{SensorSettings, WallSettings};
use super::*;
use nalgebra::{Matrix6, Vector6};
use softdock_control::frames::orientation_from_abc;

/// The wrench that counts stand for, and the effect of half a count on each axis.
fn wrench_of(s: &SensorSettings, counts: [i16; 6]) -> ([f64; 6], [f64; 6]) {
    let units = [s.counts_per_newton; 3]
        .into_iter()
        .chain([s.counts_per_newton_metre; 3]);
    let matrix = Matrix6::from_row_iterator(s.calibration.iter().flatten().copied());
    let gauges = Vector6::from_iterator(counts.iter().map(|c| f64::from(*c)));
    let (mut wrench, mut half) = ([0.0; 6], [0.0; 6]);
    for (i, unit) in units.enumerate() {
        wrench[i] = (matrix.row(i) * gauges)[0] / unit;
        half[i] = 0.5 * matrix.row(i).abs().sum() / unit;
    }
    (wrench, half)
}

fn assert_reads(s: &SensorSettings, counts: [i16; 6], expected: [f64; 6]) {
    let (got, half) = wrench_of(s, counts);
    for i in 0..6 {
        assert!(
            (got[i] - expected[i]).abs() <= half[i] + 1e-9,
            "axis {i}: {got:?}, expected {expected:?}"
        );
    }
}

/// Weight, bias, drift and contact on a turned sensor, each computed here by hand.
#[test]
fn gauges_read_contact_weight_and_bias_within_half_a_count() {
    let mut settings = RigSettings::default();
    let s = &mut settings.sensor;
    s.position_m = [0.0, 0.0, 0.1];
    s.orientation_abc_rad = [std::f64::consts::FRAC_PI_2, 0.0, 0.0]; // S x = M y, S y = -M x
    (s.tool_mass_kg, s.tool_com_m) = (2.0, [0.0, 0.0, 0.05]);
    s.bias_n = [1.0, -2.0, 3.0];
    s.drift_nm_per_s = [0.0, 0.0, 0.5];
    settings.gravity_m_s2 = [0.0, -10.0, 0.0];
    settings.mechanism.walls = vec![WallSettings {
        point_m: [-0.001, 0.0, 0.0], // 1 mm deep
        normal: [-1.0, 0.0, 0.0],
        tip_m: [0.0, 0.0, 0.3],
        stiffness_n_per_m: 1e5,
        damping_n_s_per_m: 0.0,
        damping_onset_m: 0.0,
        gap_m: 0.0,
        friction_coefficient: 0.0,
        smoothing_speed_m_s: 1e-3,
    }];
    let mut rig = Rig::new(&settings, [0.0; 6], 0).unwrap();
    for _ in 0..500 {
        rig.begin_cycle().unwrap();
        rig.answer([0.0; 6], false);
    }
    rig.advance_to(2_000_000);
    // In M: contact (-100, 0, 0) N at (0, 0, 0.3), weight (0, -20, 0) N at (0, 0, 0.15). About S at
    // (0, 0, 0.1): torque 0.2 z x (-100 x) = -20 y, and 0.05 z x (-20 y) = +1 x.
    // In S: (x, y) of M become (y, -x).
    let expected = [-20.0 + 1.0, 100.0 - 2.0, 3.0, -20.0, -1.0, 0.5 * 2.0];
    let sample = rig.gauges();
    assert_reads(&settings.sensor, sample.counts, expected);
    assert_eq!(sample.status, 0);
}

/// A tool that is accelerated along x and turned: the reading lacks exactly m a_com and I α.
#[test]
fn the_tools_inertia_is_felt_when_asked_for() {
    let mut settings = RigSettings {
        gravity_m_s2: [0.0; 3],
        ..RigSettings::default()
    };
    settings.sensor.inertial_load = true;
    settings.sensor.tool_mass_kg = 5.0;
    settings.sensor.tool_com_m = [0.0, 0.1, 0.0];
    settings.robot.actuator.delay_s = 0.0;
    let mut rig = Rig::new(&settings, [0.0; 6], 0).unwrap();
    let (acceleration, spin) = (2.0, 5.0);
    for n in 0..6 {
        rig.begin_cycle().unwrap();
        let per_cycle = f64::from(n) * 0.004 * 0.004;
        // C turns about M's x axis as long as A = B = 0.
        rig.answer(
            [
                acceleration * per_cycle,
                0.0,
                0.0,
                0.0,
                0.0,
                spin * per_cycle,
            ],
            false,
        );
    }
    rig.advance_to(6 * 4000);
    let inertia_x = settings.sensor.tool_inertia_kg_m2[0][0];
    let w = spin * 5.0 * 0.004;
    let expected = [
        -5.0 * acceleration,
        5.0 * 0.1 * w * w, // centripetal
        -5.0 * 0.1 * spin, // tangential
        -(inertia_x + 5.0 * 0.01) * spin,
        0.0,
        5.0 * 0.1 * acceleration,
    ];
    assert_reads(&settings.sensor, rig.gauges().counts, expected);
}

#[test]
fn noise_has_the_sigma_of_the_settings_and_the_seed_repeats_it() {
    let mut settings = RigSettings::default();
    (
        settings.sensor.noise_force_n,
        settings.sensor.noise_torque_nm,
    ) = (2.0, 0.05);
    let read = |seed| {
        let mut rig = Rig::new(&settings, [0.0; 6], seed).unwrap();
        (0..4000).map(|_| rig.gauges().counts).collect::<Vec<_>>()
    };
    let readings = read(1);
    assert_eq!(readings, read(1));
    assert_ne!(readings, read(2));
    let (mut sum, mut squares) = ([0.0; 6], [0.0; 6]);
    for counts in &readings {
        let (wrench, _) = wrench_of(&settings.sensor, *counts);
        for i in 0..6 {
            sum[i] += wrench[i] / 4000.0;
            squares[i] += wrench[i] * wrench[i] / 4000.0;
        }
    }
    for i in 0..6 {
        let sigma = (squares[i] - sum[i] * sum[i]).sqrt();
        let expected = if i < 3 { 2.0 } else { 0.05 };
        assert!((sigma / expected - 1.0).abs() < 0.05, "axis {i}: {sigma}");
    }
}

#[test]
fn a_low_pass_starts_settled_and_delays_a_change() {
    let mut settings = RigSettings::default();
    settings.sensor.low_pass_hz = Some(20.0);
    settings.robot.actuator.delay_s = 0.0;
    settings.robot.correction_limit.max_rotation_rad = 2.0;
    settings.robot.correction_monitor.max_rotation_rad = 2.0;
    let mut rig = Rig::new(&settings, [0.0; 6], 0).unwrap();
    let weight = -9.81 * settings.sensor.tool_mass_kg;
    let force_z = |rig: &mut Rig| wrench_of(&settings.sensor, rig.gauges().counts).0[2];
    assert!((force_z(&mut rig) - weight).abs() < 0.1);
    rig.begin_cycle().unwrap();
    rig.answer(
        [0.0, 0.0, 0.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2],
        false,
    );
    for _ in 0..3 {
        rig.begin_cycle().unwrap();
        rig.answer([0.0; 6], false);
    }
    // The weight along z falls as cos(a t) during a turn of T = 4 ms, then is 0 for 8 ms. With the
    // filter's time constant tau: y(T) = q + (1 - p) exp(-T/tau), where the steady response to the
    // cosine is (cos(a t) + a tau sin(a t)) / (1 + (a tau)^2): p at t = 0, q at t = T.
    let (tau, turn) = (1.0 / (std::f64::consts::TAU * 20.0), 0.004);
    let a_tau = std::f64::consts::FRAC_PI_2 / turn * tau;
    let p = 1.0 / (1.0 + a_tau * a_tau);
    let after_turn = a_tau * p + (1.0 - p) * (-turn / tau).exp();
    let expected = after_turn * (-0.008 / tau).exp();
    let share = force_z(&mut rig) / weight;
    assert!(
        (share - expected).abs() < 0.02,
        "{share}, expected {expected}"
    );
    let turned = orientation_from_abc::<f64>(&[0.0, 0.0, std::f64::consts::FRAC_PI_2]);
    assert!(rig.truth().pose.rotation.angle_to(&turned) < 1e-9);
}

#[test]
fn a_fault_of_the_sensor_can_be_set() {
    let mut rig = Rig::new(&RigSettings::default(), [0.0; 6], 0).unwrap();
    rig.set_sensor_status(0x8002);
    assert_eq!(rig.gauges().status, 0x8002);
}
