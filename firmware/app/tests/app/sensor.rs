//! The sensor on the bus.

use softdock_link::can::ati::{AtiCalibration, AtiDevice, ForceUnit, TorqueUnit};
use softdock_link::can::sri::{is_start_command, stream_frames};
use softdock_link::can::{Frame, Id};

/// Time from a request to the last frame of its answer, µs.
pub(crate) const EXCHANGE_US: u64 = 350;
/// Time from one reading of the streaming sensor to the next, µs.
const STREAM_PERIOD_US: u64 = 1_000;
/// Readings that the streaming sensor sends for one start command.
const STREAM_READINGS: u64 = 2_000;

/// Reaction of the sensor to a request for gauges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Behaviour {
    #[default]
    Healthy,
    /// Answers no request at all.
    Silent,
    /// The frame with the even gauges is lost.
    LosesFirstHalf,
    /// The frame with the odd gauges is lost.
    LosesSecondHalf,
}

#[derive(Clone, Debug)]
pub(crate) struct Sensor {
    pub(crate) device: AtiDevice,
    pub(crate) gauges: [i16; 6],
    pub(crate) status: u16,
    pub(crate) behaviour: Behaviour,
    pub(crate) exchange_us: u64,
    /// With each reading the last gauge changes by one count and the streamed Tz by its last bits, as on real sensors.
    pub(crate) flickers: bool,
    /// What the streaming sensor sends after a start command.
    pub(crate) streamed: [f32; 6],
}

/// 100 counts per N, 1000 per N·m, one gauge per axis.
pub(crate) fn calibration() -> AtiCalibration {
    let mut matrix = [[0.0; 6]; 6];
    for (row, factors) in matrix.iter_mut().enumerate() {
        factors[row] = 1.0;
    }
    AtiCalibration {
        matrix,
        counts_per_force: 100.0,
        counts_per_torque: 1000.0,
    }
}

impl Default for Sensor {
    fn default() -> Self {
        let (force, torque) = (ForceUnit::Newton, TorqueUnit::NewtonMetre);
        Self {
            device: AtiDevice::new(0x20, &calibration(), force, torque).unwrap(),
            gauges: [0; 6],
            status: 0,
            behaviour: Behaviour::Healthy,
            exchange_us: EXCHANGE_US,
            flickers: true,
            streamed: [0.0; 6],
        }
    }
}

impl Sensor {
    /// The frames that answer a request, each with its time after the request, µs.
    pub(crate) fn answer(&mut self, request: &Frame) -> Vec<(u64, Frame)> {
        if self.behaviour == Behaviour::Silent {
            return Vec::new();
        }
        if is_start_command(request) {
            return self.stream();
        }
        if self.flickers && opcode(request) == 0 {
            self.gauges[5] ^= 1;
        }
        let frames = self.device.answer(request, self.gauges, self.status);
        let kept = frames.into_iter().filter(|frame| match self.behaviour {
            Behaviour::LosesFirstHalf => opcode(frame) != 0,
            Behaviour::LosesSecondHalf => opcode(frame) != 1,
            Behaviour::Healthy | Behaviour::Silent => true,
        });
        kept.map(|frame| (self.exchange_us, frame)).collect()
    }

    fn stream(&self) -> Vec<(u64, Frame)> {
        let frames_of = |reading: u64| {
            let mut streamed = self.streamed;
            let flicker = if self.flickers {
                reading as u32 & 0xF
            } else {
                0
            };
            streamed[5] = f32::from_bits(streamed[5].to_bits() ^ flicker);
            stream_frames(streamed).unwrap()
        };
        let at_us = |reading: u64, part: u64| reading * STREAM_PERIOD_US + 100 * part;
        (1..=STREAM_READINGS)
            .flat_map(|reading| {
                let parts = (0..).zip(frames_of(reading));
                parts.map(move |(part, frame)| (at_us(reading, part), frame))
            })
            .collect()
    }
}

/// Lower four bits of the identifier: the operation of the ATI sensor.
pub(crate) fn opcode(frame: &Frame) -> u16 {
    match frame.id() {
        Id::Standard(id) => id & 0xF,
        Id::Extended(_) => panic!("extended frame"),
    }
}
