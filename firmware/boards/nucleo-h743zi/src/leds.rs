//! The three LEDs of the board: LD1 green, LD2 yellow, LD3 red.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::{PB0, PB14, PE1};
use softdock_app::leds;
use softdock_app::micro::SHARED;
use softdock_app::micro::clock::UptimeClock;

/// Pins of the LEDs.
pub(crate) struct Pins {
    pub(crate) green: Peri<'static, PB0>,
    pub(crate) yellow: Peri<'static, PE1>,
    pub(crate) red: Peri<'static, PB14>,
}

/// LD1, LD2, LD3.
pub(crate) struct Leds {
    green: Output<'static>,
    yellow: Output<'static>,
    red: Output<'static>,
}

impl Leds {
    /// All LEDs off.
    pub(crate) fn new(pins: Pins) -> Self {
        Self {
            green: Output::new(pins.green, Level::Low, Speed::Low),
            yellow: Output::new(pins.yellow, Level::Low, Speed::Low),
            red: Output::new(pins.red, Level::Low, Speed::Low),
        }
    }
}

/// Shows the state of the board.
#[embassy_executor::task]
pub(crate) async fn show(mut pins: Leds) -> ! {
    let set = |lit: softdock_app::shared::Leds| {
        pins.green.set_level(lit.green.into());
        pins.yellow.set_level(lit.yellow.into());
        pins.red.set_level(lit.red.into());
    };
    leds::show(&SHARED, &UptimeClock, set).await
}
