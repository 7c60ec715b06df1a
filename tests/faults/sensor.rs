//! What a sensor does wrong, and what the cycle answers: each event through the whole cycle.

use super::{CRUISE_COUNTS, SPEED_M_S, assert_fault};
use softdock_app::record::Inputs;
use softdock_control::io::{SensorSample, Sequence};
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, FaultCode, Mode, Refusal};
use softdock_control::scalar::Scalar;
use softdock_tests::driver::{cruising, flying, idle, started};
use softdock_tests::in_three_scalars;

/// Up to two cycles without a sample change nothing; then the rate falls to zero by thirds; more
/// than five latch a fault.
fn an_old_sample_ramps_the_rate_down_then_faults<S: Scalar>() {
    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    let mut body = None;
    for (age, counts) in [
        (1, 400),
        (2, 400),
        (3, 267),
        (4, 133),
        (5, 0),
        (6, 0),
        (7, 0),
    ] {
        let record = driver.step_stale(|_| {});
        assert_eq!(record.trace.sensor_age, age);
        let sent = record.output.correction[0];
        assert!((sent - counts).abs() <= 1, "age {age}: {sent}");
        assert_eq!(record.trace.mode == Mode::Fault, age > 5, "age {age}");
        assert!(!record.output.stop);
        if age == 3 {
            assert!(record.trace.limits.has(LimitFlags::SENSOR_STALE));
            body = Some(record.trace.body_k);
        } else if age > 3 {
            assert_eq!(
                Some(record.trace.body_k),
                body,
                "the model is not integrated"
            );
        }
    }
    assert_fault(&driver, FaultCode::SensorStale, 5.0, 6.0);
}

fn a_sample_in_time_brings_the_rate_back<S: Scalar>() {
    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    for _ in 0..5 {
        driver.step_stale(|_| {});
    }
    for counts in [133, 267, 400, 400] {
        let sent = driver.step().output.correction[0];
        assert!((sent - counts).abs() <= 1, "{sent}, not {counts}");
    }
    assert_eq!(driver.cycle.mode(), Mode::Running);
}

/// By default: from the third repeated reading on the model is held and the rate falls, then a fault latches,
/// as soon as the worst load could have bent the motion by a step: 3000 N on 500 kg need 25 ms for 2 mm.
fn a_frozen_sensor_is_stale_then_faults<S: Scalar>() {
    let settings = flying(SPEED_M_S);
    let frozen = |inputs: &mut Inputs| {
        inputs.sensor.counts = [7; 6];
        inputs.sensor.wrench[0] = -10.0;
    };
    let mut driver = cruising::<S>(&settings);
    for _ in 0..3 {
        assert_eq!(driver.step_with(frozen).trace.fault, None);
    }
    driver.step();
    for _ in 0..3 {
        let record = driver.step_with(frozen);
        let stale = LimitFlags::SENSOR_STALE;
        assert!(!record.trace.limits.has(stale), "a flicker starts anew");
    }
    let held = driver.step_with(frozen).trace;
    assert!(held.limits.has(LimitFlags::SENSOR_STALE));
    while driver.cycle.fault().is_none() {
        let body = driver.step_with(frozen).trace.body_k;
        assert_eq!(body, held.body_k, "the model is not integrated");
    }
    assert_fault(&driver, FaultCode::SensorFrozen, 5.0, 6.0);
}

/// A light spacecraft allows fewer repeats; a sensor that is said to have no noise any number.
fn how_long_a_sensor_may_repeat<S: Scalar>() {
    let frozen = |inputs: &mut Inputs| inputs.sensor.counts = [7; 6];
    let mut settings = flying(SPEED_M_S);
    settings.body_k.mass_kg = 50.0;
    let mut driver = cruising::<S>(&settings);
    // 3000 N on 50 kg move 2 mm in 8.2 ms.
    for _ in 0..4 {
        driver.step_with(frozen);
    }
    assert_fault(&driver, FaultCode::SensorFrozen, 2.0, 3.0);

    settings.sensor.frozen_after_cycles = 0;
    let mut driver = cruising::<S>(&settings);
    for _ in 0..2000 {
        let trace = driver.step_with(frozen).trace;
        assert_eq!((trace.fault, trace.limits), (None, LimitFlags::default()));
    }
}

type Spoil = fn(&mut SensorSample);

/// Events that latch at once: what is spoiled, and the fault with its numbers.
fn at_once() -> Vec<(Spoil, FaultCode, f64, f64)> {
    vec![
        (|s| s.status = 0x8001, FaultCode::SensorStatus, 0.0, 32769.0),
        (|s| s.saturated = true, FaultCode::SensorSaturated, 0.0, 1.0),
        (
            |s| s.wrench[0] = 3500.0,
            FaultCode::Overload,
            3000.0,
            3500.0,
        ),
        (
            |s| s.wrench[2] = -3500.0,
            FaultCode::Overload,
            3000.0,
            3500.0,
        ),
        (|s| s.wrench[4] = 600.0, FaultCode::Overload, 500.0, 600.0),
        (|s| s.wrench[0] = f64::NAN, FaultCode::Numeric, 0.0, 0.0),
        (
            |s| s.wrench[3] = f64::INFINITY,
            FaultCode::Numeric,
            0.0,
            0.0,
        ),
        (
            |s| s.wrench[5] = f64::NEG_INFINITY,
            FaultCode::Numeric,
            0.0,
            0.0,
        ),
    ]
}

