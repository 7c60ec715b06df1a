//! A sensor that misbehaves while the loop is closed.

use crate::bench::{Bench, CRUISE_COUNTS, counts, flying};
use crate::sensor::Behaviour;
use softdock_app::settings::SensorKind;
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, FaultCode, Mode, Refusal};
use softdock_link::sensor::SensorState;

/// Lets one exchange fail in this way, after which the sensor is healthy again.
fn fails_once(behaviour: Behaviour) -> Bench {
    let mut bench = Bench::cruising(&flying());
    bench.world().sensor.behaviour = behaviour;
    bench.cycle();
    bench.world().sensor.behaviour = Behaviour::Healthy;
    bench.world().sensor.gauges[0] = 500;
    bench.cycles(20);
    assert_eq!(bench.status().mode, Mode::Running, "{behaviour:?}");
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
    let sample = bench.last_record().inputs.sensor;
    assert_eq!((sample.counts[0], sample.wrench[0]), (500, 5.0));
    bench
}

#[test]
fn a_lost_answer_resynchronises() {
    let counters = fails_once(Behaviour::Silent).status().sensor_counters;
    assert_eq!((counters.timeouts, counters.retries), (1, 1));
    assert_eq!((counters.unpaired, counters.late), (0, 0));
}

#[test]
fn halves_of_readings_are_not_paired_across_requests() {
    let counters = fails_once(Behaviour::LosesSecondHalf)
        .status()
        .sensor_counters;
    assert_eq!((counters.timeouts, counters.unpaired), (1, 1));
    let counters = fails_once(Behaviour::LosesFirstHalf)
        .status()
        .sensor_counters;
    assert_eq!((counters.timeouts, counters.unpaired), (1, 1));
}

#[test]
fn a_silent_sensor_ramps_down_and_faults() {
    let settings = flying();
    let sensor = &settings.control.sensor;
    let (stale, fault) = (sensor.stale_after_cycles, sensor.fault_after_cycles);
    let mut bench = Bench::cruising(&settings);
    bench.world().sensor.behaviour = Behaviour::Silent;
    let mut last = CRUISE_COUNTS + 1;
    for age in 1..=fault {
        let sent = counts(&bench.cycle())[0];
        let trace = bench.last_record().trace;
        assert_eq!((trace.sensor_age, trace.mode), (age, Mode::Running));
        assert_eq!(trace.limits.has(LimitFlags::SENSOR_STALE), age > stale);
        if age > stale {
            assert!(sent < last, "age {age}: {sent} after {last}");
        }
        last = sent;
    }
    assert!(last.abs() < CRUISE_COUNTS / 10);
    assert_eq!(counts(&bench.cycle()), [0; 6]);
    bench.assert_fault(FaultCode::SensorStale, fault.into(), f64::from(fault + 1));
    // The fault cannot be reset without a sensor.
    let refused = bench.command(Command::Reset);
    assert_eq!(refused.trace.refusal, Some(Refusal::SensorStale));
}

#[test]
fn a_status_bit_faults_at_once_and_is_kept() {
    // Recorded from a real sensor: bit 14 without the summary bit 15.
    for status in [0x4000, 0x0001, 0x8000] {
        let mut bench = Bench::cruising(&flying());
        bench.world().sensor.status = status;
        assert_eq!(counts(&bench.cycle()), [0; 6]);
        bench.assert_fault(FaultCode::SensorStatus, 0.0, f64::from(status));
        assert_eq!(bench.last_record().inputs.sensor.status, u32::from(status));
        bench.world().sensor.status = 0;
        bench.cycles(10);
        assert_eq!(bench.fault(), Some(FaultCode::SensorStatus), "latched");
    }
    let mut settings = flying();
    settings.control.sensor.ignored_status_bits = 0x4000;
    let mut bench = Bench::cruising(&settings);
    bench.world().sensor.status = 0x4000;
    bench.cycle();
    assert_eq!(bench.status().mode, Mode::Running);
}

#[test]
fn a_saturated_gauge_faults() {
    for (gauge, saturated) in [(31_999, false), (32_000, true), (i16::MIN, true)] {
        let mut settings = flying();
        settings.control.start.max_force_n = 1e4;
        let mut bench = Bench::cruising(&settings);
        bench.world().sensor.gauges[2] = gauge;
        bench.cycle();
        assert_eq!(bench.fault().is_some(), saturated, "{gauge}");
        if saturated {
            assert_eq!(bench.fault(), Some(FaultCode::SensorSaturated));
        }
    }
}

/// With default settings, in contact: the model is held from the third equal reading on, and the sixth latches a fault.
#[test]
fn frozen_words_fault() {
    let mut bench = Bench::cruising(&flying());
    bench.world().sensor.gauges[0] = 500;
    bench.cycle();
    bench.world().sensor.flickers = false;
    bench.cycles(3);
    assert_eq!(bench.status().mode, Mode::Running);
    let held = bench.last_record().trace;
    assert!(held.limits.has(LimitFlags::SENSOR_STALE));
    bench.cycles(3);
    assert_eq!(bench.fault(), Some(FaultCode::SensorFrozen));
    assert_eq!(bench.last_record().trace.body_k, held.body_k);
    assert_eq!(bench.last_record().trace.sent_velocity, [0.0; 6]);
}

#[test]
fn a_stream_that_ends_faults() {
    let mut settings = flying();
    settings.can.sensor = SensorKind::Sri;
    let mut bench = Bench::cruising(&settings);
    bench.world().sensor.behaviour = Behaviour::Silent;
    // The simulated stream lasts 2 s.
    while bench.world().now_us < 2_000_000 {
        bench.cycle();
    }
    bench.cycles(10);
    bench.assert_fault(FaultCode::SensorStale, 5.0, 6.0);
    bench.cycles(30);
    assert_eq!(
        bench.status().sensor,
        Some(SensorState::Resynchronising),
        "asked to start again"
    );
    bench.world().sensor.behaviour = Behaviour::Healthy;
    bench.cycles(50);
    assert_eq!(bench.command(Command::Reset).trace.mode, Mode::Hold);
}

#[test]
fn a_saturated_stream_faults() {
    let mut settings = flying();
    settings.can.sensor = SensorKind::Sri;
    settings.can.saturation_force_n = 10.0;
    let mut bench = Bench::switched_on(&settings, true);
    bench.world().sensor.streamed = [0.0, 0.0, -10.0, 0.0, 0.0, 0.0];
    bench.cycles(20);
    // Not even arming is possible.
    let refused = Some((Command::Arm, Refusal::SensorUnhealthy));
    assert_eq!(bench.status().refusal, refused);
    assert_eq!(bench.status().mode, Mode::Hold);
}
