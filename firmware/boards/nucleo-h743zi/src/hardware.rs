//! Assignment of peripherals and pins.

use crate::{ethernet, leds, sensor_link, serial};
use embassy_stm32::peripherals::{FLASH, IWDG1, RNG};
use embassy_stm32::{Peri, Peripherals};

/// The peripherals by their use.
pub(crate) struct Hardware {
    pub(crate) watchdog: Peri<'static, IWDG1>,
    pub(crate) random: Peri<'static, RNG>,
    pub(crate) flash: Peri<'static, FLASH>,
    pub(crate) ethernet: ethernet::Pins,
    pub(crate) sensor: sensor_link::Pins,
    pub(crate) leds: leds::Pins,
    pub(crate) serial: serial::Pins,
}

impl Hardware {
    /// Only assigns the peripherals, without starting any.
    pub(crate) fn new(p: Peripherals) -> Self {
        Self {
            watchdog: p.IWDG1,
            random: p.RNG,
            flash: p.FLASH,
            ethernet: ethernet::Pins {
                eth: p.ETH,
                sma: p.ETH_SMA,
                ref_clk: p.PA1,
                mdio: p.PA2,
                crs: p.PA7,
                tx_d1: p.PB13,
                mdc: p.PC1,
                rx_d0: p.PC4,
                rx_d1: p.PC5,
                tx_en: p.PG11,
                tx_d0: p.PG13,
            },
            #[cfg(not(feature = "ethercat"))]
            sensor: sensor_link::Pins {
                fdcan: p.FDCAN1,
                rx: p.PD0,
                tx: p.PD1,
            },
            #[cfg(feature = "ethercat")]
            sensor: sensor_link::Pins {
                spi: p.SPI1,
                sck: p.PA5,
                mosi: p.PB5,
                miso: p.PA6,
                tx: p.DMA1_CH0,
                rx: p.DMA1_CH1,
                select: p.PD14,
                interrupt: p.PD15,
                exti: p.EXTI15,
                reset: p.PF12,
            },
            leds: leds::Pins {
                green: p.PB0,
                yellow: p.PE1,
                red: p.PB14,
            },
            serial: serial::Pins {
                usart: p.USART3,
                rx: p.PD9,
                tx: p.PD8,
            },
        }
    }
}