/// Zero in the same cycle, for ever, in a run and while a stop of it fades out; only an overload also asks the robot to
/// stop, until its run ends.
fn an_unhealthy_sample_latches_at_once<S: Scalar>() {
    let fading = at_once().into_iter().map(|case| (true, case));
    let running = at_once().into_iter().map(|case| (false, case));
    for (fades, (spoil, code, expected, received)) in running.chain(fading) {
        let mut driver = cruising::<S>(&flying(SPEED_M_S));
        if fades {
            let record = driver.command(Command::Stop);
            assert_eq!(record.trace.mode, Mode::Hold);
            assert_ne!(record.output.correction, [0; 6]);
        }
        let record = driver.step_with(|inputs| spoil(&mut inputs.sensor));
        assert_fault(&driver, code, expected, received);
        assert_eq!(record.trace.fault, driver.cycle.fault());
        assert_eq!(record.output.correction, [0; 6], "{code:?}");
        assert_eq!(record.output.stop, code == FaultCode::Overload);
        for _ in 0..100 {
            let record = driver.step();
            assert_eq!(record.output.correction, [0; 6], "{code:?} moves");
            assert_eq!(record.output.stop, code == FaultCode::Overload);
        }
        assert_fault(&driver, code, expected, received);
        let record = driver.step_with(|inputs| inputs.robot.sequence = Sequence::NewRun);
        assert!(!record.output.stop, "the next run must be able to begin");
        assert_eq!(record.trace.mode, Mode::Fault);
    }
}

/// The same while armed; before that, a bad sample only keeps the rig from being armed.
fn an_unhealthy_sample_counts_when_armed_and_not_before<S: Scalar>() {
    for (spoil, code, ..) in at_once() {
        let mut driver = idle::<S>(&flying(SPEED_M_S));
        driver.arm().unwrap();
        driver.step_with(|inputs| spoil(&mut inputs.sensor));
        assert_eq!(driver.cycle.fault().map(|f| f.code), Some(code));

        let mut driver = idle::<S>(&flying(SPEED_M_S));
        driver.command(Command::Hold);
        driver.step_with(|inputs| spoil(&mut inputs.sensor));
        assert_eq!(driver.cycle.fault(), None);
        let record = driver.step_with(|inputs| {
            spoil(&mut inputs.sensor);
            inputs.command = Some(Command::Arm);
        });
        assert!(record.trace.refusal.is_some(), "{code:?}");
        assert_eq!(record.trace.mode, Mode::Hold);
    }
}

fn an_ignored_status_bit_is_ignored<S: Scalar>() {
    let mut settings = flying(SPEED_M_S);
    settings.sensor.ignored_status_bits = 0x8000;
    let mut driver = cruising::<S>(&settings);
    let record = driver.step_with(|inputs| inputs.sensor.status = 0x8000);
    assert_eq!(record.output.correction[0], CRUISE_COUNTS);
    driver.step_with(|inputs| inputs.sensor.status = 0x8001);
    assert_fault(&driver, FaultCode::SensorStatus, 0.0, 1.0);
}

fn an_overload_stops_the_robot_only_if_asked<S: Scalar>() {
    let mut settings = flying(SPEED_M_S);
    settings.limits.stop_on_overload = false;
    let mut driver = cruising::<S>(&settings);
    let record = driver.step_with(|inputs| inputs.sensor.wrench[1] = 1e5);
    assert_eq!(record.trace.mode, Mode::Fault);
    assert!(!record.output.stop);
}

/// The stop is asked for until the reset, and the reset waits for the force to go.
fn an_overload_is_over_with_its_reset<S: Scalar>() {
    let mut driver = cruising::<S>(&flying(SPEED_M_S));
    driver.inputs.sensor.wrench[0] = -4000.0;
    driver.step();
    let record = driver.command(Command::Reset);
    assert_eq!(record.trace.refusal, Some(Refusal::ForceTooLarge));
    assert!(record.output.stop);
    driver.inputs.sensor.wrench[0] = -10.0;
    assert!(driver.step().output.stop);
    let record = driver.command(Command::Reset);
    assert_eq!((record.trace.mode, record.output.stop), (Mode::Hold, false));
    assert_eq!(record.output.correction, [0; 6]);
}

/// A force that would be a contact later is a fault while the start ramp runs.
fn contact_during_the_start_ramp_faults<S: Scalar>() {
    let settings = flying(SPEED_M_S);
    let touch = |inputs: &mut Inputs| inputs.sensor.wrench[0] = -25.0;
    let mut driver = started::<S>(&settings);
    driver.step();
    let record = driver.step_with(touch);
    assert_fault(&driver, FaultCode::ContactAtStart, 20.0, 25.0);
    assert_eq!(record.output.correction, [0; 6]);
    assert!(!record.output.stop);

    let mut driver = cruising::<S>(&settings);
    assert_eq!(driver.step_with(touch).trace.fault, None);
}

in_three_scalars! {
    stale: an_old_sample_ramps_the_rate_down_then_faults,
    back_in_time: a_sample_in_time_brings_the_rate_back,
    frozen: a_frozen_sensor_is_stale_then_faults,
    repeats: how_long_a_sensor_may_repeat,
    at_once_in_running: an_unhealthy_sample_latches_at_once,
    at_once_in_armed: an_unhealthy_sample_counts_when_armed_and_not_before,
    ignored_status: an_ignored_status_bit_is_ignored,
    overload_without_stop: an_overload_stops_the_robot_only_if_asked,
    overload_and_reset: an_overload_is_over_with_its_reset,
    contact_in_the_ramp: contact_during_the_start_ramp_faults
}
