//! What the robot's side does wrong, and what the cycle answers: each event through the whole
//! cycle.

use super::{CRUISE_COUNTS, SPEED_M_S, assert_fault};
use softdock_app::record::CycleRecord;
use softdock_control::io::Sequence;
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, FaultCode, Mode, Refusal};
use softdock_control::scalar::Scalar;
use softdock_control::settings::CorrectionMode;
use softdock_tests::driver::{CycleDriver, cruising, flying, idle};
use softdock_tests::in_three_scalars;

/// A gap is counted, not made up for: the correction is that of one cycle.
fn lost_telegrams_do_not_multiply_the_correction<S: Scalar>() {
    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    for lost in [1, 3, 10] {
        let record = driver.step_with(|inputs| inputs.robot.sequence = Sequence::Gap(lost));
        let sent = record.output.correction[0];
        assert!((sent - CRUISE_COUNTS).abs() <= 1, "gap {lost}: {sent}");
        assert_eq!(record.trace.fault, None);
    }
    driver.step_with(|inputs| inputs.robot.sequence = Sequence::Gap(11));
    assert_fault(&driver, FaultCode::TelegramsLost, 10.0, 11.0);
}

/// A new RSI run: Running faults, Armed falls back to Hold, the others stay.
fn a_new_run_never_moves<S: Scalar>() {
    let new_run = |driver: &mut CycleDriver<S>| {
        let record = driver.step_with(|inputs| inputs.robot.sequence = Sequence::NewRun);
        assert_eq!(record.output.correction, [0; 6]);
        record.trace.mode
    };
    let mut driver = idle::<S>(&flying(SPEED_M_S));
    driver.step();
    assert_eq!(new_run(&mut driver), Mode::Idle);
    driver.command(Command::Hold);
    assert_eq!(new_run(&mut driver), Mode::Hold);
    driver.command(Command::Arm);
    assert_eq!(new_run(&mut driver), Mode::Hold);

    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    assert_eq!(new_run(&mut driver), Mode::Fault);
    assert_fault(&driver, FaultCode::RobotRestarted, 0.0, 0.0);
}

/// Only the rise since the start counts.
fn late_answers_fault<S: Scalar>() {
    let mut driver = idle::<S>(&flying(SPEED_M_S));
    driver.inputs.robot.late_answers = 1000;
    driver.start().unwrap();
    for _ in 0..100 {
        driver.step();
    }
    driver.inputs.robot.late_answers = 1025;
    assert_eq!(driver.step().trace.fault, None);
    driver.inputs.robot.late_answers = 1026;
    assert_eq!(driver.step().output.correction, [0; 6]);
    assert_fault(&driver, FaultCode::LateAnswers, 25.0, 26.0);
}

fn a_lost_pose_faults<S: Scalar>() {
    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    let record = driver.step_with(|inputs| inputs.robot.pose = None);
    assert_fault(&driver, FaultCode::PoseLost, 1.0, 0.0);
    assert_eq!(record.output.correction, [0; 6]);
}

fn a_pose_that_is_no_number_faults<S: Scalar>() {
    for (i, value) in [
        (0, f64::NAN),
        (2, f64::INFINITY),
        (3, f64::NEG_INFINITY),
        (5, f64::NAN),
    ] {
        let mut driver = cruising::<S>(&flying(SPEED_M_S));
        let record = driver.step_with(|inputs| {
            if let Some(pose) = inputs.robot.pose.as_mut() {
                pose[i] = value;
            }
        });
        assert_fault(&driver, FaultCode::Numeric, 0.0, 0.0);
        assert_eq!(record.output.correction, [0; 6]);
        assert!(record.trace.pose.iter().all(|v| v.is_finite()));
    }
}

/// POSCORR clamps (status bits 1 to 7): the model waits, the rate falls; what lasts is a fault.
/// Bit 0 only says that POSCORR is active.
fn a_robot_that_clamps_freezes_the_model<S: Scalar>() {
    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    let record = driver.step_with(|inputs| inputs.robot.status = 1);
    assert_eq!(record.output.correction[0], CRUISE_COUNTS);
    for bit in 1..8 {
        let mut driver = driver.clone();
        driver.inputs.robot.status = 1 | 1 << bit;
        let body = driver.step().trace.body_k;
        let record = driver.step();
        assert!(record.trace.limits.has(LimitFlags::ROBOT_CLAMP));
        assert_eq!(record.trace.body_k, body, "bit {bit}");
        driver.step();
        for _ in 3..25 {
            assert_eq!(driver.step().output.correction, [0; 6]);
        }
        assert_eq!(driver.cycle.fault(), None);
        driver.step();
        assert_fault(&driver, FaultCode::SustainedClamp, 25.0, 26.0);
    }
}

