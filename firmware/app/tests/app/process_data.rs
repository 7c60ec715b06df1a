//! A sensor that is not on CAN: process data of an EtherCAT SubDevice, with counts and status of 32 bits. It uses the same
//! task, and the cycle sees no difference.

use crate::bench::{Bench, START_CYCLES, flying};
use crate::world::Task;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use softdock_app::board::{IoError, SensorBus};
use softdock_control::modes::{Command, FaultCode, Mode};
use softdock_link::sensor::{
    SensorCounters, SensorDriver, SensorFault, SensorReading, SensorState,
};
use std::cell::RefCell;
use std::rc::Rc;

/// Longest time between two exchanges, µs.
const PERIOD_US: u64 = 1000;
const COUNTS_PER_UNIT: f64 = 1e5;

/// One exchange, to the SubDevice and back.
#[derive(Clone, Copy, Debug)]
enum ProcessData {
    Outputs,
    Inputs(Inputs),
}

#[derive(Clone, Copy, Debug, Default)]
struct Inputs {
    counts: [i32; 6],
    status: u32,
    sample: u32,
}

/// The SubDevice and its cable.
#[derive(Default)]
struct SubDevice {
    inputs: Inputs,
    /// The inputs never change, as after a restart of the SubDevice.
    stands: bool,
    /// The SubDevice is not operational: the working counter is 0.
    off: bool,
}

struct Wire {
    device: Rc<RefCell<SubDevice>>,
    back: Signal<NoopRawMutex, Result<ProcessData, IoError>>,
}

impl SensorBus for Wire {
    type Frame = ProcessData;

    async fn send(&mut self, _outputs: &ProcessData) -> Result<(), IoError> {
        let device = &mut *self.device.borrow_mut();
        if !device.stands {
            device.inputs.sample += 1;
            device.inputs.counts[5] ^= 1;
        }
        self.back.signal(match device.off {
            true => Err(IoError::BusOff),
            false => Ok(ProcessData::Inputs(device.inputs)),
        });
        Ok(())
    }

    async fn receive(&mut self) -> Result<ProcessData, IoError> {
        self.back.wait().await
    }

    async fn recover(&mut self) -> Result<(), IoError> {
        self.device.borrow_mut().off = false;
        Ok(())
    }
}

struct Driver {
    next_us: u64,
    sent_us: u64,
    last: Option<u32>,
    readings: u32,
    restarts: Rc<RefCell<u32>>,
}

impl SensorDriver for Driver {
    type Frame = ProcessData;

    fn poll_transmit(&mut self, now_us: u64) -> Option<ProcessData> {
        (now_us >= self.next_us).then(|| {
            (self.sent_us, self.next_us) = (now_us, now_us + PERIOD_US);
            ProcessData::Outputs
        })
    }

    fn next_deadline_us(&self) -> u64 {
        self.next_us
    }

    fn receive(&mut self, frame: &ProcessData, _now_us: u64) -> Option<SensorReading> {
        let ProcessData::Inputs(inputs) = frame else {
            return None;
        };
        if self.last.replace(inputs.sample) == Some(inputs.sample) {
            return None;
        }
        self.readings += 1;
        Some(SensorReading {
            wrench: inputs
                .counts
                .map(|count| f64::from(count) / COUNTS_PER_UNIT),
            counts: inputs.counts,
            status: inputs.status,
            counter: self.readings,
            at_us: self.sent_us,
            saturated: false,
        })
    }

    fn expedite(&mut self, now_us: u64) {
        self.next_us = self.next_us.min(now_us);
    }

    fn state(&self) -> SensorState {
        match self.last {
            None => SensorState::Starting,
            Some(_) => SensorState::Running,
        }
    }

    fn counters(&self) -> SensorCounters {
        SensorCounters::default()
    }

    fn restart(&mut self) {
        *self.restarts.borrow_mut() += 1;
        self.last = None;
    }
}

/// A board with this sensor instead of the CAN sensor, moving at full speed.
fn cruising() -> (Bench, Rc<RefCell<SubDevice>>, Rc<RefCell<u32>>) {
    let mut bench = Bench::switched_on(&flying(), true);
    let device = Rc::<RefCell<SubDevice>>::default();
    let restarts = Rc::<RefCell<u32>>::default();
    let mut wire = Wire {
        device: device.clone(),
        back: Signal::new(),
    };
    let driver = Driver {
        next_us: 0,
        sent_us: 0,
        last: None,
        readings: 0,
        restarts: restarts.clone(),
    };
    let (shared, clock) = (bench.shared, bench.handle());
    bench.tasks[0] = Task::new(async move {
        softdock_app::sensor::run(shared, &mut wire, &clock, driver).await;
    });
    bench.cycles(START_CYCLES);
    assert_eq!(bench.status().mode, Mode::Running);
    (bench, device, restarts)
}

#[test]
fn each_telegram_gets_the_sample_that_it_asks_for() {
    let (mut bench, device, _) = cruising();
    device.borrow_mut().inputs.counts = [1_000_000, -70_000, 0, 0, 0, 0];
    bench.cycle();
    let sample = bench.last_record().inputs.sensor;
    assert_eq!((sample.counts[0], sample.counts[1]), (1_000_000, -70_000));
    assert_eq!(sample.wrench[0], 10.0);
    let asked = bench.status().sample.unwrap().at_us;
    assert_eq!(asked, bench.next_at_us - 1000, "the background exchange");
    bench.cycles(100);
    assert_eq!(bench.status().mode, Mode::Running);
    assert_eq!(bench.last_record().trace.sensor_age, 0);
}

#[test]
fn a_high_status_bit_faults() {
    let (mut bench, device, _) = cruising();
    device.borrow_mut().inputs.status = 1 << 31;
    bench.cycle();
    bench.assert_fault(FaultCode::SensorStatus, 0.0, f64::from(1_u32 << 31));
    assert_eq!(bench.status().sample.unwrap().status, 1 << 31);
}

#[test]
fn inputs_that_stand_are_no_samples_and_the_operator_starts_the_sensor_over() {
    let (mut bench, device, restarts) = cruising();
    device.borrow_mut().stands = true;
    bench.cycles(10);
    assert_eq!(bench.fault(), Some(FaultCode::SensorStale));
    bench.command(Command::Reset);
    bench.cycle();
    assert_eq!(*restarts.borrow(), 1);
    device.borrow_mut().stands = false;
    bench.cycles(3);
    assert_eq!(bench.command(Command::Reset).trace.mode, Mode::Hold);
}

#[test]
fn a_subdevice_that_left_operation_is_brought_back() {
    let (mut bench, device, _) = cruising();
    device.borrow_mut().off = true;
    bench.cycles(10);
    assert_eq!(bench.fault(), Some(FaultCode::SensorStale));
    let failed = SensorState::Failed(SensorFault::NoAnswer);
    assert_eq!(bench.status().sensor, Some(failed));
    bench.cycles(40);
    assert_eq!(bench.status().bus_offs, 1);
    assert_eq!(bench.status().sensor, Some(SensorState::Running));
}
