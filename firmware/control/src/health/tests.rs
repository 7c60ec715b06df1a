use super::*;

/// A frozen sensor with a sample in every third cycle: its reading is not believed for longer.
#[test]
fn a_slow_sensor_may_not_repeat_for_longer_than_a_fast_one() {
    let mut health = Health::new(&Settings::default());
    let mut inputs = Inputs::default();
    inputs.sensor.counts = [7; 6];
    let (mut believed, mut fault) = (0, None);
    for cycle in 0..7 {
        assert_eq!(fault, None);
        inputs.sensor.counter = 1 + cycle / 3;
        fault = health.check(&inputs, Mode::Armed, true);
        believed += u32::from(!health.stale());
    }
    assert_eq!(believed, 3);
    assert_eq!(fault, Some(Fault::new(FaultCode::SensorFrozen, 4.0, 6.0)));
}

/// A sensor that has failed on a busy network: its last sample ages with the telegrams that were lost since.
#[test]
fn a_sample_ages_with_lost_telegrams() {
    let mut health = Health::new(&Settings::default());
    assert_eq!(health.check(&well(0), Mode::Running, true), None);
    let mut inputs = well(0);
    inputs.robot.sequence = Sequence::Gap(2);
    assert_eq!(health.check(&inputs, Mode::Running, true), None);
    assert_eq!((health.sensor_age(), health.stale()), (1, true));
    let fault = Some(Fault::new(FaultCode::SensorStale, 5.0, 6.0));
    assert_eq!(health.check(&inputs, Mode::Running, true), fault);
}

/// The sample that the telegram after a gap triggers is as fresh as any other.
#[test]
fn a_new_sample_behind_lost_telegrams_is_new() {
    let mut health = Health::new(&Settings::default());
    health.check(&well(0), Mode::Running, true);
    let mut inputs = well(1);
    inputs.robot.sequence = Sequence::Gap(9);
    assert_eq!(health.check(&inputs, Mode::Running, true), None);
    assert_eq!((health.sensor_age(), health.stale()), (0, false));
}

/// 3000 N between 500 kg and 500 kg: 12 m/s², 2 mm in 18 ms.
#[test]
fn the_worst_load_bends_the_motion_by_one_step_at_most() {
    let mut settings = Settings::default();
    assert_eq!(unseen_cycles(&settings), 4);
    settings.limits.force_n = 30.0;
    // 500 N·m on 100 and 100 kg·m²: 10 rad/s², 5 mrad in 32 ms.
    assert_eq!(unseen_cycles(&settings), 7);
    settings.limits.torque_n_m = 1.0;
    assert_eq!(unseen_cycles(&settings), 45);
    settings.body_k.mass_kg = 0.1;
    assert_eq!(unseen_cycles(&settings), 1);
    (settings.body_k.fixed, settings.body_q.fixed) = (true, true);
    assert!(unseen_cycles(&settings) > 1000);
}

/// A pose is refused beyond a kilometre, if its quaternion has not unit length, and if it is not finite.
#[test]
fn a_pose_is_believed_up_to_its_declared_range() {
    let at = |place: usize, value: f64| {
        let mut pose = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        pose[place] = value;
        assert_eq!(plausible(&pose), implausible(&pose).is_none());
        implausible(&pose)
    };
    for place in 0..3 {
        for far in [1000.0, -1000.0] {
            assert_eq!(at(place, far), None);
            assert_eq!(at(place, 1.001 * far), Some((1000.0, 1.001 * far)));
        }
    }
    assert_eq!(at(3, 1.0), None);
    assert_eq!(at(3, 0.0), Some((1e-6, -1.0)));
    assert_eq!(at(5, 1.0), Some((1e-6, 1.0)));
    assert_eq!(at(6, 1e-4), None);
    for place in 0..7 {
        for value in [f64::NAN, f64::INFINITY] {
            assert!(at(place, value).is_some());
        }
    }
}

