//! State and counters of a board in the types of the service.

use super::Now;
use crate::shared;
use core::fmt::{Debug, Write};
use softdock_control::modes::Command;
use softdock_link::service::{Counters, Health, RobotHealth, SensorHealth, Word};

/// The name of a variant, cut off at its capacity.
pub(super) fn word(value: impl Debug) -> Word {
    let mut word = Word::new();
    let _ = write!(word, "{value:?}");
    word
}

/// The word of a command.
pub(super) fn command_word(command: Command) -> Word {
    Word::try_from(command.word()).unwrap_or_default()
}

/// Counters of robot, sensor and bus.
pub(super) fn counters(status: &shared::Status) -> Counters {
    let (link, sensor) = (&status.link, &status.sensor_counters);
    Counters {
        cycles: link.cycles,
        duplicates: link.duplicates,
        lost: link.lost,
        malformed: link.malformed,
        foreign: link.foreign,
        overtaken: link.overtaken,
        runs: link.runs,
        sensor_timeouts: sensor.timeouts,
        sensor_retries: sensor.retries,
        sensor_late: sensor.late,
        sensor_unpaired: sensor.unpaired,
        sensor_unknown: sensor.unknown,
        sensor_invalid: sensor.invalid,
        bus_offs: status.bus_offs,
        can_losses: status.can_losses,
        frames: 0,
        damaged_frames: 0,
    }
}

/// Robot and sensor at an instant.
pub(super) fn health(now: &Now) -> Health {
    let status = &now.status;
    Health {
        uptime_ms: now.us / 1000,
        cycles: status.link.cycles,
        robot: status.telegram.map(|telegram| RobotHealth {
            late_answers: telegram.late_answers,
            poscorr_stat: telegram.status,
            pose: telegram.pose,
        }),
        sensor: status.sample.map(|sample| SensorHealth {
            counter: sample.counter,
            age_ms: u32::try_from(now.us.saturating_sub(sample.at_us) / 1000).unwrap_or(u32::MAX),
            status: sample.status,
            saturated: sample.saturated,
        }),
    }
}
