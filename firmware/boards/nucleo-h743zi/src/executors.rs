//! Three executors at three priorities, each in an interrupt whose peripheral is not used.
#![allow(unsafe_code, reason = "Embassy's contract for executors in interrupts")]

use embassy_executor::{InterruptExecutor, Spawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{Interrupt, InterruptExt, Priority};
use softdock_app::micro::start::Spawners;

static CONTROL: InterruptExecutor = InterruptExecutor::new();
static BACKGROUND: InterruptExecutor = InterruptExecutor::new();
static SERVICE: InterruptExecutor = InterruptExecutor::new();

/// Starts the executors. The handlers of devices have a higher priority and only move bytes and wake tasks; embassy-stm32
/// leaves them at the highest priority, 0.
pub(crate) fn start() -> Spawners {
    Interrupt::UART4.set_priority(Priority::P4);
    Interrupt::UART5.set_priority(Priority::P8);
    // Lower than the watchdog's task, which must run while the service is busy.
    Interrupt::UART7.set_priority(Priority::P12);
    Spawners {
        control: CONTROL.start(Interrupt::UART4),
        background: BACKGROUND.start(Interrupt::UART5),
        service: SERVICE.start(Interrupt::UART7),
    }
}

/// The spawner of the executor that runs the calling task, for tasks that cannot be sent from
/// another one.
pub(crate) async fn local() -> Spawner {
    // SAFETY: all futures of this firmware are polled by the executors above.
    unsafe { Spawner::for_current_executor().await }
}

#[interrupt]
fn UART4() {
    // SAFETY: this is the executor's handler, and `start` unmasks it.
    unsafe { CONTROL.on_interrupt() }
}

#[interrupt]
fn UART5() {
    // SAFETY: this is the executor's handler, and `start` unmasks it.
    unsafe { BACKGROUND.on_interrupt() }
}

#[interrupt]
fn UART7() {
    // SAFETY: this is the executor's handler, and `start` unmasks it.
    unsafe { SERVICE.on_interrupt() }
}
