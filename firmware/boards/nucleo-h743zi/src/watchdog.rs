//! The independent watchdog, which only completed work feeds.

use crate::tasks::Shared;
use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG1;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Duration, Ticker};
use softdock_app::watchdog::{FEED_PERIOD_MS, Pulse, RESET_AFTER_US, Watch};

static PULSE: Pulse = Pulse::new();

/// Shows that the executor of the control cycle goes round; runs there.
#[embassy_executor::task]
pub(crate) async fn beat() -> ! {
    let mut ticker = Ticker::every(Duration::from_millis(FEED_PERIOD_MS / 4));
    loop {
        PULSE.beat();
        ticker.next().await;
    }
}

/// Feeds the watchdog; runs at the lower priority.
#[embassy_executor::task]
pub(crate) async fn feed(shared: &'static Shared, iwdg: Peri<'static, IWDG1>) -> ! {
    let mut watchdog = IndependentWatchdog::new(iwdg, RESET_AFTER_US);
    watchdog.unleash();
    let mut watch = Watch::default();
    let mut ticker = Ticker::every(Duration::from_millis(FEED_PERIOD_MS));
    loop {
        if watch.may_feed(&shared.status(), &PULSE) {
            watchdog.pet();
        }
        ticker.next().await;
    }
}
