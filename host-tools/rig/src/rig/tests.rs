//! The rig as a whole against written equations and the measured tables.

use super::settings::{
    CorrectionLimit, CorrectionMode, CorrectionMonitor, TimeoutCounting, WallSettings,
};
use super::*;
use std::f64::consts::TAU;

const CYCLE_S: f64 = 0.004;

/// No limit of the correction.
fn unlimited(mut settings: RigSettings) -> RigSettings {
    let rotation = 10.0;
    settings.robot.correction_limit = CorrectionLimit {
        lower_m: [-10.0; 3],
        upper_m: [10.0; 3],
        max_rotation_rad: rotation,
    };
    settings.robot.correction_monitor = CorrectionMonitor {
        max_translation_m: 100.0,
        max_rotation_rad: rotation,
    };
    settings
}

/// A wall at x = 0 that stops motion towards +x.
fn wall(stiffness_n_per_m: f64) -> WallSettings {
    WallSettings {
        point_m: [0.0; 3],
        normal: [-1.0, 0.0, 0.0],
        tip_m: [0.0; 3],
        stiffness_n_per_m,
        damping_n_s_per_m: 0.0,
        damping_onset_m: 0.0,
        gap_m: 0.0,
        friction_coefficient: 0.0,
        smoothing_speed_m_s: 1e-3,
    }
}

fn along_x(dx: f64) -> [f64; 6] {
    [dx, 0.0, 0.0, 0.0, 0.0, 0.0]
}

/// Restitution of one bounce of 500 kg at 5 mm/s under the simplest model, which commands the mean
/// of its old and new velocity as the seed paper does: v(n) = v(n−1) + F Ts/m.
fn restitution(w: f64, delay_s: f64, lag_s: f64, pause_s: f64) -> f64 {
    let (mass, speed) = (500.0, 0.005);
    let mut settings = unlimited(RigSettings::default());
    settings.robot.actuator.delay_s = delay_s;
    settings.robot.actuator.lag_s = lag_s;
    settings.robot.actuator.pause_s = pause_s;
    settings.mechanism.walls = vec![wall(mass * w * w)];
    let mut rig = Rig::new(&settings, along_x(-0.002), 0).unwrap();
    let (mut v, mut touched) = (speed, false);
    for _ in 0..2000 {
        rig.begin_cycle().unwrap();
        let truth = rig.truth();
        let force = truth.contact.force.x;
        touched |= force != 0.0;
        if touched && force == 0.0 && truth.twist.linear.x < 0.0 {
            return -v / speed;
        }
        let before = v;
        v += force * CYCLE_S / mass;
        rig.answer(along_x(0.5 * (before + v) * CYCLE_S), false);
    }
    panic!("no rebound");
}

/// The table of facts: restitution without compensation depends only on w times the delay.
#[test]
fn an_elastic_bounce_comes_back_as_much_too_fast_as_measured() {
    for (name, w, delay, lag, pause, expected) in [
        ("scenario S", 21.0, 0.032, 0.0, 0.016, 2.81),
        ("pure .16", 5.0, 0.032, 0.0, 0.0, 1.30),
        ("pure .64", 20.0, 0.032, 0.0, 0.0, 2.63),
        ("pure 1.28", 40.0, 0.032, 0.0, 0.0, 5.16),
        ("lag .64", 20.0, 0.0, 0.032, 0.0, 2.26),
        ("mix .64", 20.0, 0.016, 0.016, 0.0, 2.51),
    ] {
        let got = restitution(w, delay, lag, pause);
        assert!(
            (got / expected - 1.0).abs() < 0.005,
            "{name}: {got}, expected {expected}"
        );
    }
}

/// Settings without delay, lag and pause: a command is executed in its own cycle.
fn immediate(correction: CorrectionMode, hold_on: bool) -> RigSettings {
    let mut settings = RigSettings::default();
    let robot = &mut settings.robot;
    (robot.correction, robot.hold_on) = (correction, hold_on);
    (robot.actuator.delay_s, robot.actuator.pause_s) = (0.0, 0.0);
    settings
}

