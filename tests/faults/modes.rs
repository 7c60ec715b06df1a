//! The operator's commands, the start ramp and the stop, through the whole cycle.

use super::SPEED_M_S;
use softdock_app::record::Inputs;
use softdock_control::jog::Jog;
use softdock_control::modes::{Command, FaultCode, Mode, Refusal};
use softdock_control::scalar::Scalar;
use softdock_tests::driver::{CycleDriver, cruising, flying, idle};
use softdock_tests::in_three_scalars;

/// A driver in a mode, with healthy data and at rest (but for Running).
fn in_mode<S: Scalar>(mode: Mode) -> CycleDriver<S> {
    let mut driver = idle::<S>(&flying(SPEED_M_S));
    match mode {
        Mode::Idle => {}
        Mode::Hold => {
            driver.command(Command::Hold);
        }
        Mode::Armed => {
            driver.arm().unwrap();
        }
        Mode::Running => {
            driver.start().unwrap();
        }
        Mode::Fault => {
            driver.arm().unwrap();
            driver.step_with(|inputs| inputs.sensor.saturated = true);
        }
        Mode::Jogging => {
            driver.command(Command::Hold);
            driver.command(Command::Jog(Jog::X));
        }
    }
    driver.step();
    assert_eq!(driver.cycle.mode(), mode);
    driver
}

type Spoil = fn(&mut Inputs);

/// Data with which the rig must not be armed, started or reset.
fn unfit() -> Vec<(Spoil, Refusal)> {
    vec![
        (|i| i.sensor.status = 4, Refusal::SensorUnhealthy),
        (|i| i.sensor.saturated = true, Refusal::SensorUnhealthy),
        (|i| i.sensor.wrench[1] = f64::NAN, Refusal::SensorUnhealthy),
        (|i| i.sensor.wrench[2] = 21.0, Refusal::ForceTooLarge),
        (|i| i.sensor.wrench[3] = -6.0, Refusal::ForceTooLarge),
        (|i| i.robot.pose = None, Refusal::NoPose),
        (
            |i| i.robot.pose = Some([0.0, 0.0, 0.0, 0.0, 1.5, 0.0]),
            Refusal::OrientationSingular,
        ),
        (
            |i| i.robot.pose = Some([f64::NAN; 6]),
            Refusal::SensorUnhealthy,
        ),
    ]
}

fn a_refused_command_changes_nothing<S: Scalar>() {
    for (mode, command) in [
        (Mode::Hold, Command::Arm),
        (Mode::Hold, Command::Jog(Jog::Y)),
        (Mode::Armed, Command::Start),
        (Mode::Fault, Command::Reset),
    ] {
        for (spoil, refusal) in unfit() {
            let mut driver = in_mode::<S>(mode);
            let record = driver.step_with(|inputs| {
                spoil(inputs);
                inputs.command = Some(command);
            });
            assert_eq!(record.trace.refusal, Some(refusal), "{command:?}");
            assert_eq!(record.output.correction, [0; 6]);
            // Armed, what is unfit may be a fault as well.
            let stays = record.trace.mode == mode || record.trace.mode == Mode::Fault;
            assert!(
                stays,
                "{command:?} with {refusal:?}: {:?}",
                record.trace.mode
            );
        }
        let mut driver = in_mode::<S>(mode);
        for _ in 0..3 {
            driver.step_stale(|_| {});
        }
        let record = driver.step_stale(|inputs| inputs.command = Some(command));
        assert_eq!(
            record.trace.refusal,
            Some(Refusal::SensorStale),
            "{command:?}"
        );
    }
}

/// Before the first sample nothing is fresh.
fn no_sensor_no_arming<S: Scalar>() {
    let mut driver = idle::<S>(&flying(SPEED_M_S));
    driver.step_stale(|inputs| inputs.command = Some(Command::Hold));
    let record = driver.step_stale(|inputs| inputs.command = Some(Command::Arm));
    assert_eq!(record.trace.refusal, Some(Refusal::SensorStale));
}

/// Two cycles of zero, then a ramp that begins at zero and has the full velocity after 25 cycles.
fn the_start_is_a_ramp<S: Scalar>() {
    let settings = flying(SPEED_M_S);
    let mut driver = idle::<S>(&settings);
    let mut sent = vec![driver.start().unwrap().output.correction[0]];
    sent.extend((0..40).map(|_| driver.step().output.correction[0]));
    for (n, counts) in sent.iter().enumerate() {
        let share = (n as f64 - 2.0).clamp(0.0, 25.0) / 25.0;
        assert!(
            (*counts as f64 - 400.0 * share).abs() <= 1.0,
            "{n}: {sent:?}"
        );
    }
    assert_eq!(sent[..2], [0, 0]);
}

