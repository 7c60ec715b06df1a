//! The time driver behind `embassy-time` on the host, for ethercrab's timers: the virtual time of the
//! simulation that runs on the calling thread, or real time.

use super::process::RealClock;
use embassy_time_driver::{Driver, time_driver_impl};
use softdock_app::board::Clock as _;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::LazyLock;
use std::task::Waker;

/// A simulation's time.
pub(super) trait TimeSource {
    /// Now, µs.
    fn now_us(&self) -> u64;
    /// Wakes a task once, at `at_us` or soon after.
    fn wake_at(&self, at_us: u64, waker: &Waker);
}

thread_local! {
    static VIRTUAL: RefCell<Option<Rc<dyn TimeSource>>> = const { RefCell::new(None) };
}

static REAL: LazyLock<RealClock> = LazyLock::new(RealClock::start);

/// While it lives, time on this thread is that of a simulation.
pub(super) struct VirtualTime(());

impl VirtualTime {
    pub(super) fn of(source: impl TimeSource + 'static) -> Self {
        VIRTUAL.set(Some(Rc::new(source)));
        Self(())
    }
}

impl Drop for VirtualTime {
    fn drop(&mut self) {
        VIRTUAL.set(None);
    }
}

struct HostTime;

impl Driver for HostTime {
    fn now(&self) -> u64 {
        match VIRTUAL.with_borrow(Clone::clone) {
            Some(source) => source.now_us(),
            None => REAL.now_us(),
        }
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        match VIRTUAL.with_borrow(Clone::clone) {
            Some(source) => source.wake_at(at, waker),
            None => REAL.wake_at(at, waker),
        }
    }
}

time_driver_impl!(static DRIVER: HostTime = HostTime);
