//! The sensor at the far end of the simulated CAN bus.

use crate::rig::SensorSampleSim;
use anyhow::{Context, Result};
use softdock_app::settings::{CanSettings, SensorKind};
use softdock_link::can::Frame;
use softdock_link::can::ati::{AtiCalibration, AtiDevice, ForceUnit, TorqueUnit};
use softdock_link::can::sri::{is_start_command, stream_frames};
use std::collections::VecDeque;

/// Time from the instant of a sample to its last frame: three frames at 1 Mbit/s, µs.
const EXCHANGE_US: u64 = 350;
/// Time between two samples of a streaming sensor, µs.
const STREAM_PERIOD_US: u64 = 1000;

/// Protocol of the sensor.
enum Protocol {
    /// ATI NETCANOEM: answers requests.
    Ati(AtiDevice),
    /// SRI M8123B2: streams from its start command on; the time of the next sample, µs.
    Sri(Option<u64>),
}

/// A sensor and its frames on the bus.
pub(crate) struct SimulatedSensor {
    protocol: Protocol,
    calibration: AtiCalibration,
    /// Frames on the bus, by the time at which they arrive.
    on_bus: VecDeque<(u64, Frame)>,
}

impl SimulatedSensor {
    /// The sensor that the board is set up for. The calibration is that of the rig's gauges.
    pub(crate) fn new(can: &CanSettings, calibration: AtiCalibration) -> Result<Self> {
        let (force, torque) = (ForceUnit::Newton, TorqueUnit::NewtonMetre);
        let protocol = match can.sensor {
            SensorKind::Ati => Protocol::Ati(
                AtiDevice::new(can.base_id, &calibration, force, torque)
                    .context("the simulated sensor")?,
            ),
            SensorKind::Sri => Protocol::Sri(None),
        };
        Ok(Self {
            protocol,
            calibration,
            on_bus: VecDeque::new(),
        })
    }

    /// Takes a frame of the board; `sense` is a reading at this instant.
    pub(crate) fn receive(
        &mut self,
        frame: &Frame,
        now_us: u64,
        sense: &mut dyn FnMut() -> SensorSampleSim,
    ) {
        match &mut self.protocol {
            Protocol::Ati(device) => {
                let sample = sense();
                for answer in device.answer(frame, sample.counts, sample.status) {
                    self.on_bus.push_back((now_us + EXCHANGE_US, answer));
                }
            }
            Protocol::Sri(next) if is_start_command(frame) => *next = Some(now_us),
            Protocol::Sri(_) => {}
        }
    }

    /// Time of the next event, µs; `u64::MAX` if there is none.
    pub(crate) fn next_us(&self) -> u64 {
        let frame = self.on_bus.front().map_or(u64::MAX, |(at, _)| *at);
        match self.protocol {
            Protocol::Sri(Some(sample)) => frame.min(sample),
            _ => frame,
        }
    }

    /// The next frame that has arrived by now.
    pub(crate) fn poll(
        &mut self,
        now_us: u64,
        sense: &mut dyn FnMut() -> SensorSampleSim,
    ) -> Option<Frame> {
        if let Protocol::Sri(Some(next)) = &mut self.protocol
            && *next <= now_us
        {
            *next += STREAM_PERIOD_US;
            let wrench = self.calibration.wrench(&sense().counts);
            for frame in stream_frames(wrench.map(|value| value as f32))
                .into_iter()
                .flatten()
            {
                self.on_bus.push_back((now_us + EXCHANGE_US, frame));
            }
        }
        self.on_bus
            .pop_front_if(|(at, _)| *at <= now_us)
            .map(|(_, frame)| frame)
    }
}