/// A stop takes the velocity away in equal steps of its 100 ms; only then may one arm again.
fn a_stop_fades_out<S: Scalar>() {
    for command in [Command::Stop, Command::Hold] {
        let mut driver = cruising::<S>(&flying(SPEED_M_S));
        let mut sent = vec![driver.command(command).output.correction[0]];
        for _ in 1..25 {
            let record = driver.command(Command::Arm);
            assert_eq!(record.trace.refusal, Some(Refusal::StillMoving));
            assert_eq!(record.trace.mode, Mode::Hold);
            sent.push(record.output.correction[0]);
        }
        for (n, counts) in sent.iter().enumerate() {
            let share = 1.0 - (n as f64 + 1.0) / 25.0;
            assert!(
                (*counts as f64 - 400.0 * share).abs() <= 1.0,
                "{n}: {sent:?}"
            );
        }
        let record = driver.command(Command::Arm);
        assert_eq!(
            (record.trace.mode, record.output.correction),
            (Mode::Armed, [0; 6])
        );
    }
}

/// A fault latches with its first cause; a reset with healthy data leads to Hold, and the next
/// start begins with zeros again.
fn a_fault_latches_and_the_next_start_is_gentle<S: Scalar>() {
    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    driver.step_with(|inputs| inputs.sensor.saturated = true);
    driver.step_with(|inputs| inputs.sensor.wrench[0] = 1e5);
    let record = driver.step();
    assert_eq!(
        record.trace.fault.map(|f| f.code),
        Some(FaultCode::SensorSaturated)
    );
    let record = driver.command(Command::Reset);
    assert_eq!((record.trace.mode, record.trace.fault), (Mode::Hold, None));
    assert_eq!(record.output.correction, [0; 6]);
    assert_eq!(driver.command(Command::Arm).output.correction, [0; 6]);
    assert_eq!(driver.command(Command::Start).output.correction, [0; 6]);
    for _ in 0..2 {
        assert_eq!(driver.step().output.correction, [0; 6]);
    }
    let first = driver.step().output.correction[0];
    assert!((first - 16).abs() <= 1, "{first}");
}

/// A fault during the fading out of a stop ends it at once.
fn a_reset_after_a_stop_does_not_resume<S: Scalar>() {
    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    driver.command(Command::Stop);
    driver.step();
    driver.step_with(|inputs| {
        inputs.robot.sequence = softdock_control::io::Sequence::NewRun;
    });
    for _ in 0..50 {
        assert_eq!(driver.step().output.correction, [0; 6]);
    }
}

/// `zero` makes the present mean reading the sensor's zero; tolerance in N and N·m.
fn zero_takes_the_mean_reading<S: Scalar>(tolerance: f64) {
    let mut driver = idle::<S>(&flying(SPEED_M_S));
    driver.inputs.sensor.wrench = [12.0, -7.0, 30.0, 0.5, -0.25, 1.0];
    driver.command(Command::Hold);
    for _ in 0..1500 {
        driver.step();
    }
    driver.command(Command::Zero);
    let left = driver.step().trace.wrench_at_m;
    assert!(left.iter().all(|v| v.abs() < tolerance), "{left:?}");
}

/// An overload is no rest: what it leaves in the mean is not taken for the sensor's zero; nor is a contact.
fn zero_waits_for_rest_after_an_overload<S: Scalar>() {
    let mut driver = idle::<S>(&flying(SPEED_M_S));
    driver.command(Command::Hold);
    for _ in 0..100 {
        driver.step();
    }
    driver.step_with(|inputs| inputs.sensor.wrench[2] = 3500.0);
    let refused = |driver: &mut CycleDriver<S>| driver.command(Command::Zero).trace.refusal;
    assert_eq!(refused(&mut driver), Some(Refusal::TooFewSamples));
    for _ in 0..64 {
        driver.step();
    }
    assert_eq!(refused(&mut driver), None);
    assert_eq!(driver.step().trace.wrench_at_m, [0.0; 6]);
    driver.inputs.sensor.wrench[0] = 500.0;
    for _ in 0..500 {
        driver.step();
    }
    assert_eq!(refused(&mut driver), Some(Refusal::ForceTooLarge));
}

in_three_scalars! {
    overload_and_zero: zero_waits_for_rest_after_an_overload,
    refusals: a_refused_command_changes_nothing,
    before_the_first_sample: no_sensor_no_arming,
    start: the_start_is_a_ramp,
    stop: a_stop_fades_out,
    latch: a_fault_latches_and_the_next_start_is_gentle,
    stop_and_new_run: a_reset_after_a_stop_does_not_resume,
    /// e^(−1500/64) of 30 N is 2e-9; f32 and fixed stop converging where a 64th of the
    /// difference is below their resolution.
    zero: zero_takes_the_mean_reading => f64 1e-8, f32 1e-3, fixed 1e-6
}
