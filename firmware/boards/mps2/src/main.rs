//! The docking-rig controller on Arm's MPS2 board as QEMU emulates it: the same tasks as on the
//! real board, on devices of which each has a file here.
//!
//! | device | use | file |
//! |---|---|---|
//! | LAN9118 | RSI, UDP | [`lan9118`] |
//! | UART 0 | the sensor's CAN bus as SLCAN | [`uart`] |
//! | UART 1 | the log, defmt | [`logger`] |
//! | UART 2 | the service | [`uart`] |
//! | PSRAM | the flash with settings and boot options | [`flash`] |
//! | counter, timer 0 | time | [`time`] |
//!
//! `cargo qemu` builds and runs it. [`chip`] says in what the two chips differ.
#![no_std]
#![no_main]

mod chip;
mod executors;
mod flash;
mod interrupts;
mod lan9118;
mod logger;
mod register;
mod tasks;
mod time;
mod uart;

use cortex_m::Peripherals;
use cortex_m::peripheral::SCB;
use softdock_app::image::Image;
use softdock_app::micro::boot::{self, Identity};

const IDENTITY: Identity = Identity {
    version: env!("CARGO_PKG_VERSION"),
    git: env!("SOFTDOCK_GIT"),
    board: chip::NAME,
};

#[cortex_m_rt::entry]
fn main() -> ! {
    let Some(mut core) = Peripherals::take() else {
        // Only a second call of `main` could get here.
        SCB::sys_reset();
    };
    softdock_crash::arm(&mut core.SCB, &mut core.MPU);
    interrupts::set_priorities(&mut core.NVIC);
    time::start();
    let _ = uart::LOG.open();
    boot::report_identity(&IDENTITY);
    boot::report_crash(softdock_crash::take_message().as_deref());

    let (origin, settings) = match flash::settings() {
        Ok(Image { sequence, settings }) => (Ok(sequence), settings),
        Err(error) => (Err(error), Default::default()),
    };
    boot::report_settings(&origin, &settings);
    // The halves of the line belong to the task of the service's protocol.
    let _ = uart::SERVICE.open();
    let (high, low) = (executors::start_high(), executors::start_low());
    if let Ok(start) = tasks::start(settings, flash::boot_options(), low) {
        high.spawn(start);
    }
    if let Ok(watch) = tasks::watch() {
        low.spawn(watch);
    }
    loop {
        cortex_m::asm::wfi();
    }
}
