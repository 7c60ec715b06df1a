//! The three lamps of the board: LD1 green, LD2 yellow, LD3 red.

use crate::tasks::Shared;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::{PB0, PB14, PE1};
use embassy_time::{Duration, Ticker};
use softdock_app::lamps::{LAMP_PERIOD_MS, lamps};

/// LD1, LD2, LD3.
pub(crate) struct Leds {
    green: Output<'static>,
    yellow: Output<'static>,
    red: Output<'static>,
}

impl Leds {
    /// All dark.
    pub(crate) fn new(
        green: Peri<'static, PB0>,
        yellow: Peri<'static, PE1>,
        red: Peri<'static, PB14>,
    ) -> Self {
        Self {
            green: Output::new(green, Level::Low, Speed::Low),
            yellow: Output::new(yellow, Level::Low, Speed::Low),
            red: Output::new(red, Level::Low, Speed::Low),
        }
    }
}

/// Shows the state of the board.
#[embassy_executor::task]
pub(crate) async fn show(shared: &'static Shared, mut leds: Leds) -> ! {
    let mut ticker = Ticker::every(Duration::from_millis(LAMP_PERIOD_MS.into()));
    let mut tick = 0_u32;
    loop {
        let lit = lamps(&shared.status(), tick);
        leds.green.set_level(lit.green.into());
        leds.yellow.set_level(lit.yellow.into());
        leds.red.set_level(lit.red.into());
        tick = tick.wrapping_add(1);
        ticker.next().await;
    }
}
