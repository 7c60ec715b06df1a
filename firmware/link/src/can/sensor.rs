//! The driver behind which all CAN sensors look alike.

use core::fmt;

use super::ati::AtiDriver;
use super::sri::SriDriver;
use super::{Frame, SensorReading};

/// How far a driver is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorState {
    /// Waking the sensor up or reading its calibration.
    Starting,
    /// Readings come in.
    Running,
    /// The sensor ran and then missed an answer; nothing is accepted until it answers in step again.
    Resynchronising,
    /// No readings, and why.
    Failed(SensorFault),
}

/// Why a driver gives no readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorFault {
    /// The sensor does not answer; the driver tries again by itself.
    NoAnswer,
    /// The identifier base of the configuration has more than seven bits.
    BaseId {
        /// The base.
        received: u8,
    },
    /// The sensor reports a force unit that is not in its manual.
    ForceUnit {
        /// The code.
        code: u8,
    },
    /// The sensor reports a torque unit that is not in its manual.
    TorqueUnit {
        /// The code.
        code: u8,
    },
    /// The sensor reports zero counts per unit.
    CountsPerUnit {
        /// Counts per unit of force.
        force: u32,
        /// Counts per unit of torque.
        torque: u32,
    },
    /// The sensor's calibration matrix is not finite.
    Matrix {
        /// Row: 0 to 5 for force X, Y, Z, torque X, Y, Z.
        row: u8,
    },
    /// The sensor now reports another scale than at start-up, so the calibration in use is not its own.
    CalibrationChanged,
}

impl fmt::Display for SensorFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer => f.write_str("the sensor does not answer"),
            Self::BaseId { received } => {
                write!(f, "identifier base {received:#x} has more than 7 bits")
            }
            Self::ForceUnit { code } => write!(f, "unknown force unit {code}, expected 1 to 6"),
            Self::TorqueUnit { code } => write!(f, "unknown torque unit {code}, expected 1 to 6"),
            Self::CountsPerUnit { force, torque } => write!(
                f,
                "counts per unit must not be zero: force {force}, torque {torque}"
            ),
            Self::Matrix { row } => write!(f, "row {row} of the calibration matrix is not finite"),
            Self::CalibrationChanged => {
                f.write_str("the sensor's scale differs from the one read at start-up")
            }
        }
    }
}

impl core::error::Error for SensorFault {}

/// What a driver has seen; every counter wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensorCounters {
    /// Answers, or a stream, that did not come in time.
    pub timeouts: u32,
    /// Requests that were sent again.
    pub retries: u32,
    /// Frames that nobody was waiting for any more.
    pub late: u32,
    /// Frames whose counterparts are missing.
    pub unpaired: u32,
    /// Frames that do not belong to the sensor's protocol, or with a wrong length.
    pub unknown: u32,
    /// Readings with numbers that are not finite.
    pub invalid: u32,
}

/// Any supported CAN sensor.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one per board, and no heap to put it on"
)]
pub enum SensorDriver {
    /// ATI NETCANOEM.
    Ati(AtiDriver),
    /// SRI M8123B2.
    Sri(SriDriver),
}

/// Calls the method of the sensor at hand.
macro_rules! delegate {
    ($self:ident . $method:ident ( $($argument:expr),* )) => {
        match $self {
            SensorDriver::Ati(driver) => driver.$method($($argument),*),
            SensorDriver::Sri(driver) => driver.$method($($argument),*),
        }
    };
}

impl SensorDriver {
    /// The next frame for the bus, if one is due. Call until it returns `None`.
    pub fn poll_transmit(&mut self, now_us: u64) -> Option<Frame> {
        delegate!(self.poll_transmit(now_us))
    }

    /// When to call [`Self::poll_transmit`] again at the latest; `u64::MAX` for never.
    pub fn next_deadline_us(&self) -> u64 {
        delegate!(self.next_deadline_us())
    }

    /// Takes a frame from the bus, and returns the reading that it completes.
    pub fn receive(&mut self, frame: &Frame, now_us: u64) -> Option<SensorReading> {
        delegate!(self.receive(frame, now_us))
    }

    /// Makes the next request due at once, if none is on its way; a streaming sensor cannot hurry.
    pub fn hurry(&mut self, now_us: u64) {
        if let Self::Ati(driver) = self {
            driver.hurry(now_us);
        }
    }

    /// How far the driver is.
    pub fn state(&self) -> SensorState {
        delegate!(self.state())
    }

    /// What the driver has seen.
    pub fn counters(&self) -> SensorCounters {
        delegate!(self.counters())
    }

    /// Starts over: resets the sensor where it can be reset, and reads its calibration anew. For the operator's reset
    /// of a latched sensor fault.
    pub fn restart(&mut self) {
        delegate!(self.restart());
    }
}
