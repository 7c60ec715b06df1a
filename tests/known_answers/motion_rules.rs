//! Rules that hold while the robot moves by us, whatever the mode: a stop that fades out is
//! guarded like a run, the box belongs to the RSI run, nothing moves between `arm` and `start`.

use softdock_app::record::CycleRecord;
use softdock_control::io::Sequence;
use softdock_control::modes::{Command, FaultCode, Mode, Refusal};
use softdock_tests::driver::{CycleDriver, cruising, flying, idle};

/// Lets the robot be where the corrections have taken it.
fn follow(driver: &mut CycleDriver<f64>, record: &CycleRecord) {
    if let Some(pose) = &mut driver.inputs.robot.pose {
        for (p, counts) in pose.iter_mut().zip(record.output.correction).take(3) {
            *p += counts as f64 * 1e-7;
        }
    }
}

#[test]
fn a_fading_stop_is_guarded_like_a_run() {
    type Spoil = fn(&mut softdock_app::record::Inputs);
    let cases: [(Spoil, FaultCode); 4] = [
        (|i| i.sensor.wrench[0] = 9000.0, FaultCode::Overload),
        (|i| i.sensor.saturated = true, FaultCode::SensorSaturated),
        (|i| i.sensor.status = 2, FaultCode::SensorStatus),
        (|i| i.sensor.wrench[1] = f64::NAN, FaultCode::Numeric),
    ];
    for (spoil, code) in cases {
        let mut driver = cruising::<f64>(&flying(0.01));
        let record = driver.command(Command::Stop);
        assert_eq!(record.trace.mode, Mode::Hold);
        assert_ne!(record.output.correction, [0; 6], "the stop fades out");
        let record = driver.step_with(spoil);
        assert_eq!(record.trace.fault.map(|f| f.code), Some(code));
        assert_eq!(record.output.correction, [0; 6], "{code:?}");
    }
}

#[test]
fn at_rest_in_hold_nothing_latches() {
    let mut driver = idle::<f64>(&flying(0.01));
    driver.command(Command::Hold);
    let record = driver.step_with(|inputs| inputs.sensor.saturated = true);
    assert_eq!(record.trace.mode, Mode::Hold);
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
fn a_robot_that_was_moved_after_arming_is_armed_again() {
    let mut driver = idle::<f64>(&flying(0.01));
    driver.arm().unwrap();
    driver.inputs.robot.pose = Some([0.002, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let record = driver.command(Command::Start);
    assert_eq!(record.trace.refusal, Some(Refusal::MovedSinceArmed));
    assert_eq!(record.trace.mode, Mode::Armed);
    driver.command(Command::Hold);
    driver.start().unwrap();
}

#[test]
fn zero_needs_a_steady_mean_and_does_not_hide_a_contact() {
    let mut driver = idle::<f64>(&flying(0.01));
    let record = driver.command(Command::Hold);
    assert_eq!(record.trace.refusal, None);
    let record = driver.command(Command::Zero);
    assert_eq!(record.trace.refusal, Some(Refusal::TooFewSamples));
    driver.inputs.sensor.wrench[0] = 500.0;
    for _ in 0..500 {
        driver.step();
    }
    let record = driver.command(Command::Zero);
    assert_eq!(record.trace.refusal, Some(Refusal::ForceTooLarge));
}

#[test]
fn the_request_to_stop_ends_with_the_run() {
    let mut driver = cruising::<f64>(&flying(0.01));
    let record = driver.step_with(|inputs| inputs.sensor.wrench[0] = 9000.0);
    assert!(record.output.stop);
    assert!(driver.step().output.stop);
    let record = driver.step_with(|inputs| inputs.robot.sequence = Sequence::NewRun);
    assert!(!record.output.stop, "the next run must be able to begin");
    assert_eq!(record.trace.mode, Mode::Fault);
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
