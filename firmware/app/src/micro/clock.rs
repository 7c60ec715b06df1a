//! The board's clock over `embassy-time`.

use crate::board::Clock;
use cortex_m::peripheral::DWT;
use embassy_time::{Instant, Timer};

/// Time since boot by the board's time driver.
#[derive(Clone, Copy, Debug, Default)]
pub struct UptimeClock;

impl Clock for UptimeClock {
    fn now_us(&self) -> u64 {
        Instant::now().as_micros()
    }

    /// The counter of the DWT, which stands while the processor sleeps.
    fn processor_cycles(&self) -> Option<u32> {
        DWT::cycle_counter_enabled().then(DWT::cycle_count)
    }

    async fn wait_until(&self, at_us: u64) {
        // A `Timer` would be set to 584,942 years.
        if at_us == u64::MAX {
            core::future::pending::<()>().await;
        }
        Timer::at(Instant::from_micros(at_us)).await;
    }
}
