//! The driver behind which all CAN sensors look alike.

use super::Frame;
use super::ati::AtiDriver;
use super::sri::SriDriver;
use crate::sensor::{SensorCounters, SensorDriver, SensorReading, SensorState};

/// Any supported CAN sensor.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one per board, and no heap to put it on"
)]
pub enum CanSensor {
    /// ATI NETCANOEM.
    Ati(AtiDriver),
    /// SRI M8123B2.
    Sri(SriDriver),
}

/// Calls the method of the sensor at hand.
macro_rules! delegate {
    ($self:ident . $method:ident ( $($argument:expr),* )) => {
        match $self {
            CanSensor::Ati(driver) => driver.$method($($argument),*),
            CanSensor::Sri(driver) => driver.$method($($argument),*),
        }
    };
}

impl SensorDriver for CanSensor {
    type Frame = Frame;

    fn poll_transmit(&mut self, now_us: u64) -> Option<Frame> {
        delegate!(self.poll_transmit(now_us))
    }

    fn next_deadline_us(&self) -> u64 {
        delegate!(self.next_deadline_us())
    }

    fn receive(&mut self, frame: &Frame, now_us: u64) -> Option<SensorReading> {
        delegate!(self.receive(frame, now_us))
    }

    fn expedite(&mut self, now_us: u64) {
        if let Self::Ati(driver) = self {
            driver.expedite(now_us);
        }
    }

    fn state(&self) -> SensorState {
        delegate!(self.state())
    }

    fn counters(&self) -> SensorCounters {
        delegate!(self.counters())
    }

    fn restart(&mut self) {
        delegate!(self.restart());
    }
}
