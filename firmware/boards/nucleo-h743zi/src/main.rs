//! The docking-rig controller on a NUCLEO-H743ZI2.
//!
//! | what | where | file |
//! |---|---|---|
//! | sensor | FDCAN1, PD0 (RX) and PD1 (TX), through a transceiver, 1 Mbit/s | [`can`] |
//! | robot, recorder | Ethernet (CN14), static address from the settings | [`ethernet`] |
//! | log | defmt over RTT, through the ST-Link (CN1) | |
//! | lamps | LD1 green, LD2 yellow, LD3 red | [`lamps`] |
//! | settings | two slots in the last sectors of flash | [`settings`] |
//! | watchdog | IWDG, fed by completed work | [`watchdog`] |
//!
//! Network, sensor and robot have the upper executor; log, lamps and watchdog the lower one. Between
//! interrupts the processor sleeps. Nothing allocates.
#![no_std]
#![no_main]

mod can;
mod clocks;
mod ethernet;
mod executors;
mod lamps;
mod settings;
mod tasks;
mod watchdog;

use cortex_m::peripheral::SCB;
use defmt_rtt as _;
use embassy_stm32::peripherals::RNG;
use embassy_stm32::rng::{self, Rng};
use embassy_stm32::{Peri, bind_interrupts};
use lamps::Leds;
use softdock_app::image::Image;
use softdock_app::micro::boot::{self, Identity};

bind_interrupts!(struct Irqs {
    RNG => rng::InterruptHandler<RNG>;
});

const IDENTITY: Identity = Identity {
    version: env!("CARGO_PKG_VERSION"),
    git: env!("SOFTDOCK_GIT"),
    board: "NUCLEO-H743ZI2",
};

#[cortex_m_rt::entry]
fn main() -> ! {
    let Some(mut core) = cortex_m::Peripherals::take() else {
        // Only a second call of `main` could get here.
        SCB::sys_reset();
    };
    softdock_crash::arm(&mut core.SCB, &mut core.MPU);
    let p = clocks::start(&mut core.SCB);
    boot::report_identity(&IDENTITY);
    boot::report_crash(softdock_crash::take_message().as_deref());

    let (origin, settings) = match settings::read(p.FLASH) {
        Ok((Image { sequence, settings }, _)) => (Ok(sequence), settings),
        Err(error) => (Err(error), Default::default()),
    };
    boot::report_settings(&origin, &settings);
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
    let (high, low) = (executors::start_high(), executors::start_low());
    tasks::start_high((high, low), settings, pins, bus, boot_number(p.RNG));
    tasks::start_low(low, leds, p.IWDG1);
    loop {
        cortex_m::asm::wfi();
    }
}

/// A number that differs from boot to boot.
fn boot_number(rng: Peri<'static, RNG>) -> u32 {
    Rng::new(rng, Irqs).next_u32()
}
