//! The independent watchdog, which only completed work feeds.

use embassy_stm32::Peri;
use embassy_stm32::pac::IWDG1 as REGISTERS;
use embassy_stm32::pac::iwdg::vals::Key;
use embassy_stm32::peripherals::IWDG1;
use embassy_stm32::wdg::IndependentWatchdog;
use softdock_app::micro::SHARED;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::watchdog::{Heartbeat, RESET_AFTER_US, supervise};

/// The only watchdog of the chip that does not depend on a clock of the processor.
pub(crate) type Watchdog = IndependentWatchdog<'static, IWDG1>;

static HEARTBEAT: Heartbeat = Heartbeat::new();

/// Shows that the executor of the control cycle is running; runs on that executor.
#[embassy_executor::task]
pub(crate) async fn beat() -> ! {
    HEARTBEAT.run(&UptimeClock).await
}

/// Starts the watchdog before anything else, so that it also catches a start that hangs, for example because an oscillator
/// does not start. It has an oscillator of its own, and until [`start`] the period of its registers at reset: 4 times 4096
/// cycles of 32 kHz (RM0433, IWDG_PR and IWDG_RLR).
pub(crate) fn guard_start() {
    REGISTERS.kr().write(|w| w.set_key(Key::START));
}

/// Sets the period of the watchdog.
pub(crate) fn start(iwdg: Peri<'static, IWDG1>) -> Watchdog {
    let mut watchdog = IndependentWatchdog::new(iwdg, RESET_AFTER_US);
    watchdog.unleash();
    // The new period begins here.
    watchdog.pet();
    watchdog
}

/// Feeds the watchdog; runs at a lower priority than the control cycle.
#[embassy_executor::task]
pub(crate) async fn feed(mut watchdog: Watchdog) -> ! {
    supervise(&SHARED, &UptimeClock, &HEARTBEAT, || watchdog.pet()).await
}
