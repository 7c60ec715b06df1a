//! Real time since the start of the process, and alarms by a thread of their own.

use softdock_app::board::Clock;
use std::future::poll_fn;
use std::sync::{Arc, Condvar, Mutex, PoisonError, Weak};
use std::task::{Poll, Waker};
use std::thread;
use std::time::{Duration, Instant};

#[derive(Debug)]
struct Alarms {
    pending: Mutex<Vec<(u64, Waker)>>,
    changed: Condvar,
    start: Instant,
}

/// The clock of a board in real time.
#[derive(Clone, Debug)]
pub(crate) struct RealClock(Arc<Alarms>);

impl RealClock {
    /// Starts the thread that rings the alarms; it ends when the last clock is dropped.
    pub(crate) fn start() -> Self {
        let alarms = Arc::new(Alarms {
            pending: Mutex::new(Vec::new()),
            changed: Condvar::new(),
            start: Instant::now(),
        });
        let weak = Arc::downgrade(&alarms);
        thread::spawn(move || ring(&weak));
        Self(alarms)
    }

    /// Wakes a task once, at `at_us` or soon after.
    pub(crate) fn wake_at(&self, at_us: u64, waker: &Waker) {
        let mut pending = self
            .0
            .pending
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let known = |(at, known): &(u64, Waker)| *at == at_us && known.will_wake(waker);
        if !pending.iter().any(known) {
            pending.push((at_us, waker.clone()));
            self.0.changed.notify_one();
        }
    }
}

impl Alarms {
    fn now_us(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }
}

/// Longest sleep of the thread, so that it notices that nobody holds the clock any more.
const LONGEST_SLEEP_US: u64 = 100_000;

fn ring(alarms: &Weak<Alarms>) {
    while let Some(alarms) = alarms.upgrade() {
        let mut pending = alarms
            .pending
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let now_us = alarms.now_us();
        pending.retain(|(at, waker)| {
            let due = *at <= now_us;
            if due {
                waker.wake_by_ref();
            }
            !due
        });
        let next = pending.iter().map(|(at, _)| *at).min().unwrap_or(u64::MAX);
        let sleep_us = next.saturating_sub(now_us).clamp(1, LONGEST_SLEEP_US);
        drop(
            alarms
                .changed
                .wait_timeout(pending, Duration::from_micros(sleep_us)),
        );
    }
}

impl Clock for RealClock {
    fn now_us(&self) -> u64 {
        self.0.now_us()
    }

    async fn wait_until(&self, at_us: u64) {
        poll_fn(|context| {
            if self.now_us() >= at_us {
                return Poll::Ready(());
            }
            // A stale alarm wakes the task without an effect.
            self.wake_at(at_us, context.waker());
            Poll::Pending
        })
        .await;
    }
}
