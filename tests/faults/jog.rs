//! The operator's jog through the whole cycle: where it goes, what refuses it, what ends it.

use softdock_app::record::{CycleRecord, Inputs};
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::io::Sequence;
use softdock_control::jog::Jog;
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, FaultCode, Mode, Refusal};
use softdock_control::scalar::Scalar;
use softdock_control::settings::Settings;
use softdock_tests::driver::{CycleDriver, flying, idle};
use softdock_tests::in_three_scalars;

/// Longest jog that the settings allow, cycles.
const LONGEST: usize = 6000;
/// Last decimal of a correction, m and rad.
const DIGIT: [f64; 2] = [1e-7, 1e-4 * std::f64::consts::PI / 180.0];

/// A driver in hold whose robot goes where the corrections send it.
fn holding<S: Scalar>(settings: &Settings) -> CycleDriver<S> {
    let mut driver = idle(settings);
    driver.step();
    driver.command(Command::Hold);
    driver
}

/// Every place that the robot was told to go to until the jog was over: displacement and angles.
fn jogged<S: Scalar>(driver: &mut CycleDriver<S>, jog: Jog) -> (Vec<[f64; 6]>, Vec<CycleRecord>) {
    let mut record = driver.command(Command::Jog(jog));
    assert_eq!(record.trace.refusal, None, "{jog:?}");
    let (mut place, mut places, mut records) = ([0_i64; 6], Vec::new(), Vec::new());
    while record.trace.mode == Mode::Jogging {
        assert!(records.len() < LONGEST, "{jog:?} never ends");
        for (place, step) in place.iter_mut().zip(record.output.correction) {
            *place += step;
        }
        let now: [f64; 6] = std::array::from_fn(|i| place[i] as f64 * DIGIT[i / 3]);
        driver.inputs.robot.pose = Some(now);
        places.push(now);
        records.push(record);
        record = driver.step();
    }
    records.push(record);
    (places, records)
}

/// One axis moves, to its own side, no farther and no faster than the settings say, without any
/// limit, and comes back; then the board holds.
fn a_jog_goes_out_and_comes_back<S: Scalar>() {
    let settings = flying(0.01);
    for (_, command) in Command::WORDS {
        let Command::Jog(jog) = command else { continue };
        let mut driver = holding::<S>(&settings);
        let (places, records) = jogged(&mut driver, jog);
        let (component, sign) = jog.component();
        // The corrections are X Y Z A B C: A turns about z.
        let axis = [0, 1, 2, 5, 4, 3][component];
        let (speed, reach) = settings.jog.motion(jog);
        let digit = DIGIT[axis / 3];
        let mut farthest: f64 = 0.0;
        for place in &places {
            let along = place[axis] * sign;
            assert!(along >= -digit && along <= reach, "{jog:?}: {along}");
            farthest = farthest.max(along);
            for (other, off) in place.iter().enumerate() {
                assert!(other == axis || off.abs() <= digit, "{jog:?}: {place:?}");
            }
        }
        assert!(farthest > 0.5 * reach, "{jog:?}: {farthest} of {reach}");
        let end = places.last().unwrap()[axis];
        assert!(end.abs() <= digit, "{jog:?} ends at {end}");
        for record in &records {
            let trace = &record.trace;
            assert_eq!(trace.limits, LimitFlags::default(), "{jog:?}: {trace:?}");
            assert!(trace.sent_velocity[component].abs() <= 1.6001 * speed);
        }
        let last = records.last().unwrap();
        assert_eq!(
            (last.trace.mode, last.output.correction),
            (Mode::Hold, [0; 6])
        );
        assert_eq!(driver.command(Command::Arm).trace.mode, Mode::Armed);
    }
}

