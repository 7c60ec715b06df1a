//! A driver and a simulated sensor on a bus without delay.

use softdock_link::can::ati::{
    AtiCalibration, AtiConfig, AtiDevice, AtiDriver, ForceUnit, TorqueUnit,
};
use softdock_link::can::{Frame, Id};
use softdock_link::sensor::{SensorReading, SensorState};

pub(crate) const GAUGES: [i16; 6] = [1, -2, 3, -4, 5, -6];

/// Answers come this long after their request.
const ANSWER_TIME_US: u64 = 300;

/// A calibration that is exact in single precision.
pub(crate) fn calibration() -> AtiCalibration {
    let mut matrix = [[0.0; 6]; 6];
    for (row, factors) in matrix.iter_mut().enumerate() {
        for (column, factor) in factors.iter_mut().enumerate() {
            *factor = 0.25 * (row as f64 + 1.0) - 0.5 * column as f64;
        }
    }
    AtiCalibration {
        matrix,
        counts_per_force: 1_000.0,
        counts_per_torque: 50_000.0,
    }
}

pub(crate) fn device_in(force: ForceUnit, torque: TorqueUnit) -> AtiDevice {
    AtiDevice::new(0x20, &calibration(), force, torque).unwrap()
}

pub(crate) fn device() -> AtiDevice {
    device_in(ForceUnit::Newton, TorqueUnit::NewtonMetre)
}

pub(crate) fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(Id::Standard(id), data).unwrap()
}

/// Lower four bits of the identifier.
pub(crate) fn opcode(frame: &Frame) -> u16 {
    match frame.id() {
        Id::Standard(id) => id & 0xF,
        Id::Extended(_) => panic!("extended frame"),
    }
}

pub(crate) struct Bench {
    pub(crate) driver: AtiDriver,
    pub(crate) device: AtiDevice,
    pub(crate) now_us: u64,
    /// Changes or drops a frame of the sensor.
    pub(crate) tamper: fn(Frame) -> Option<Frame>,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self {
            driver: AtiDriver::new(AtiConfig::default()),
            device: device(),
            now_us: 1_000_000,
            tamper: Some,
        }
    }

    /// A bench with a running driver.
    pub(crate) fn running() -> Self {
        let mut bench = Self::new();
        assert_eq!(bench.run(10), SensorState::Running);
        bench
    }

    /// Advances the time to the next request and returns it.
    pub(crate) fn request(&mut self) -> Option<Frame> {
        self.now_us = self.now_us.max(self.driver.next_deadline_us());
        self.driver.poll_transmit(self.now_us)
    }

    /// Sends the next request and its answer; returns the reading.
    pub(crate) fn step(&mut self, gauges: [i16; 6], status: u16) -> Option<SensorReading> {
        let request = self.request()?;
        let answer = self.device.answer(&request, gauges, status);
        answer
            .into_iter()
            .filter_map(self.tamper)
            .filter_map(|frame| self.driver.receive(&frame, self.now_us + ANSWER_TIME_US))
            .last()
    }

    /// Runs several steps; returns the state after them.
    pub(crate) fn run(&mut self, steps: usize) -> SensorState {
        for _ in 0..steps {
            self.step(GAUGES, 0);
        }
        self.driver.state()
    }
}
