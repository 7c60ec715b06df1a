//! The sensor's start-up and its first samples.

use crate::bench::{Bench, FIRST_TELEGRAM_US, flying};
use crate::sensor::{Behaviour, calibration, opcode};
use softdock_app::settings::SensorKind;
use softdock_control::modes::Mode;
use softdock_link::can::ati::{AtiDevice, ForceUnit, TorqueUnit};
use softdock_link::sensor::{SensorFault, SensorState};

const GAUGES: [i16; 6] = [100, -200, 300, -400, 500, -600];
const WRENCH: [f64; 6] = [1.0, -2.0, 3.0, -0.4, 0.5, -0.6];

#[test]
fn matrix_counts_and_units_are_asked_for_and_used() {
    let units = [
        (ForceUnit::Newton, TorqueUnit::NewtonMetre),
        (ForceUnit::PoundForce, TorqueUnit::PoundForceInch),
        (ForceUnit::Kilonewton, TorqueUnit::KilonewtonMetre),
    ];
    for (force, torque) in units {
        let mut bench = Bench::switched_on(&flying(), false);
        {
            let sensor = &mut bench.world().sensor;
            sensor.device = AtiDevice::new(0x20, &calibration(), force, torque).unwrap();
            sensor.gauges = GAUGES;
            sensor.flickers = false;
        }
        bench.run_to(FIRST_TELEGRAM_US);
        let world = bench.world();
        let asked: Vec<u16> = world.requests.iter().map(|(_, f)| opcode(f)).collect();
        assert_eq!(asked[..11], [0xF, 5, 2, 2, 2, 2, 2, 2, 7, 8, 0]);
        let rows = world.requests.iter().filter(|(_, f)| opcode(f) == 2);
        assert!(rows.map(|(_, f)| f.data()[0]).eq(0..6));
        let sample = bench.shared.sample();
        assert_eq!((sample.counts, sample.status), (GAUGES.map(i32::from), 0));
        assert!(sample.counter > 0 && !sample.saturated);
        for (received, expected) in sample.wrench.iter().zip(WRENCH) {
            // Counts per unit are integers in the protocol.
            assert!((received / expected - 1.0).abs() < 5e-3, "{sample:?}");
        }
    }
}

#[test]
fn the_state_is_shown_while_the_sensor_starts() {
    let mut bench = Bench::switched_on(&flying(), false);
    assert_eq!(bench.status().sensor, None);
    bench.run_to(10);
    assert_eq!(bench.status().sensor, Some(SensorState::Starting));
    assert_eq!(bench.shared.sample().counter, 0);
    bench.run_to(FIRST_TELEGRAM_US);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
}

#[test]
fn a_sensor_that_comes_late_is_found() {
    let mut bench = Bench::switched_on(&flying(), false);
    bench.world().sensor.behaviour = Behaviour::Silent;
    bench.run_to(1_500_000);
    let no_answer = SensorState::Failed(SensorFault::NoAnswer);
    assert_eq!(bench.status().sensor, Some(no_answer));
    bench.world().sensor.behaviour = Behaviour::Healthy;
    bench.run_to(4_000_000);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
    assert!(bench.shared.sample().counter > 0);
}

#[test]
fn a_streaming_sensor_serves_the_loop() {
    let mut settings = flying();
    settings.can.sensor = SensorKind::Sri;
    let mut bench = Bench::switched_on(&settings, true);
    bench.world().sensor.streamed = [1.0, -2.0, 3.0, -0.5, 0.25, -0.125];
    bench.run_to(FIRST_TELEGRAM_US - 1);
    assert_eq!(bench.world().requests.len(), 1, "one start command");
    bench.cycles(50);
    assert_eq!(bench.status().mode, Mode::Running);
    let record = bench.last_record();
    let wrench = [1.0, -2.0, 3.0, -0.5, 0.25, -0.125];
    for (received, sent) in record.inputs.sensor.wrench.into_iter().zip(wrench) {
        assert!((received - sent).abs() < 1e-6, "{received}, not {sent}");
    }
    assert_eq!(record.trace.sensor_age, 0);
    assert_eq!(bench.status().sensor_counters, Default::default());
}
