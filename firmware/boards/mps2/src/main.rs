//! The docking-rig controller on Arm's MPS2 board as QEMU emulates it: the same tasks as on the
//! real board, on devices of which each has a file here.
//!
//! | device | use | file |
//! |---|---|---|
//! | LAN9118 | RSI, UDP | [`lan9118`] |
//! | UART 0 | the sensor's CAN bus as SLCAN | [`uart`] |
//! | UART 1 | the log, defmt | [`logger`] |
//! | UART 2 | the parameter service | [`uart`] |
//! | PSRAM | the flash with settings and boot options | [`flash`] |
//! | counter, timer 0 | time | [`time`] |
//!
//! `cargo qemu` builds and runs it. [`chip`] says in what the two chips differ.
#![no_std]
#![no_main]

mod chip;
mod crash;
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
use softdock_app::micro::boot::{self, Identity};
use softdock_app::micro::service;
use softdock_app::micro::start::send;
use softdock_app::store::{Origin, Store, Trial};
use static_cell::StaticCell;

static STORE: StaticCell<Store<flash::Slots>> = StaticCell::new();

const IDENTITY: Identity = Identity {
    version: env!("CARGO_PKG_VERSION"),
    git: env!("SOFTDOCK_GIT"),
    board: chip::NAME,
    processor: chip::PROCESSOR,
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
    let Some(mut core) = Peripherals::take() else {
        // Only a second call of `main` could get here.
        SCB::sys_reset();
    };
    softdock_crash::arm(&mut core.SCB, &mut core.MPU);
    interrupts::set_priorities(&mut core.NVIC);
    time::start();
    let _ = uart::LOG.open();
    boot::report_identity(&IDENTITY);
    let crash = softdock_crash::take_message();
    boot::report_crash(crash.as_deref());

    let options = flash::boot_options();
    if let Some(kind) = options.crash.filter(|_| crash.is_none()) {
        crash::crash(kind);
    }
    // The launcher's number is that of all starts of this launch.
    let number = options.boot.wrapping_add(softdock_crash::count_start());
    let trial = Trial::decode(&softdock_crash::take_retained());
    let store = STORE.init_with(|| Store::new(flash::Slots::new()));
    let prepared = service::prepare(store, trial, number, &IDENTITY, crash.as_deref());
    let Some((start, prepared)) = prepared else {
        SCB::sys_reset();
    };
    boot::report_settings(&start, IDENTITY.processor);
    let (high, low) = (executors::start_high(), executors::start_low());
    let keeps_up = IDENTITY.processor.accepts(&start.settings).is_ok();
    let auto_start = options.start && keeps_up && !matches!(start.origin, Origin::Defaults(_));
    send(high, tasks::start(start.settings, auto_start, number, low));
    send(low, tasks::watch());
    send(executors::start_service(), tasks::serve(prepared));
}