/// The box is around the pose in which RSI began, not around the one in which the jog begins.
fn a_jog_without_room_is_refused<S: Scalar>() {
    let mut settings = flying(0.01);
    settings.limits.box_m = [0.06, 0.25, 0.25];
    let at = |pose: [f64; 6], jog| {
        let mut driver = holding::<S>(&settings);
        driver.inputs.robot.pose = Some(pose);
        driver.step();
        driver.command(Command::Jog(jog)).trace.refusal
    };
    let no_room = Some(Refusal::NoRoom);
    assert_eq!(at([0.009, 0.0, 0.0, 0.0, 0.0, 0.0], Jog::X), None);
    assert_eq!(at([0.011, 0.0, 0.0, 0.0, 0.0, 0.0], Jog::X), no_room);
    assert_eq!(at([0.011, 0.0, 0.0, 0.0, 0.0, 0.0], Jog::MinusX), None);
    assert_eq!(at([0.011, 0.0, 0.0, 0.0, 0.0, 0.0], Jog::Y), None);
    assert_eq!(at([-0.011, 0.0, 0.0, 0.0, 0.0, 0.0], Jog::MinusX), no_room);
    assert_eq!(at([-0.07, 0.0, 0.0, 0.0, 0.0, 0.0], Jog::X), no_room);
    assert_eq!(at([0.0, 0.0, 0.0, 0.27, 0.0, 0.0], Jog::A), None);
    assert_eq!(at([0.0, 0.0, 0.0, 0.28, 0.0, 0.0], Jog::A), no_room);
    // Near B = 90° the angles cannot be told apart.
    settings.limits.box_rad = 1.5;
    let mut driver = idle::<S>(&settings);
    driver.inputs.robot.pose = Some([0.0, 0.0, 0.0, 0.0, 1.35, 0.0]);
    driver.step();
    driver.command(Command::Hold);
    let refused = driver.command(Command::Jog(Jog::B)).trace;
    assert_eq!((refused.mode, refused.refusal), (Mode::Hold, no_room));
}

/// A stop or a hold takes the velocity away in equal steps; nothing goes on behind it.
fn a_stop_ends_a_jog<S: Scalar>() {
    for command in [Command::Stop, Command::Hold] {
        let mut driver = holding::<S>(&flying(0.01));
        driver.command(Command::Jog(Jog::Z));
        for _ in 0..200 {
            driver.step();
        }
        let before = driver.step().trace.sent_velocity[2];
        assert!(before > 0.0);
        let mut last = driver.command(command).trace;
        assert_eq!(last.mode, Mode::Hold);
        for _ in 1..25 {
            assert!(last.sent_velocity[2] > 0.0 && last.sent_velocity[2] < before);
            let again = driver.command(Command::Jog(Jog::Z)).trace;
            assert_eq!(again.refusal, Some(Refusal::StillMoving));
            last = again;
        }
        assert_eq!(last.sent_velocity, [0.0; 6]);
        for _ in 0..100 {
            let record = driver.step();
            assert_eq!(
                (record.trace.mode, record.output.correction),
                (Mode::Hold, [0; 6])
            );
        }
        // The next one begins at its beginning.
        for _ in 0..50 {
            let record = driver.command(Command::Jog(Jog::Z));
            assert_eq!(record.output.correction, [0; 6]);
        }
    }
}

type Spoil = fn(&mut Inputs);

/// What faults a closed loop faults a jog, and the robot stands still at once.
fn what_faults_a_closed_loop_faults_a_jog<S: Scalar>() {
    let cases: [(Spoil, FaultCode); 9] = [
        (|i| i.sensor.wrench[1] = 3001.0, FaultCode::Overload),
        (|i| i.sensor.wrench[4] = -501.0, FaultCode::Overload),
        (|i| i.sensor.saturated = true, FaultCode::SensorSaturated),
        (|i| i.sensor.status = 4, FaultCode::SensorStatus),
        (|i| i.sensor.wrench[0] = f64::NAN, FaultCode::Numeric),
        (
            |i| i.robot.sequence = Sequence::Gap(11),
            FaultCode::TelegramsLost,
        ),
        (
            |i| i.robot.sequence = Sequence::NewRun,
            FaultCode::RobotRestarted,
        ),
        (|i| i.robot.late_answers = 26, FaultCode::LateAnswers),
        (|i| i.robot.pose = None, FaultCode::PoseLost),
    ];
    for (spoil, code) in cases {
        let mut driver = holding::<S>(&flying(0.01));
        driver.command(Command::Jog(Jog::MinusY));
        for _ in 0..100 {
            driver.step();
        }
        let record = driver.step_with(spoil);
        let fault = record.trace.fault.map(|fault| fault.code);
        assert_eq!((record.trace.mode, fault), (Mode::Fault, Some(code)));
        assert_eq!(record.output.stop, code == FaultCode::Overload);
        for _ in 0..20 {
            assert_eq!(driver.step().output.correction, [0; 6], "{code:?}");
        }
        // Leaving the fault does not take the jog up again.
        assert_eq!(driver.command(Command::Reset).trace.mode, Mode::Hold);
        assert_eq!(driver.step().output.correction, [0; 6], "{code:?}");
    }
}

