//! Clocks: 480 MHz from the 8 MHz that the ST-Link supplies.

use cortex_m::peripheral::DWT;
use embassy_stm32::pac::RCC;
use embassy_stm32::rcc::mux::{Fdcansel, Usart234578sel};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk,
    VoltageScale,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peripherals};

/// Longest wait for the ST-Link's clock, in cycles of the internal oscillator that the chip starts with (64 MHz): 0.1 s.
const PATIENCE: u32 = 6_400_000;

/// Starts the clocks and the time driver. Without the ST-Link's clock it logs an error and waits for the watchdog, which
/// resets the board until the clock is there.
pub(crate) fn start() -> Peripherals {
    if !has_input() {
        defmt::error!(
            "no clock of 8 MHz from the ST-Link: is it supplied, through CN1? Starting over until it comes"
        );
    }
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = Some(Hse {
        freq: Hertz::mhz(8),
        mode: HseMode::Bypass,
    });
    rcc.hsi = None;
    // 8 MHz / 1 × 120 = 960 MHz: the processor gets half of it, FDCAN 80 MHz.
    rcc.pll1 = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV1,
        mul: PllMul::MUL120,
        divp: Some(PllDiv::DIV2),
        divq: Some(PllDiv::DIV12),
        divr: None,
        fracn: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV2;
    rcc.apb1_pre = APBPrescaler::DIV2;
    rcc.apb2_pre = APBPrescaler::DIV2;
    rcc.apb3_pre = APBPrescaler::DIV2;
    rcc.apb4_pre = APBPrescaler::DIV2;
    rcc.voltage_scale = VoltageScale::Scale0;
    rcc.mux.fdcansel = Fdcansel::PLL1_Q;
    rcc.mux.usart234578sel = Usart234578sel::PCLK1;
    embassy_stm32::init(config)
}

/// Whether the clock input has a signal.
fn has_input() -> bool {
    RCC.cr().modify(|w| w.set_hsebyp(true));
    RCC.cr().modify(|w| w.set_hseon(true));
    let begun = DWT::cycle_count();
    while !RCC.cr().read().hserdy() {
        if DWT::cycle_count().wrapping_sub(begun) > PATIENCE {
            return false;
        }
    }
    true
}
