//! SRI M8123B2 force/torque sensor, streaming over CAN at 1 Mbit/s.
//!
//! After a start command (identifier 0x80, data `02`) the sensor streams one reading in three frames: 0x291 force X, Y;
//! 0x292 force Z, torque X; 0x293 torque Y, Z. Each holds two little-endian `f32` in N and N·m. There are no status
//! bits, no time stamp and no counter.
//!
//! Source: two public drivers of the sensor.

use super::{Frame, Id};
use crate::sensor::{SensorCounters, SensorReading, SensorState};

const START_ID: Id = Id::Standard(0x80);
const START_DATA: [u8; 1] = [0x02];
/// Identifiers of the three frames of a reading, in the order in which they come.
const STREAM_IDS: [u16; 3] = [0x291, 0x292, 0x293];

/// Settings of an [`SriDriver`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SriConfig {
    /// Silence after which the start command is sent again (µs).
    pub stream_timeout_us: u64,
    /// Longest time from the first to the last frame of a reading (µs). It must be shorter than the time between two
    /// readings: otherwise, after lost frames, parts of two readings could be taken for one.
    pub pairing_window_us: u64,
    /// Magnitude from which an axis counts as saturated: force X, Y, Z (N), torque X, Y, Z (N·m), from the data sheet
    /// of the sensor at hand.
    pub saturation: [f64; 6],
}

impl Default for SriConfig {
    /// Three frames take about 0.4 ms at 1 Mbit/s; half a millisecond leaves readings at 1 kHz apart. No saturation.
    fn default() -> Self {
        Self {
            stream_timeout_us: 100_000,
            pairing_window_us: 500,
            saturation: [f64::INFINITY; 6],
        }
    }
}

/// A reading of which some frames have arrived.
#[derive(Clone, Copy, Debug)]
struct Partial {
    at_us: u64,
    frames: [[f64; 2]; 3],
    count: usize,
}

/// Driver of one sensor; see [`SensorDriver`](crate::sensor::SensorDriver) for how to use it.
#[derive(Clone, Debug)]
pub struct SriDriver {
    config: SriConfig,
    partial: Option<Partial>,
    state: SensorState,
    /// Time at which the start command is due if nothing comes, µs.
    next_start_us: u64,
    start_sent: bool,
    readings: u32,
    counters: SensorCounters,
}

impl SriDriver {
    /// Driver that starts the stream at the first [`Self::poll_transmit`].
    pub fn new(config: SriConfig) -> Self {
        Self {
            config,
            partial: None,
            state: SensorState::Starting,
            next_start_us: 0,
            start_sent: false,
            readings: 0,
            counters: SensorCounters::default(),
        }
    }

    /// See [`SensorDriver::poll_transmit`](crate::sensor::SensorDriver::poll_transmit).
    pub fn poll_transmit(&mut self, now_us: u64) -> Option<Frame> {
        if now_us < self.next_start_us {
            return None;
        }
        if self.start_sent {
            count(&mut self.counters.timeouts);
            count(&mut self.counters.retries);
        }
        if self.state == SensorState::Running {
            self.state = SensorState::Resynchronising;
        }
        self.start_sent = true;
        self.drop_partial();
        self.next_start_us = now_us.saturating_add(self.config.stream_timeout_us.max(1));
        Frame::new(START_ID, &START_DATA).ok()
    }

    /// See [`SensorDriver::next_deadline_us`](crate::sensor::SensorDriver::next_deadline_us).
    pub fn next_deadline_us(&self) -> u64 {
        self.next_start_us
    }

    /// See [`SensorDriver::receive`](crate::sensor::SensorDriver::receive).
    pub fn receive(&mut self, frame: &Frame, now_us: u64) -> Option<SensorReading> {
        let Some((part, values)) = decode(frame) else {
            count(&mut self.counters.unknown);
            return None;
        };
        if part == 0 {
            self.drop_partial();
            self.partial = Some(Partial {
                at_us: now_us,
                frames: [[0.0; 2]; 3],
                count: 0,
            });
        }
        let window_us = self.config.pairing_window_us;
        let partial = self.partial.as_mut().filter(|partial| {
            partial.count == part && now_us.saturating_sub(partial.at_us) <= window_us
        });
        let Some(partial) = partial else {
            count(&mut self.counters.unpaired);
            self.drop_partial();
            return None;
        };
        if let Some(slot) = partial.frames.get_mut(part) {
            *slot = values;
        }
        partial.count += 1;
        let Partial {
            at_us,
            frames,
            count,
        } = *partial;
        if count < frames.len() {
            return None;
        }
        self.partial = None;
        self.reading(frames, at_us, now_us)
    }

    /// State of the driver.
    pub fn state(&self) -> SensorState {
        self.state
    }

    /// Counters of the driver.
    pub fn counters(&self) -> SensorCounters {
        self.counters
    }

    /// Sends the start command again; the sensor has no reset.
    pub fn restart(&mut self) {
        self.drop_partial();
        self.state = SensorState::Starting;
        self.next_start_us = 0;
        self.start_sent = false;
    }

    fn reading(
        &mut self,
        [
            [force_x, force_y],
            [force_z, torque_x],
            [torque_y, torque_z],
        ]: [[f64; 2]; 3],
        at_us: u64,
        now_us: u64,
    ) -> Option<SensorReading> {
        let wrench = [force_x, force_y, force_z, torque_x, torque_y, torque_z];
        if !wrench.iter().all(|value| value.is_finite()) {
            count(&mut self.counters.invalid);
            return None;
        }
        self.state = SensorState::Running;
        self.next_start_us = now_us.saturating_add(self.config.stream_timeout_us.max(1));
        self.readings = self.readings.wrapping_add(1);
        let saturated = wrench
            .iter()
            .zip(&self.config.saturation)
            .any(|(value, limit)| value.abs() >= *limit);
        Some(SensorReading {
            wrench,
            counter: self.readings,
            at_us,
            saturated,
            ..SensorReading::default()
        })
    }

    fn drop_partial(&mut self) {
        if self.partial.take().is_some() {
            count(&mut self.counters.unpaired);
        }
    }
}

/// The place of a frame in its reading, and its two values; `None` if it belongs to none.
fn decode(frame: &Frame) -> Option<(usize, [f64; 2])> {
    let part = STREAM_IDS
        .iter()
        .position(|id| frame.id() == Id::Standard(*id))?;
    let &[a0, a1, a2, a3, b0, b1, b2, b3] = frame.data() else {
        return None;
    };
    let values = [[a0, a1, a2, a3], [b0, b1, b2, b3]].map(f32::from_le_bytes);
    Some((part, values.map(f64::from)))
}

/// The sensor's side, for simulated sensors: the three frames of a reading of force X, Y, Z (N) and torque X, Y, Z
/// (N·m).
pub fn stream_frames(wrench: [f32; 6]) -> Option<[Frame; 3]> {
    let [force_x, force_y, force_z, torque_x, torque_y, torque_z] = wrench.map(f32::to_le_bytes);
    let [first, second, third] = STREAM_IDS.map(Id::Standard);
    Some([
        Frame::new(first, [force_x, force_y].as_flattened()).ok()?,
        Frame::new(second, [force_z, torque_x].as_flattened()).ok()?,
        Frame::new(third, [torque_y, torque_z].as_flattened()).ok()?,
    ])
}

/// Whether `frame` is the command that starts the stream.
pub fn is_start_command(frame: &Frame) -> bool {
    frame.id() == START_ID && frame.data() == START_DATA
}

fn count(counter: &mut u32) {
    *counter = counter.wrapping_add(1);
}