/// The box stops the motion at its wall; a robot that leans on it for long is a fault.
fn a_box_is_kept_and_then_faults<S: Scalar>(tolerance_m: f64) {
    let mut settings = flying(SPEED_M_S);
    settings.limits.box_m = [0.005; 3];
    (settings.jog.speed_m_s, settings.jog.reach_m) = (0.005, 0.005);
    let mut driver = cruising::<S>(&settings);
    let mut at_wall = 0;
    for _ in 0..1000 {
        let record = driver.step();
        assert!(record.trace.command_pose[0] <= 0.005 + tolerance_m);
        at_wall += u32::from(record.trace.limits.has(LimitFlags::BOX));
        if record.trace.mode == Mode::Fault {
            break;
        }
    }
    assert_eq!(at_wall, 26);
    assert_fault(&driver, FaultCode::SustainedClamp, 25.0, 26.0);
}

fn a_robot_that_was_moved_after_arming_is_armed_again<S: Scalar>() {
    let mut driver = idle::<S>(&flying(SPEED_M_S));
    driver.arm().unwrap();
    driver.inputs.robot.pose = Some([0.002, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let record = driver.command(Command::Start);
    assert_eq!(record.trace.refusal, Some(Refusal::MovedSinceArmed));
    assert_eq!(record.trace.mode, Mode::Armed);
    driver.command(Command::Hold);
    driver.start().unwrap();
}

/// With absolute corrections, rest is the offset that was reached: in a fault, in a hold, until
/// the robot forgets it.
fn absolute_mode_holds_the_offset<S: Scalar>() {
    let mut settings = flying(SPEED_M_S);
    settings.robot.correction_mode = CorrectionMode::Absolute;
    let mut driver = cruising::<S>(&settings);
    let reached = driver.step().output.correction;
    assert!(reached[0] > 1000, "{reached:?}");
    for _ in 0..10 {
        let record = driver.step_with(|inputs| inputs.sensor.saturated = true);
        assert_eq!(record.trace.mode, Mode::Fault);
        assert_eq!(record.output.correction, reached);
    }
    let record = driver.command(Command::Reset);
    assert_eq!(
        (record.trace.mode, record.output.correction),
        (Mode::Hold, reached)
    );
    // A second run goes on from there.
    let record = driver.command(Command::Arm);
    assert_eq!(record.output.correction, reached);
    assert_eq!(driver.command(Command::Start).output.correction, reached);
    for _ in 0..40 {
        driver.step();
    }
    let on = driver.step().output.correction;
    assert!(
        on[0] > reached[0] + 10 * CRUISE_COUNTS,
        "{on:?} from {reached:?}"
    );
    let record = driver.step_with(|inputs| inputs.robot.sequence = Sequence::NewRun);
    assert_eq!(record.output.correction, [0; 6]);
}

in_three_scalars! {
    gaps: lost_telegrams_do_not_multiply_the_correction,
    new_run: a_new_run_never_moves,
    late: late_answers_fault,
    pose_lost: a_lost_pose_faults,
    pose_not_finite: a_pose_that_is_no_number_faults,
    poscorr: a_robot_that_clamps_freezes_the_model,
    /// Rounding of a division by the cycle time.
    box_wall: a_box_is_kept_and_then_faults => f64 1e-15, f32 1e-9, fixed 1e-9,
    moved: a_robot_that_was_moved_after_arming_is_armed_again,
    absolute: absolute_mode_holds_the_offset
}

/// Lets the robot be where the corrections have taken it.
fn follow(driver: &mut CycleDriver<f64>, record: &CycleRecord) {
    if let Some(pose) = &mut driver.inputs.robot.pose {
        for (p, counts) in pose.iter_mut().zip(record.output.correction).take(3) {
            *p += counts as f64 * 1e-7;
        }
    }
}

#[test]
fn the_box_is_around_the_start_of_the_rsi_run_not_of_each_arming() {
    let mut settings = flying(0.2);
    settings.limits.box_m = [0.1; 3];
    settings.limits.clamp_fault_cycles = 10_000;
    let mut driver = idle::<f64>(&settings);
    for _ in 0..2 {
        driver.start().unwrap();
        for _ in 0..150 {
            let record = driver.step();
            follow(&mut driver, &record);
        }
        driver.command(Command::Stop);
        for _ in 0..40 {
            let record = driver.step();
            follow(&mut driver, &record);
        }
    }
    let x = driver.inputs.robot.pose.unwrap()[0];
    assert!(x <= 0.1 + 1e-6 && x > 0.09, "{x}");
}

#[test]
fn a_gap_does_not_look_like_an_acceleration() {
    let mut driver = idle::<f64>(&flying(0.0));
    let speed = 0.3;
    let mut x = 0.0;
    for n in 0..200 {
        let lost = if n == 150 { 5 } else { 0 };
        x += speed * 0.004 * f64::from(lost + 1);
        driver.inputs.robot.pose = Some([x, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let record = driver.step_with(|inputs| {
            if lost > 0 {
                inputs.robot.sequence = Sequence::Gap(lost);
            }
        });
        if n > 0 {
            let executed = record.trace.executed_velocity[0];
            assert!((executed - speed).abs() < 1e-9, "{n}: {executed}");
        }
    }
}
