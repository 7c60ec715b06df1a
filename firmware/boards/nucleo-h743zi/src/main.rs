//! The docking-rig controller on a NUCLEO-H743ZI2.
//!
//! | what | where | file |
//! |---|---|---|
//! | sensor | FDCAN1, PD0 (RX) and PD1 (TX), through a transceiver, 1 Mbit/s | [`can`] |
//! | robot, recorder | Ethernet (CN14), static address from the settings | [`ethernet`] |
//! | log | defmt over RTT, through the ST-Link (CN1) | |
//! | lamps | LD1 green, LD2 yellow, LD3 red | [`lamps`] |
//! | parameter service | USART3, through the ST-Link (CN1), 115,200 bit/s | [`line`] |
//! | settings | two slots in the last sectors of flash | [`flash`] |
//! | watchdog | IWDG, fed by completed work | [`watchdog`] |
//!
//! Network, sensor and robot have the upper executor; log, lamps and watchdog the lower one; the
//! service the lowest. Between interrupts the processor sleeps. Nothing allocates.
#![no_std]
#![no_main]

mod can;
mod clocks;
mod ethernet;
mod executors;
mod flash;
mod lamps;
mod line;
mod tasks;
mod watchdog;

use cortex_m::peripheral::SCB;
use defmt_rtt as _;
use embassy_stm32::peripherals::RNG;
use embassy_stm32::rng::{self, Rng};
use embassy_stm32::{Peri, bind_interrupts};
use lamps::Leds;
use softdock_app::micro::boot::{self, Identity};
use softdock_app::micro::service;
use softdock_app::processor::Processor;
use softdock_app::store::{Store, Trial};
use static_cell::StaticCell;

static STORE: StaticCell<Store<flash::Slots>> = StaticCell::new();

bind_interrupts!(struct Irqs {
    RNG => rng::InterruptHandler<RNG>;
});

const IDENTITY: Identity = Identity {
    version: env!("CARGO_PKG_VERSION"),
    git: env!("SOFTDOCK_GIT"),
    board: "NUCLEO-H743ZI2",
    processor: Processor::DoublePrecision,
};

#[cortex_m_rt::entry]
fn main() -> ! {
    start();
    loop {
        cortex_m::asm::wfi();
    }
}

/// Starts everything. Its stack is free again when it returns, which that of `main` never is.
#[inline(never)]
fn start() {
    let Some(mut core) = cortex_m::Peripherals::take() else {
        // Only a second call of `main` could get here.
        SCB::sys_reset();
    };
    softdock_crash::arm(&mut core.SCB, &mut core.MPU);
    let p = clocks::start(&mut core.SCB);
    boot::report_identity(&IDENTITY);
    let crash = softdock_crash::take_message();
    boot::report_crash(crash.as_deref());

    let number = boot_number(p.RNG);
    let trial = Trial::decode(&softdock_crash::take_retained());
    let store = STORE.init_with(|| Store::new(flash::Slots::new(p.FLASH)));
    let prepared = service::prepare(store, trial, number, &IDENTITY, crash.as_deref());
    let Some((start, prepared)) = prepared else {
        SCB::sys_reset();
    };
    boot::report_settings(&start, IDENTITY.processor);
    let pins = ethernet::Pins {
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
    };
    let bus = can::Bus::start(p.FDCAN1, p.PD0, p.PD1);
    let leds = Leds::new(p.PB0, p.PE1, p.PB14);
    let line = line::Pins {
        usart: p.USART3,
        rx: p.PD9,
        tx: p.PD8,
    };
    let (high, low) = (executors::start_high(), executors::start_low());
    tasks::start_high((high, low), start.settings, pins, bus, number);
    tasks::start_low(low, leds, p.IWDG1);
    tasks::start_service(executors::start_service(), prepared, line);
}

/// A number that differs from boot to boot.
fn boot_number(rng: Peri<'static, RNG>) -> u32 {
    Rng::new(rng, Irqs).next_u32()
}
