//! Whether the hardware watchdog may be fed.
//!
//! It is fed by completed work alone: the executor of the control cycle has gone round, and while
//! the robot sends, its telegrams have been dealt with. The task that asks runs at the lower
//! priority, so that it has gone round as well when it asks. A timer interrupt that feeds would
//! keep a board alive that does nothing else.

use crate::shared::Status;
use core::sync::atomic::{AtomicU32, Ordering};

/// How often the watchdog is to be fed, ms; also how long work may take to complete.
pub const FEED_PERIOD_MS: u64 = 100;

/// Time after which the hardware resets the board, µs: three missed meals, and below a second,
/// within which a robot at its slowest commissioning speed moves a few millimetres.
pub const RESET_AFTER_US: u32 = 350_000;

/// Rounds of the executor that runs the control cycle.
#[derive(Debug, Default)]
pub struct Pulse(AtomicU32);

impl Pulse {
    /// No round yet.
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Called by a task of the control cycle's executor, at least twice per [`FEED_PERIOD_MS`].
    pub fn beat(&self) {
        let beats = self.0.load(Ordering::Relaxed);
        self.0.store(beats.wrapping_add(1), Ordering::Relaxed);
    }

    fn beats(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Remembers what had been done when the watchdog was fed last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    beats: u32,
    telegrams: u64,
    connected: bool,
}

impl Watch {
    /// Whether enough has been done since the last call to feed the watchdog.
    pub fn may_feed(&mut self, status: &Status, pulse: &Pulse) -> bool {
        let now = Self {
            beats: pulse.beats(),
            telegrams: telegrams(status),
            connected: status.connected,
        };
        // A robot that has just come or gone need not have sent in the whole period.
        let expected = now.connected && self.connected;
        let answered = !expected || now.telegrams != self.telegrams;
        let alive = now.beats != self.beats && answered;
        if alive {
            *self = now;
        }
        alive
    }
}

/// Telegrams that have been dealt with in any way.
fn telegrams(status: &Status) -> u64 {
    let link = &status.link;
    let others = [
        link.duplicates,
        link.malformed,
        link.foreign,
        link.overtaken,
    ];
    others
        .iter()
        .fold(link.cycles, |sum, n| sum.wrapping_add(u64::from(*n)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(connected: bool, cycles: u64) -> Status {
        let mut status = Status {
            connected,
            ..Status::default()
        };
        status.link.cycles = cycles;
        status
    }

    #[test]
    fn an_idle_board_lives_by_its_pulse() {
        let (pulse, mut watch) = (Pulse::new(), Watch::default());
        pulse.beat();
        assert!(watch.may_feed(&status(false, 0), &pulse));
        assert!(!watch.may_feed(&status(false, 0), &pulse), "no pulse");
        pulse.beat();
        assert!(watch.may_feed(&status(false, 0), &pulse));
    }

    #[test]
    fn with_a_robot_a_pulse_without_answers_is_not_enough() {
        let (pulse, mut watch) = (Pulse::new(), Watch::default());
        pulse.beat();
        assert!(watch.may_feed(&status(true, 0), &pulse), "it has just come");
        for _ in 0..3 {
            pulse.beat();
            assert!(!watch.may_feed(&status(true, 0), &pulse));
        }
        assert!(watch.may_feed(&status(true, 1), &pulse));
        pulse.beat();
        assert!(watch.may_feed(&status(false, 1), &pulse), "it has gone");
    }
}
