//! Reading the calibration from the sensor.

use softdock_link::can::ati::{
    AtiCalibration, AtiConfig, AtiDevice, AtiDeviceError, AtiDriver, ForceUnit, TorqueUnit,
};
use softdock_link::sensor::{SensorFault, SensorState};

use crate::bench::{Bench, GAUGES, calibration, device_in, frame, opcode};

#[test]
fn reads_the_calibration_and_then_the_gauges() {
    let mut bench = Bench::new();
    assert_eq!(bench.driver.state(), SensorState::Starting);
    assert_eq!(bench.driver.calibration(), None);
    assert_eq!(bench.run(9), SensorState::Starting);
    assert_eq!(bench.run(1), SensorState::Running);
    assert_eq!(bench.driver.calibration(), Some(&calibration()));
    let identity = bench.driver.identity();
    assert_eq!(identity.serial_number, Some(*b"FT000001"));
    assert_eq!(identity.firmware_version, Some((1, 0, 1)));

    let first = bench.step(GAUGES, 0).unwrap();
    let first_at_us = bench.now_us;
    assert_eq!(first.counts, GAUGES.map(i32::from));
    assert_eq!(first.wrench, calibration().wrench(&GAUGES));
    assert!(!first.saturated);
    assert_eq!((first.counter, first.at_us), (1, first_at_us));
    let second = bench.step([7; 6], 0).unwrap();
    let period_us = AtiConfig::default().poll_period_us;
    assert_eq!((second.counter, second.at_us), (2, first_at_us + period_us));
    assert_eq!(bench.driver.counters(), Default::default());
}

#[test]
fn asks_in_the_recorded_form() {
    let mut driver = AtiDriver::new(AtiConfig {
        base_id: 0x7F,
        ..AtiConfig::default()
    });
    assert_eq!(driver.poll_transmit(0), Some(frame(0x7FF, &[])));
    assert_eq!(driver.poll_transmit(0), None);
}

#[test]
fn units_become_newtons_and_newton_metres() {
    let expected = calibration().wrench(&GAUGES);
    for (force, torque) in [
        (ForceUnit::PoundForce, TorqueUnit::PoundForceInch),
        (ForceUnit::KilogramForce, TorqueUnit::NewtonMillimetre),
        (ForceUnit::Kilonewton, TorqueUnit::KilonewtonMetre),
        (ForceUnit::KilopoundForce, TorqueUnit::PoundForceFoot),
        (ForceUnit::GramForce, TorqueUnit::KilogramForceCentimetre),
    ] {
        let mut bench = Bench::new();
        bench.device = device_in(force, torque);
        bench.run(10);
        let wrench = bench.step(GAUGES, 0).unwrap().wrench;
        for (wrench, expected) in wrench.iter().zip(expected) {
            // Counts per unit are integers: 1000 per N are only 10 per gf.
            assert!((wrench / expected - 1.0).abs() < 0.03, "{force:?} {wrench}");
        }
    }
}

#[test]
fn unknown_units_are_refused() {
    let mut bench = Bench::new();
    bench.tamper = |answer| match opcode(&answer) {
        0x8 => Some(frame(0x208, &[2, 7])),
        _ => Some(answer),
    };
    let fault = SensorFault::TorqueUnit { code: 7 };
    assert_eq!(bench.run(10), SensorState::Failed(fault));
    assert_eq!(bench.driver.next_deadline_us(), u64::MAX);
    assert_eq!(bench.driver.poll_transmit(u64::MAX), None);

    bench.tamper = |answer| match opcode(&answer) {
        0x8 => Some(frame(0x208, &[0, 3])),
        _ => Some(answer),
    };
    bench.now_us += 1;
    bench.driver.restart();
    let fault = SensorFault::ForceUnit { code: 0 };
    assert_eq!(bench.run(12), SensorState::Failed(fault));
}

#[test]
fn unusable_scale_and_matrix_are_refused() {
    let mut bench = Bench::new();
    bench.tamper = |answer| match opcode(&answer) {
        0x7 => Some(frame(0x207, &[0, 0, 0, 5, 0, 0, 0, 0])),
        _ => Some(answer),
    };
    let fault = SensorFault::CountsPerUnit {
        force: 5,
        torque: 0,
    };
    assert_eq!(bench.run(10), SensorState::Failed(fault));

    let mut bench = Bench::new();
    bench.tamper = |answer| match opcode(&answer) {
        0x4 => Some(frame(0x204, &[0x7F, 0xC0, 0, 0, 0, 0, 0, 0])),
        _ => Some(answer),
    };
    let fault = SensorFault::Matrix { row: 0 };
    assert_eq!(bench.run(10), SensorState::Failed(fault));
}