/// Positions after each cycle, in mm, for answers in mm; `None` is a missing answer.
fn travel(settings: &RigSettings, answers: &[Option<f64>]) -> Vec<f64> {
    let mut rig = Rig::new(settings, [0.0; 6], 0).unwrap();
    let mut positions = Vec::new();
    for (cycle, answer) in (1..).zip(answers) {
        rig.begin_cycle().unwrap();
        if let Some(mm) = answer {
            rig.answer(along_x(mm * 1e-3), false);
        }
        rig.advance_to(cycle * 4000);
        positions.push((rig.truth().pose.translation.x * 1e6).round() * 1e-3);
    }
    positions
}

#[test]
fn a_missing_answer_does_what_hold_on_says() {
    use CorrectionMode::{Absolute, Relative};
    let answers = [Some(0.5), Some(0.5), None, None, Some(0.5)];
    for (mode, hold_on, expected) in [
        (Relative, false, [0.5, 1.0, 1.0, 1.0, 1.5]),
        (Relative, true, [0.5, 1.0, 1.5, 2.0, 2.5]), // the runaway
        (Absolute, true, [0.5, 0.5, 0.5, 0.5, 0.5]),
        (Absolute, false, [0.5, 0.5, 0.0, 0.0, 0.5]), // the jump to zero and back
    ] {
        let got = travel(&immediate(mode, hold_on), &answers);
        assert_eq!(got, expected, "{mode:?} {hold_on}");
    }
}

#[test]
fn late_answers_are_counted_and_more_than_the_timeout_stops_the_robot() {
    for (counting, expected) in [
        (TimeoutCounting::Total, 8),
        (TimeoutCounting::Consecutive, 11),
    ] {
        let mut settings = RigSettings::default();
        (
            settings.robot.timeout_cycles,
            settings.robot.timeout_counting,
        ) = (3, counting);
        let mut rig = Rig::new(&settings, [0.0; 6], 0).unwrap();
        let mut late_answers = 0;
        let telegrams = (0..100).take_while(|n| {
            let report = rig.begin_cycle();
            if let Some(report) = report {
                late_answers = report.late_answers;
                if n % 2 == 0 && *n < 7 {
                    rig.answer([0.0; 6], false);
                }
            }
            report.is_some()
        });
        assert_eq!(telegrams.count(), expected, "{counting:?}");
        assert!(matches!(
            rig.stopped(),
            Some(RsiStopped::Timeout {
                late_answers: 4,
                allowed: 3
            })
        ));
        let stood = rig.truth().pose;
        rig.advance_to(60_000_000); // time goes on, the robot does not
        assert_eq!(rig.truth().pose, stood);
        assert!((rig.truth().time_s - 60.0).abs() < 1e-9);
        assert_eq!(rig.begin_cycle(), None);
    }
}

#[test]
fn an_answer_that_is_no_number_or_comes_twice_is_rejected() {
    let mut rig = Rig::new(&immediate(CorrectionMode::Relative, false), [0.0; 6], 0).unwrap();
    rig.begin_cycle().unwrap();
    rig.answer(along_x(f64::NAN), false);
    assert_eq!(rig.begin_cycle().unwrap().late_answers, 1);
    rig.answer(along_x(1e-3), false);
    rig.answer(along_x(3e-3), false);
    let report = rig.begin_cycle().unwrap();
    assert_eq!(report.late_answers, 1);
    assert!((report.actual_pose[0] - 1e-3).abs() < 1e-12);
}

