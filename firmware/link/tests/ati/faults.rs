//! Status bits, saturation, restart, and a sensor whose calibration changes while the driver reads it.

use softdock_link::can::ati::{AtiConfig, AtiDriver, ForceUnit, TorqueUnit};
use softdock_link::sensor::{SensorFault, SensorState};

use crate::bench::{Bench, GAUGES, calibration, device_in, frame, opcode};

#[test]
fn every_status_bit_is_a_fault() {
    let mut bench = Bench::running();
    for bit in 0..16 {
        let status = 1 << bit;
        let reading = bench.step(GAUGES, status).unwrap();
        assert_eq!(reading.status, u32::from(status));
        assert!(!reading.saturated);
    }
    let reading = bench.step(GAUGES, 0).unwrap();
    assert_eq!((reading.status, reading.saturated), (0, false));
}

#[test]
fn one_saturated_gauge_invalidates_all_axes() {
    let mut bench = Bench::running();
    let limit = AtiConfig::default().saturation_counts;
    for gauge in 0..6 {
        for (counts, saturated) in [
            (limit - 1, false),
            (limit, true),
            (i16::MAX, true),
            (1 - limit, false),
            (-limit, true),
            (i16::MIN, true),
        ] {
            let mut gauges = GAUGES;
            gauges[gauge] = counts;
            let reading = bench.step(gauges, 0).unwrap();
            assert_eq!(reading.saturated, saturated, "{gauge} {counts}");
        }
    }
}

#[test]
fn reads_the_recorded_sample() {
    let mut bench = Bench::running();
    bench.request();
    let even = frame(0x200, &[0x40, 0x00, 0x00, 0x12, 0xFE, 0x3A, 0xE6, 0xA8]);
    let odd = frame(0x201, &[0x04, 0xFA, 0xFA, 0x93, 0x01, 0x43]);
    assert_eq!(bench.driver.receive(&even, bench.now_us), None);
    let reading = bench.driver.receive(&odd, bench.now_us).unwrap();
    let gauges = [18, 1274, -454, -1389, -6488, 323];
    assert_eq!(reading.counts, gauges.map(i32::from));
    assert_eq!(reading.status, 0x4000);
    assert_eq!(reading.wrench, calibration().wrench(&gauges));
}

#[test]
fn a_sensor_that_was_exchanged_is_refused() {
    let changed = SensorState::Failed(SensorFault::CalibrationChanged);
    // Other counts per unit: detected by the first check.
    let mut bench = Bench::running();
    bench.device = device_in(ForceUnit::Kilonewton, TorqueUnit::NewtonMetre);
    bench.request();
    assert_eq!(bench.run(1), changed);
    assert_eq!(bench.driver.calibration(), None);

    // The same counts of another unit: detected by the second check.
    let mut bench = Bench::running();
    bench.tamper = |answer| match opcode(&answer) {
        0x8 => Some(frame(0x208, &[4, 3])),
        _ => Some(answer),
    };
    bench.request();
    assert_eq!(bench.run(1), SensorState::Running);
    bench.request();
    assert_eq!(bench.run(1), changed);
}

#[test]
fn restart_resets_the_sensor_and_reads_the_calibration_anew() {
    let mut bench = Bench::running();
    bench.request();
    bench.driver.restart();
    assert_eq!(bench.driver.state(), SensorState::Starting);
    assert_eq!(bench.request(), Some(frame(0x20C, &[])));
    let reset_us = bench.now_us;
    let fence = bench.request().unwrap();
    assert!(matches!(opcode(&fence), 0x7 | 0x8));
    assert!(bench.now_us >= reset_us + 1_000_000, "time to start");
    for answer in bench.device.answer(&fence, GAUGES, 0) {
        bench.driver.receive(&answer, bench.now_us);
    }
    assert_eq!(bench.run(10), SensorState::Running);
    assert_eq!(bench.step(GAUGES, 0).unwrap().counter, 1);
}

#[test]
fn frames_of_others_are_counted_and_change_nothing() {
    let mut bench = Bench::running();
    bench.request();
    for other in [
        frame(0x210, &[0; 8]),
        frame(0x1F1, &[0; 6]),
        frame(0x201, &[0; 8]),
        frame(0x200, &[]),
    ] {
        assert_eq!(bench.driver.receive(&other, bench.now_us), None);
    }
    assert_eq!(bench.driver.counters().unknown, 4);
    assert_eq!(bench.driver.counters().late, 0);
}

#[test]
fn extreme_settings_do_not_break_the_driver() {
    let mut driver = AtiDriver::new(AtiConfig {
        base_id: 0x20,
        poll_period_us: u64::MAX,
        answer_timeout_us: 0,
        saturation_counts: i16::MIN,
    });
    for now_us in [0, 1, u64::MAX - 1, u64::MAX, 0, u64::MAX] {
        driver.poll_transmit(now_us);
        driver.receive(&frame(0x201, &[0; 6]), now_us);
    }
}
