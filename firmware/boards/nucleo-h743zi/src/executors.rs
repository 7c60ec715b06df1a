//! Three executors at three priorities, each in an interrupt whose peripheral is not used. The control
//! cycle interrupts everything that is not needed for it, and everything interrupts the service.
#![allow(unsafe_code, reason = "Embassy's contract for executors in interrupts")]

use embassy_executor::{InterruptExecutor, SendSpawner, Spawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{Interrupt, InterruptExt, Priority};

static HIGH: InterruptExecutor = InterruptExecutor::new();
static LOW: InterruptExecutor = InterruptExecutor::new();
static SERVICE: InterruptExecutor = InterruptExecutor::new();

/// Handlers of devices, above the executors, only move bytes and wake tasks; embassy-stm32 leaves
/// them at the highest priority, 0.
const HIGH_PRIORITY: Priority = Priority::P4;
const LOW_PRIORITY: Priority = Priority::P8;
/// Below the watchdog's task, which must come round while the service is at work.
const SERVICE_PRIORITY: Priority = Priority::P12;

/// Starts the executor of network, sensor and robot.
pub(crate) fn start_high() -> SendSpawner {
    Interrupt::UART4.set_priority(HIGH_PRIORITY);
    HIGH.start(Interrupt::UART4)
}

/// Starts the executor of everything that may wait.
pub(crate) fn start_low() -> SendSpawner {
    Interrupt::UART5.set_priority(LOW_PRIORITY);
    LOW.start(Interrupt::UART5)
}

/// Starts the executor of the service.
pub(crate) fn start_service() -> SendSpawner {
    Interrupt::UART7.set_priority(SERVICE_PRIORITY);
    SERVICE.start(Interrupt::UART7)
}

/// The spawner of the executor that runs the calling task, for tasks that cannot be sent from
/// another one.
pub(crate) async fn local() -> Spawner {
    // SAFETY: all futures of this firmware are polled by the executors above.
    unsafe { Spawner::for_current_executor().await }
}

#[interrupt]
fn UART4() {
    // SAFETY: this is the executor's handler, and `start_high` unmasks it.
    unsafe { HIGH.on_interrupt() }
}

#[interrupt]
fn UART5() {
    // SAFETY: this is the executor's handler, and `start_low` unmasks it.
    unsafe { LOW.on_interrupt() }
}

#[interrupt]
fn UART7() {
    // SAFETY: this is the executor's handler, and `start_service` unmasks it.
    unsafe { SERVICE.on_interrupt() }
}
