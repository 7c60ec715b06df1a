//! Time for Embassy: the FPGA's free-running counter, and CMSDK timer 0 as alarm.
#![allow(unsafe_code, reason = "addresses of registers")]

use crate::chip;
use crate::interrupts::{self, Interrupt, Interrupt as interrupt};
use crate::register::Register;
use core::cell::{Cell, RefCell};
use core::task::Waker;
use critical_section::{CriticalSection, Mutex};
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;

/// Ticks of the counter per µs.
const TICKS_PER_US: u64 = chip::CLOCK_HZ as u64 / 1_000_000;
/// Longest alarm, µs. The counter wraps after 171 s and has to be read before that.
const LONGEST_ALARM_US: u64 = 60_000_000;

// SAFETY: the counter, and the registers of CMSDK timer 0 (Cortex-M System Design Kit, technical
// reference manual, 4.4).
const COUNTER: Register = unsafe { Register::at(chip::COUNTER) };
// SAFETY: see above.
const CTRL: Register = unsafe { Register::at(chip::TIMER0) };
// SAFETY: see above.
const VALUE: Register = unsafe { Register::at(chip::TIMER0 + 0x4) };
// SAFETY: see above.
const RELOAD: Register = unsafe { Register::at(chip::TIMER0 + 0x8) };
// SAFETY: see above.
const INTCLEAR: Register = unsafe { Register::at(chip::TIMER0 + 0xC) };

const ENABLE: u32 = 1;
const INTERRUPT: u32 = 1 << 3;

/// The counter, extended to 64 bits.
struct Ticks {
    last: u32,
    wraps: u32,
}

struct Mps2Time {
    ticks: Mutex<Cell<Ticks>>,
    queue: Mutex<RefCell<Queue>>,
}

embassy_time_driver::time_driver_impl!(static TIME: Mps2Time = Mps2Time {
    ticks: Mutex::new(Cell::new(Ticks { last: 0, wraps: 0 })),
    queue: Mutex::new(RefCell::new(Queue::new())),
});

/// Starts the alarm, which also reads the counter often enough.
pub(crate) fn start() {
    critical_section::with(|cs| TIME.ring(cs));
    interrupts::unmask(Interrupt::TIMER0);
}

impl Mps2Time {
    /// Wakes the tasks that are due and sets the next alarm.
    fn ring(&self, cs: CriticalSection<'_>) {
        let mut queue = self.queue.borrow_ref_mut(cs);
        let mut next = queue.next_expiration(self.now());
        while !self.set_alarm(next) {
            next = queue.next_expiration(self.now());
        }
    }

    /// Sets the alarm; false if its time has already come.
    fn set_alarm(&self, at_us: u64) -> bool {
        let wait_us = at_us.saturating_sub(self.now()).min(LONGEST_ALARM_US);
        CTRL.write(0);
        INTCLEAR.write(1);
        if wait_us == 0 {
            return false;
        }
        // RELOAD must differ from the waiting time: in QEMU with -icount, the interrupt would otherwise come after twice the
        // time if the processor sleeps.
        RELOAD.write(u32::MAX);
        VALUE.write((wait_us * TICKS_PER_US) as u32);
        CTRL.write(ENABLE | INTERRUPT);
        true
    }
}

impl Driver for Mps2Time {
    fn now(&self) -> u64 {
        let ticks = critical_section::with(|cs| {
            let cell = self.ticks.borrow(cs);
            let now = COUNTER.read();
            let Ticks { last, wraps } = cell.replace(Ticks { last: 0, wraps: 0 });
            let wraps = wraps + u32::from(now < last);
            cell.set(Ticks { last: now, wraps });
            u64::from(wraps) << 32 | u64::from(now)
        });
        ticks / TICKS_PER_US
    }

    fn schedule_wake(&self, at_us: u64, waker: &Waker) {
        critical_section::with(|cs| {
            if self.queue.borrow_ref_mut(cs).schedule_wake(at_us, waker) {
                self.ring(cs);
            }
        });
    }
}

#[cortex_m_rt::interrupt]
fn TIMER0() {
    critical_section::with(|cs| TIME.ring(cs));
}
