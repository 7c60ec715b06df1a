//! Three executors at three priorities, each in an interrupt that no device uses. The control cycle
//! interrupts everything that is not needed for it, and everything interrupts the service.
//!
//! In thread mode, an executor would idle in WFE, which QEMU takes for a busy processor.
#![allow(unsafe_code, reason = "Embassy's contract for executors in interrupts")]

use crate::interrupts::{Interrupt, Interrupt as interrupt};
use embassy_executor::{InterruptExecutor, SendSpawner, Spawner};

static HIGH: InterruptExecutor = InterruptExecutor::new();
static LOW: InterruptExecutor = InterruptExecutor::new();
static SERVICE: InterruptExecutor = InterruptExecutor::new();

/// Starts the executor of network, sensor and robot.
pub(crate) fn start_high() -> SendSpawner {
    HIGH.start(Interrupt::EXECUTOR_HIGH)
}

/// Starts the executor of everything that may wait.
pub(crate) fn start_low() -> SendSpawner {
    LOW.start(Interrupt::EXECUTOR_LOW)
}

/// Starts the executor of the service.
pub(crate) fn start_service() -> SendSpawner {
    SERVICE.start(Interrupt::EXECUTOR_SERVICE)
}

/// The spawner of the executor that runs the calling task, for tasks that cannot be sent from
/// another one.
pub(crate) async fn local() -> Spawner {
    // SAFETY: all futures of this firmware are polled by the executors above.
    unsafe { Spawner::for_current_executor().await }
}

#[cortex_m_rt::interrupt]
fn EXECUTOR_HIGH() {
    // SAFETY: this is the executor's handler, and `start_high` unmasks it.
    unsafe { HIGH.on_interrupt() }
}

#[cortex_m_rt::interrupt]
fn EXECUTOR_LOW() {
    // SAFETY: this is the executor's handler, and `start_low` unmasks it.
    unsafe { LOW.on_interrupt() }
}

#[cortex_m_rt::interrupt]
fn EXECUTOR_SERVICE() {
    // SAFETY: this is the executor's handler, and `start_service` unmasks it.
    unsafe { SERVICE.on_interrupt() }
}