/// A robot that clamps takes the velocity away, and is a fault when it goes on.
fn a_clamping_robot_ends_a_jog<S: Scalar>() {
    let mut driver = holding::<S>(&flying(0.01));
    driver.command(Command::Jog(Jog::X));
    for _ in 0..100 {
        driver.step();
    }
    driver.inputs.robot.status = 0b1000;
    let modes: Vec<Mode> = (0..26).map(|_| driver.step().trace.mode).collect();
    assert_eq!(modes[24..], [Mode::Jogging, Mode::Fault]);
    let fault = driver.cycle.fault().map(|fault| fault.code);
    assert_eq!(fault, Some(FaultCode::SustainedClamp));
}

/// A silent sensor brings the robot to rest before it is a fault.
fn a_silent_sensor_ends_a_jog<S: Scalar>() {
    let mut driver = holding::<S>(&flying(0.01));
    driver.command(Command::Jog(Jog::X));
    for _ in 0..100 {
        driver.step();
    }
    let records: Vec<CycleRecord> = (0..6).map(|_| driver.step_stale(|_| {})).collect();
    let left = records[4].trace.sent_velocity[0];
    assert!(left.abs() < 1e-9, "{left}");
    let fault = records[5].trace.fault.map(|fault| fault.code);
    assert_eq!(fault, Some(FaultCode::SensorStale));
}

/// Wherever in a jog the sensor stops, nothing gets faster on old data, though the jog is about to jump to another velocity.
fn no_jog_gets_faster_on_old_data<S: Scalar>() {
    for fresh in 1..150 {
        let mut driver = holding::<S>(&flying(0.01));
        driver.command(Command::Jog(Jog::X));
        for _ in 0..fresh {
            driver.step();
        }
        let records = (0..5).map(|_| driver.step_stale(|_| {}));
        let speeds: Vec<f64> = records
            .map(|record| record.trace.sent_velocity[0].abs())
            .collect();
        // A reading lives for three cycles.
        assert!(
            speeds[1..].is_sorted_by(|a, b| a >= b),
            "after {fresh} cycles: {speeds:?}"
        );
        assert!(speeds[4] < 1e-9, "after {fresh} cycles: {speeds:?}");
    }
}

in_three_scalars! {
    jog_out_and_back: a_jog_goes_out_and_comes_back,
    room: a_jog_without_room_is_refused,
    stop: a_stop_ends_a_jog,
    faults: what_faults_a_closed_loop_faults_a_jog,
    clamping_robot: a_clamping_robot_ends_a_jog,
    silent_sensor: a_silent_sensor_ends_a_jog,
    old_data: no_jog_gets_faster_on_old_data,
}

/// The settings say how far and how fast; beside the limits, what does not fit is refused by name.
#[test]
fn what_the_limits_do_not_allow_is_refused_with_its_range() {
    type Change = fn(&mut Settings);
    let cases: [(Change, &str); 8] = [
        (
            |s| s.limits.box_m[2] = 0.04,
            "`jog.reach_m` is 0.05; allowed is 0.016 to 0.04",
        ),
        (
            |s| s.jog.reach_m = 0.3,
            "`jog.reach_m` is 0.3; allowed is 0.016 to 0.25",
        ),
        (
            |s| s.jog.reach_m = 0.01,
            "`jog.reach_m` is 0.01; allowed is 0.016 to 0.25",
        ),
        (
            |s| s.limits.speed_m_s = 0.016,
            "`jog.speed_m_s` is 0.02; allowed is 0.0000001 to 0.01",
        ),
        (
            |s| s.limits.acceleration_m_s2 = 4.5,
            "`jog.speed_m_s` is 0.02; allowed is",
        ),
        (
            |s| s.limits.step_m = 5e-5,
            "`jog.speed_m_s` is 0.02; allowed is",
        ),
        (
            |s| s.limits.box_rad = 0.07,
            "`jog.reach_rad` is 0.075; allowed is",
        ),
        (
            |s| s.jog.speed_rad_s = 0.4,
            "`jog.speed_rad_s` is 0.4; allowed is",
        ),
    ];
    for (change, says) in cases {
        let mut settings = Settings::default();
        change(&mut settings);
        let error = RobotCycle::<f64>::new(&settings).unwrap_err().to_string();
        assert!(
            error.starts_with(says),
            "expected `{says}`, found `{error}`"
        );
    }
}