#[test]
fn the_clamp_is_silent_cumulative_and_told_by_its_bits() {
    let mut settings = immediate(CorrectionMode::Relative, false);
    settings.robot.correction_limit.lower_m[2] = -1e-3;
    let mut rig = Rig::new(&settings, along_x(0.1), 0).unwrap();
    let mut report = rig.begin_cycle().unwrap();
    assert_eq!(report.poscorr_stat, 1);
    for _ in 0..10 {
        rig.answer([2e-3, 0.0, -1e-3, 0.0, 0.0, 0.02], false);
        report = rig.begin_cycle().unwrap();
    }
    assert!((report.actual_pose[0] - 0.105).abs() < 1e-12 && report.setpoint_pose[0] == 0.1);
    assert!((report.actual_pose[5] - 5.0_f64.to_radians()).abs() < 1e-12);
    assert_eq!(report.poscorr_stat, 1 | 1 << 3 | 1 << 4 | 1 << 7);
    // what was pushed into the limit is lost: the way back begins at once
    rig.answer([0.0; 6], false);
    assert_eq!(
        rig.begin_cycle().unwrap().poscorr_stat,
        report.poscorr_stat,
        "still at the limits"
    );
    rig.answer([-1e-3, 0.0, 5e-4, 0.0, 0.0, -0.01], false);
    report = rig.begin_cycle().unwrap();
    assert!((report.actual_pose[0] - 0.104).abs() < 1e-12 && report.poscorr_stat == 1);
}

#[test]
fn the_monitor_stops_a_diagonal_that_the_clamp_lets_through() {
    let mut rig = Rig::new(&immediate(CorrectionMode::Relative, false), [0.0; 6], 0).unwrap();
    rig.begin_cycle().unwrap();
    rig.answer([4.5e-3, 4.5e-3, 0.0, 0.0, 0.0, 0.0], false);
    assert_eq!(rig.begin_cycle(), None);
    let reason = rig.stopped().unwrap().to_string();
    assert!(
        reason.starts_with("KSS29000: correction of 0.00636"),
        "{reason}"
    );
}

#[test]
fn stop_in_the_answer_stops() {
    let mut rig = Rig::new(&RigSettings::default(), [0.0; 6], 0).unwrap();
    rig.begin_cycle().unwrap();
    rig.answer(along_x(1e-3), true);
    assert_eq!(
        (rig.begin_cycle(), rig.stopped()),
        (None, Some(RsiStopped::Requested))
    );
}

#[test]
fn feedback_is_as_late_and_as_coarse_as_set() {
    let mut settings = immediate(CorrectionMode::Relative, false);
    settings.robot.feedback_latency_cycles = 2;
    settings.robot.position_resolution_m = 1e-4;
    let mut rig = Rig::new(&settings, [0.0, 0.0, 0.0, 3.1, 0.0, 0.0], 0).unwrap();
    let mut seen = Vec::new();
    for _ in 0..6 {
        let [x, _, _, a, ..] = rig.begin_cycle().unwrap().actual_pose;
        seen.push(((x * 1e4).round(), a));
        rig.answer([1.4e-4, 0.0, 0.0, 0.03, 0.0, 0.0], false);
    }
    assert_eq!(
        seen.iter().map(|s| s.0).collect::<Vec<_>>(),
        [0.0, 0.0, 0.0, 1.0, 3.0, 4.0]
    );
    assert!(
        (seen[4].1 - (3.16 - TAU)).abs() < 1e-12,
        "angles stay within half a turn"
    );
}

#[test]
fn jitter_moves_whole_cycles_and_keeps_its_mean() {
    let mut settings = unlimited(RigSettings::default());
    settings.robot.delay_jitter_probability = 0.25;
    let mut rig = Rig::new(&settings, [0.0; 6], 3).unwrap();
    let (mut shifts, cycles) = ([0.0; 3], 4000);
    let (mut last, mut sent) = (0.0, 0.0);
    for n in 0..cycles {
        let x = rig.begin_cycle().unwrap().actual_pose[0];
        let cycles_back = if n > 20 { sent - (x - last) * 1e6 } else { 8.0 };
        let shift = (cycles_back - 8.0).round();
        assert!(
            (cycles_back - 8.0 - shift).abs() < 1e-6 && shift.abs() <= 1.0,
            "{n}: {cycles_back}"
        );
        shifts[(shift + 1.0) as usize] += 1.0 / f64::from(cycles);
        (last, sent) = (x, f64::from(n));
        rig.answer(along_x(sent * 1e-6), false); // the size of a step tells its cycle
    }
    for (share, expected) in shifts.iter().zip([0.25, 0.5, 0.25]) {
        assert!((share - expected).abs() < 0.03, "{shifts:?}");
    }
}
