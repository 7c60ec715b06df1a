//! Three executors at three priorities, each in an interrupt that no device uses; [`interrupts`] assigns the priorities.
//!
//! In thread mode, an executor would idle in WFE, which QEMU emulates as a busy loop.
//!
//! [`interrupts`]: crate::interrupts
#![allow(unsafe_code, reason = "Embassy's contract for executors in interrupts")]

use crate::interrupts::{Interrupt, Interrupt as interrupt};
use embassy_executor::{InterruptExecutor, Spawner};
use softdock_app::micro::start::Spawners;

static CONTROL: InterruptExecutor = InterruptExecutor::new();
static BACKGROUND: InterruptExecutor = InterruptExecutor::new();
static SERVICE: InterruptExecutor = InterruptExecutor::new();

/// Starts the executors.
pub(crate) fn start() -> Spawners {
    Spawners {
        control: CONTROL.start(Interrupt::EXECUTOR_CONTROL),
        background: BACKGROUND.start(Interrupt::EXECUTOR_BACKGROUND),
        service: SERVICE.start(Interrupt::EXECUTOR_SERVICE),
    }
}

/// The spawner of the executor that runs the calling task, for tasks that cannot be sent from
/// another one.
pub(crate) async fn local() -> Spawner {
    // SAFETY: all futures of this firmware are polled by the executors above.
    unsafe { Spawner::for_current_executor().await }
}

#[cortex_m_rt::interrupt]
fn EXECUTOR_CONTROL() {
    // SAFETY: this is the executor's handler, and `start` unmasks it.
    unsafe { CONTROL.on_interrupt() }
}

#[cortex_m_rt::interrupt]
fn EXECUTOR_BACKGROUND() {
    // SAFETY: this is the executor's handler, and `start` unmasks it.
    unsafe { BACKGROUND.on_interrupt() }
}

#[cortex_m_rt::interrupt]
fn EXECUTOR_SERVICE() {
    // SAFETY: this is the executor's handler, and `start` unmasks it.
    unsafe { SERVICE.on_interrupt() }
}
