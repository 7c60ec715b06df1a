//! State of robot, sensor and flash for the checks before a test, in addition to [`Status`](super::Status) and
//! [`Counters`](super::Counters).

use super::Text;
use serde::{Deserialize, Serialize};

/// Robot and sensor at an instant. Two of them, some time apart, give rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Time since boot, ms.
    pub uptime_ms: u64,
    /// Cycles that were answered since boot.
    pub cycles: u64,
    /// The robot's last telegram, if there was one since boot.
    pub robot: Option<RobotHealth>,
    /// The sensor's newest sample, if there was one since boot.
    pub sensor: Option<SensorHealth>,
}

/// Content of the robot's last telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotHealth {
    /// Its counter of late or rejected answers (Delay D).
    pub late_answers: u32,
    /// Status of its POSCORR object: bits 1-3 lower, 4-6 upper X Y Z, 7 rotation clamped; 0 also if
    /// it does not send it.
    pub poscorr_stat: u32,
    /// It sent its pose.
    pub pose: bool,
}

/// The newest sample of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorHealth {
    /// Its number; it rises by one with each sample, wrapping.
    pub counter: u32,
    /// Time since it was taken, ms.
    pub age_ms: u32,
    /// Status word of the sensor.
    pub status: u32,
    /// A gauge is at its range: all axes are wrong.
    pub saturated: bool,
}

/// Content of a slot of the flash.
#[allow(
    clippy::large_enum_variant,
    reason = "nothing is allocated; it is made, sent and forgotten"
)]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FlashSlot {
    /// No settings.
    Empty,
    /// Settings that are kept.
    Kept {
        /// Number of the set.
        sequence: u32,
    },
    /// Settings that nobody has confirmed: on trial, or given up.
    NotConfirmed,
    /// Settings that cannot be used.
    Unusable {
        /// Why.
        reason: Text,
    },
}