#[test]
fn a_base_of_more_than_seven_bits_is_refused() {
    let mut driver = AtiDriver::new(AtiConfig {
        base_id: 0x80,
        ..AtiConfig::default()
    });
    let state = SensorState::Failed(SensorFault::BaseId { received: 0x80 });
    assert_eq!(driver.state(), state);
    driver.restart();
    assert_eq!(driver.state(), state);
    assert_eq!(driver.poll_transmit(0), None);
}

#[test]
fn a_sensor_that_does_not_say_who_it_is_still_reads() {
    let mut bench = Bench::new();
    bench.tamper = |answer| (!matches!(opcode(&answer), 0x5 | 0xF)).then_some(answer);
    assert_eq!(bench.run(16), SensorState::Running);
    assert_eq!(bench.driver.identity(), Default::default());
    assert!(bench.step(GAUGES, 0).is_some());
}

#[test]
fn a_lost_answer_is_asked_for_again_though_readings_do_not_depend_on_it() {
    let mut bench = Bench::new();
    bench.request();
    // One check, and ten queries.
    assert_eq!(bench.run(11), SensorState::Running);
    let identity = bench.driver.identity();
    assert_eq!(identity.serial_number, Some(*b"FT000001"));
    assert_eq!(identity.firmware_version, Some((1, 0, 1)));
}

#[test]
fn a_silent_sensor_is_reported_and_found_when_it_wakes_up() {
    let mut bench = Bench::new();
    bench.tamper = |_| None;
    let mut requests = 0;
    while bench.driver.state() == SensorState::Starting {
        bench.request();
        requests += 1;
        assert!(requests < 100, "retries are not bounded");
    }
    assert_eq!(
        bench.driver.state(),
        SensorState::Failed(SensorFault::NoAnswer)
    );
    let (silent_us, again_us) = (bench.now_us, bench.driver.next_deadline_us());
    assert!(again_us >= silent_us + 1_000_000);
    assert_eq!(bench.driver.poll_transmit(again_us - 1), None);

    bench.tamper = Some;
    // One check, because the last answer may still come, and ten queries.
    assert_eq!(bench.run(11), SensorState::Running);
    assert_eq!(bench.driver.calibration(), Some(&calibration()));
}

#[test]
fn a_late_matrix_row_is_not_taken_for_the_next_one() {
    let mut bench = Bench::new();
    bench.run(2);
    let row_0 = bench.request().unwrap();
    let late = bench.device.answer(&row_0, GAUGES, 0);
    let fence = bench.request().unwrap();
    assert_eq!(opcode(&fence), 0x7, "a fence follows the timeout");
    for answer in late {
        assert_eq!(bench.driver.receive(&answer, bench.now_us), None);
    }
    assert_eq!(bench.driver.counters().late, 3);
    for answer in bench.device.answer(&fence, GAUGES, 0) {
        bench.driver.receive(&answer, bench.now_us);
    }
    assert_eq!(bench.run(8), SensorState::Running);
    assert_eq!(bench.driver.calibration(), Some(&calibration()));
}

#[test]
fn parts_of_two_answers_make_no_row() {
    let mut bench = Bench::new();
    bench.run(2);
    let row_0 = bench.request().unwrap();
    let first = bench.device.answer(&row_0, GAUGES, 0);
    bench.driver.receive(&first[0], bench.now_us);
    bench.driver.receive(&first[1], bench.now_us);
    bench.run(1);
    assert_eq!(bench.request(), Some(row_0));
    let answer = bench.driver.receive(&first[2], bench.now_us);
    assert_eq!(answer, None);
    assert!(
        bench.driver.poll_transmit(bench.now_us).is_none(),
        "the row must still be incomplete"
    );
}

#[test]
fn the_device_refuses_what_the_wire_cannot_hold() {
    let device = |base_id, calibration: AtiCalibration| {
        AtiDevice::new(
            base_id,
            &calibration,
            ForceUnit::Newton,
            TorqueUnit::NewtonMetre,
        )
        .map(|_| ())
    };
    let good = calibration();
    assert_eq!(device(0x7F, good), Ok(()));
    assert_eq!(
        device(0x80, good),
        Err(AtiDeviceError::BaseId { received: 0x80 })
    );
    for received in [0.0, -1.0, 0.4, 5e9, f64::INFINITY] {
        let bad = AtiCalibration {
            counts_per_torque: received,
            ..good
        };
        assert_eq!(
            device(0x20, bad),
            Err(AtiDeviceError::CountsPerUnit { received })
        );
    }
    let mut bad = good;
    bad.matrix[4][2] = 1e39;
    assert_eq!(device(0x20, bad), Err(AtiDeviceError::Matrix { row: 4 }));
}
