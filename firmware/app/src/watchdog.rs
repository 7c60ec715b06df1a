//! Whether the hardware watchdog may be fed.
//!
//! It is fed by completed work alone: the executor of the control cycle has completed a round, and the robot's telegrams, if it
//! sends any, have been handled. The task that feeds runs at the lower priority, so that it shows to be running as well. Feeding
//! from a timer interrupt would keep a board alive that does nothing else.

use crate::board::Clock;
use crate::shared::{Shared, Status};
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_sync::blocking_mutex::raw::RawMutex;

/// How often the watchdog is to be fed, µs; also how long work may take to complete.
const FEED_PERIOD_US: u64 = 100_000;

/// Time after which the hardware resets the board, µs: three missed feeds, and below a second,
/// within which a robot at its slowest commissioning speed moves a few millimetres.
pub const RESET_AFTER_US: u32 = 350_000;

/// Feeds the hardware as long as work is completed, forever; to be awaited at a lower priority than the control cycle.
pub async fn supervise<M: RawMutex>(
    shared: &Shared<M>,
    clock: &impl Clock,
    heartbeat: &Heartbeat,
    mut feed: impl FnMut(),
) -> ! {
    let mut supervisor = Supervisor::default();
    let mut next_us = clock.now_us();
    loop {
        if supervisor.may_feed(&shared.status(), heartbeat) {
            feed();
        }
        next_us += FEED_PERIOD_US;
        clock.wait_until(next_us).await;
    }
}

/// Rounds of the executor that runs the control cycle.
#[derive(Debug, Default)]
pub struct Heartbeat(AtomicU32);

impl Heartbeat {
    /// No round yet.
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Counts rounds forever; to be awaited in the executor of the control cycle.
    pub async fn run(&self, clock: &impl Clock) -> ! {
        let mut next_us = clock.now_us();
        loop {
            self.beat();
            next_us += FEED_PERIOD_US / 4;
            clock.wait_until(next_us).await;
        }
    }

    fn beat(&self) {
        let beats = self.0.load(Ordering::Relaxed);
        self.0.store(beats.wrapping_add(1), Ordering::Relaxed);
    }

    fn beats(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// State of the work when the watchdog was fed last.
#[derive(Clone, Copy, Debug, Default)]
struct Supervisor {
    beats: u32,
    telegrams: u64,
    connected: bool,
}

impl Supervisor {
    /// Whether enough has been done since the last call to feed the watchdog.
    fn may_feed(&mut self, status: &Status, heartbeat: &Heartbeat) -> bool {
        let now = Self {
            beats: heartbeat.beats(),
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

/// Number of telegrams that have been handled in any way.
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
    use crate::board::tests::Stopwatch;
    use embassy_futures::poll_once;
    use embassy_sync::blocking_mutex::raw::NoopRawMutex;

    fn status(connected: bool, cycles: u64) -> Status {
        let mut status = Status {
            connected,
            ..Status::default()
        };
        status.link.cycles = cycles;
        status
    }

    #[test]
    fn an_idle_board_lives_by_its_heartbeat() {
        let (heartbeat, mut supervisor) = (Heartbeat::new(), Supervisor::default());
        heartbeat.beat();
        assert!(supervisor.may_feed(&status(false, 0), &heartbeat));
        assert!(
            !supervisor.may_feed(&status(false, 0), &heartbeat),
            "no heartbeat"
        );
        heartbeat.beat();
        assert!(supervisor.may_feed(&status(false, 0), &heartbeat));
    }

    #[test]
    fn with_a_robot_a_heartbeat_without_answers_is_not_enough() {
        let (heartbeat, mut supervisor) = (Heartbeat::new(), Supervisor::default());
        heartbeat.beat();
        assert!(
            supervisor.may_feed(&status(true, 0), &heartbeat),
            "it has just come"
        );
        for _ in 0..3 {
            heartbeat.beat();
            assert!(!supervisor.may_feed(&status(true, 0), &heartbeat));
        }
        assert!(supervisor.may_feed(&status(true, 1), &heartbeat));
        heartbeat.beat();
        assert!(
            supervisor.may_feed(&status(false, 1), &heartbeat),
            "it has gone"
        );
    }

    #[test]
    fn a_heartbeat_beats_between_two_feedings() {
        let (heartbeat, clock) = (Heartbeat::new(), Stopwatch::until(FEED_PERIOD_US));
        assert!(poll_once(heartbeat.run(&clock)).is_pending());
        assert_eq!(heartbeat.beats(), 5, "at 0, and four times since");
    }

    #[test]
    fn as_long_as_work_is_completed_the_hardware_is_fed_in_time() {
        let (shared, heartbeat) = (Shared::<NoopRawMutex>::new(), Heartbeat::new());
        let clock = Stopwatch::until(1_000_000);
        let mut times_us = Vec::new();
        heartbeat.beat();
        let fed = supervise(&shared, &clock, &heartbeat, || {
            times_us.push(clock.now_us());
            heartbeat.beat();
        });
        assert!(poll_once(fed).is_pending());
        assert_eq!(times_us.len(), 11);
        let longest_us = times_us.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(
            longest_us < Some(u64::from(RESET_AFTER_US) / 3),
            "{longest_us:?}"
        );
    }
}