/// A cycle in which all is well; its number distinguishes its sample from others.
fn well(cycle: u32) -> Inputs {
    let mut inputs = Inputs::default();
    inputs.robot.sequence = Sequence::Next;
    inputs.robot.pose = Some([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    inputs.sensor.counter = cycle + 1;
    inputs.sensor.counts[0] = cycle as i32 + 1;
    inputs
}

/// The fault of a running cycle after one that was well; and whether its sample is good and the data allow arming.
fn running(spoil: impl Fn(&mut Inputs)) -> (Option<Fault>, bool, Readiness) {
    let mut health = Health::new(&Settings::default());
    assert_eq!(health.check(&well(0), Mode::Running, true), None);
    assert_eq!(
        (health.sensor_age(), health.good_sample(&well(0))),
        (0, true)
    );
    let mut inputs = well(1);
    spoil(&mut inputs);
    let fault = health.check(&inputs, Mode::Running, true);
    (fault, health.good_sample(&inputs), health.ready(&inputs))
}

#[test]
fn a_cycle_in_which_all_is_well_is_fit_for_everything() {
    assert_eq!(running(|_| {}), (None, true, Ok(())));
}

/// Each is a fault at once, with the numbers that caused it; none is a sample to take a zero from.
#[test]
fn what_the_sensor_cannot_have_measured_is_a_fault_at_once() {
    let unhealthy = |code, expected, received| {
        let fault = Fault::new(code, expected, received);
        (Some(fault), false, Err(Refusal::SensorUnhealthy))
    };
    assert_eq!(
        running(|inputs| inputs.sensor.status = 6),
        unhealthy(FaultCode::SensorStatus, 0.0, 6.0)
    );
    assert_eq!(
        running(|inputs| inputs.sensor.saturated = true),
        unhealthy(FaultCode::SensorSaturated, 0.0, 1.0)
    );
    for place in 0..6 {
        assert_eq!(
            running(|inputs| inputs.sensor.wrench[place] = f64::NAN),
            unhealthy(FaultCode::Numeric, 0.0, 0.0)
        );
    }
    assert_eq!(
        running(|inputs| inputs.robot.pose = Some([2e3, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])),
        unhealthy(FaultCode::Numeric, 1e3, 2e3)
    );
    let no_number = [0.0, f64::NAN, 0.0, 1.0, 0.0, 0.0, 0.0];
    assert_eq!(
        running(|inputs| inputs.robot.pose = Some(no_number)),
        unhealthy(FaultCode::Numeric, 0.0, 0.0)
    );
}

#[test]
fn status_bits_that_are_to_be_ignored_are() {
    let mut settings = Settings::default();
    settings.sensor.ignored_status_bits = 0b110;
    for (status, fault) in [(0b110, None), (0b111, Some(1.0)), (0b1010, Some(8.0))] {
        let mut health = Health::new(&settings);
        let mut inputs = well(1);
        inputs.sensor.status = status;
        let fault = fault.map(|bits| Fault::new(FaultCode::SensorStatus, 0.0, bits));
        assert_eq!(health.check(&inputs, Mode::Running, true), fault);
    }
}

/// The same events are allowed while the robot is not driven.
#[test]
fn what_the_robot_may_not_do_it_may_not_do_while_it_is_driven() {
    let robot = |spoil: fn(&mut Inputs)| {
        let mut idle = Health::new(&Settings::default());
        let mut inputs = well(0);
        spoil(&mut inputs);
        assert_eq!(idle.check(&inputs, Mode::Armed, true), None);
        let fault = running(spoil).0;
        fault.map(|fault| (fault.code, fault.expected, fault.received))
    };
    let restarted = |inputs: &mut Inputs| inputs.robot.sequence = Sequence::NewRun;
    assert_eq!(
        robot(restarted),
        Some((FaultCode::RobotRestarted, 0.0, 0.0))
    );
    assert_eq!(
        robot(|inputs| inputs.robot.sequence = Sequence::Gap(10)),
        None
    );
    assert_eq!(
        robot(|inputs| inputs.robot.sequence = Sequence::Gap(11)),
        Some((FaultCode::TelegramsLost, 10.0, 11.0))
    );
    assert_eq!(robot(|inputs| inputs.robot.late_answers = 25), None);
    assert_eq!(
        robot(|inputs| inputs.robot.late_answers = 26),
        Some((FaultCode::LateAnswers, 25.0, 26.0))
    );
    assert_eq!(
        robot(|inputs| inputs.robot.pose = None),
        Some((FaultCode::PoseLost, 1.0, 0.0))
    );
}

/// Late answers before the motion do not count.
#[test]
fn late_answers_count_from_the_last_cycle_at_rest() {
    let mut health = Health::new(&Settings::default());
    let late = |cycle, late_answers| {
        let mut inputs = well(cycle);
        inputs.robot.late_answers = late_answers;
        inputs
    };
    for (mode, late_answers, faulty) in [
        (Mode::Armed, 100, false),
        (Mode::Running, 110, false),
        (Mode::Running, 125, false),
        (Mode::Running, 126, true),
    ] {
        let fault = health.check(&late(late_answers, late_answers), mode, true);
        assert_eq!(fault.is_some(), faulty, "{late_answers}");
    }
    // A new run counts from its beginning.
    let mut restarted = late(127, 200);
    restarted.robot.sequence = Sequence::NewRun;
    assert!(health.check(&restarted, Mode::Running, true).is_some());
    assert_eq!(health.check(&late(128, 225), Mode::Running, true), None);
}

#[test]
fn nothing_is_a_fault_where_nothing_moves() {
    let mut health = Health::new(&Settings::default());
    let mut inputs = well(0);
    inputs.sensor.status = 1;
    assert_eq!(health.check(&inputs, Mode::Idle, false), None);
}

/// For each age: believed up to two cycles, a fault at six.
#[test]
fn a_sample_grows_old() {
    let mut health = Health::new(&Settings::default());
    let inputs = well(0);
    for age in 0..=6 {
        let fault = health.check(&inputs, Mode::Running, true);
        let expected = Fault::new(FaultCode::SensorStale, 5.0, 6.0);
        assert_eq!(fault, (age == 6).then_some(expected));
        assert_eq!(health.sensor_age(), age);
        assert_eq!(health.stale(), age > 2, "{age}");
        assert_eq!(health.good_sample(&inputs), age == 0);
        let stale = Err(Refusal::SensorStale);
        assert_eq!(health.ready(&inputs), if age > 2 { stale } else { Ok(()) });
    }
}

/// New samples with the same six words are as old as the first of them; one more than allowed is a fault.
#[test]
fn a_reading_that_repeats_grows_old() {
    let mut health = Health::new(&Settings::default());
    for repeated in 0..=5 {
        let mut inputs = well(repeated);
        inputs.sensor.counts[0] = 7;
        let fault = health.check(&inputs, Mode::Running, true);
        let expected = Fault::new(FaultCode::SensorFrozen, 4.0, 5.0);
        assert_eq!(fault, (repeated == 5).then_some(expected), "{repeated}");
        assert_eq!(health.stale(), repeated > 2, "{repeated}");
    }
    // One count is a new reading.
    assert_eq!(health.check(&well(9), Mode::Running, true), None);
    assert!(!health.stale());
}

/// The settings may say that the sensor has no noise.
#[test]
fn repeated_readings_may_be_allowed() {
    let mut settings = Settings::default();
    settings.sensor.frozen_after_cycles = 0;
    let mut health = Health::new(&settings);
    for cycle in 0..100 {
        let mut inputs = well(cycle);
        inputs.sensor.counts[0] = 7;
        assert_eq!(health.check(&inputs, Mode::Running, true), None);
        assert!(!health.stale());
    }
}

#[test]
fn nothing_begins_without_samples_or_where_angles_cannot_be_told_apart() {
    let health = Health::new(&Settings::default());
    let ready = |spoil: fn(&mut Inputs)| {
        let mut inputs = well(0);
        spoil(&mut inputs);
        health.ready(&inputs)
    };
    assert_eq!(ready(|_| {}), Ok(()));
    assert_eq!(ready(|i| i.sensor.counter = 0), Err(Refusal::SensorStale));
    assert_eq!(ready(|i| i.robot.pose = None), Err(Refusal::NoPose));
    let locked = ready(|i| i.robot.gimbal_locked = true);
    assert_eq!(locked, Err(Refusal::OrientationSingular));
}
