//! The independent watchdog, which only completed work feeds.

use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG1;
use embassy_stm32::wdg::IndependentWatchdog;
use softdock_app::micro::SHARED;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::watchdog::{Heartbeat, RESET_AFTER_US, supervise};

static HEARTBEAT: Heartbeat = Heartbeat::new();

/// Shows that the executor of the control cycle goes round; runs there.
#[embassy_executor::task]
pub(crate) async fn beat() -> ! {
    HEARTBEAT.run(&UptimeClock).await
}

/// Feeds the watchdog; runs below the control cycle.
#[embassy_executor::task]
pub(crate) async fn feed(iwdg: Peri<'static, IWDG1>) -> ! {
    let mut watchdog = IndependentWatchdog::new(iwdg, RESET_AFTER_US);
    watchdog.unleash();
    supervise(&SHARED, &UptimeClock, &HEARTBEAT, || watchdog.pet()).await
}
