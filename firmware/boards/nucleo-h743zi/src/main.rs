//! The docking-rig controller on a NUCLEO-H743ZI2.
//!
//! | what | where | file |
//! |---|---|---|
//! | sensor | FDCAN1, PD0 (RX) and PD1 (TX), through a transceiver, 1 Mbit/s | [`can`] |
//! | robot, recorder | Ethernet (CN14), static address from the settings | [`ethernet`] |
//! | with the feature `ethercat` | sensor on the Ethernet, robot and recorder on a W5500 | [`sensor_link`] |
//! | log | defmt over RTT, through the ST-Link (CN1) | |
//! | LEDs | LD1 green, LD2 yellow, LD3 red | [`leds`] |
//! | parameter service | USART3, through the ST-Link (CN1), 115,200 bit/s | [`serial`] |
//! | settings | two slots in the last sectors of flash | [`flash`] |
//! | watchdog | IWDG, fed by completed work | [`watchdog`] |
//! | peripherals and pins | by their use | [`hardware`] |
//! | caches | both on, except for memory that other devices access | [`memory`] |
//!
//! Network, sensor and robot have the executor of highest priority; log, LEDs and watchdog the next;
//! the service the lowest. Between interrupts the processor sleeps. Nothing allocates.
#![no_std]
#![no_main]

#[cfg(not(feature = "ethercat"))]
mod can;
#[cfg(not(feature = "ethercat"))]
mod can_fifo;
mod clocks;
mod ethernet;
mod executors;
mod flash;
mod hardware;
mod leds;
mod memory;
mod reset;
#[cfg_attr(feature = "ethercat", path = "sensor_ethercat.rs")]
#[cfg_attr(not(feature = "ethercat"), path = "sensor_can.rs")]
mod sensor_link;
mod serial;
#[cfg(feature = "ethercat")]
mod w5500;
mod watchdog;

use cortex_m::peripheral::{DWT, SCB};
use defmt_rtt as _;
use embassy_executor::SendSpawner;
use embassy_stm32::peripherals::RNG;
use embassy_stm32::rng::{self, Rng};
use embassy_stm32::{Peri, bind_interrupts};
use flash::Sectors;
use hardware::Hardware;
use leds::Leds;
use softdock_app::micro::boot::{self, Before};
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::identity::Identity;
use softdock_app::micro::monitor::monitor;
use softdock_app::micro::service::{self, Prepared};
use softdock_app::micro::start::{
    NetworkRunner, Options, RobotCell, RobotTask, assemble, build_robot, send, spawn,
};
use softdock_app::micro::telemetry::Queue;
use softdock_app::micro::udp::UdpPort;
use softdock_app::processor::Processor;
use softdock_app::settings::BoardSettings;
use softdock_app::store::{Store, WordFlash};
use static_cell::StaticCell;

type Flash = WordFlash<Sectors>;

static STORE: StaticCell<Store<Flash>> = StaticCell::new();
static ROBOT: RobotCell<f64> = StaticCell::new();

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
    // The executors begin after the start has freed its stack.
    cortex_m::interrupt::free(|_| start());
    loop {
        cortex_m::asm::wfi();
    }
}

/// Starts everything, with interrupts off; uses much of the stack.
#[inline(never)]
fn start() {
    let Some(mut core) = cortex_m::Peripherals::take() else {
        // Only a second call of `main` could get here.
        SCB::sys_reset();
    };
    prepare_core(&mut core);
    watchdog::guard_start();
    let hardware = Hardware::new(clocks::start());
    let watchdog = watchdog::start(hardware.watchdog);
    let crash = softdock_crash::take_message();
    let before = Before {
        crash: crash.as_deref(),
        retained: softdock_crash::take_retained(),
        reset: reset::reason(),
    };
    let number = boot_number(hardware.random);
    let store = STORE.init_with(|| Store::new(WordFlash::new(Sectors::new(hardware.flash))));
    let Some((start, prepared)) = boot::boot(&IDENTITY, store, before, number) else {
        SCB::sys_reset();
    };
    let options = Options {
        identity: &IDENTITY,
        // A real robot is started by a person.
        auto_start: false,
        boot: number,
    };
    let (ethernet, sensor) = (hardware.ethernet, sensor_link::prepare(hardware.sensor));
    let leds = Leds::new(hardware.leds);
    let robot = build_robot(&start.settings, options, &ROBOT);
    let spawners = executors::start();
    let background = spawners.background;
    let control = control(start.settings, options, robot, ethernet, sensor, background);
    send(spawners.control, control);
    send(background, monitor());
    send(background, leds::show(leds));
    send(background, watchdog::feed(watchdog));
    send(spawners.service, serve(prepared, hardware.serial));
}

/// Starts the memory guards, the caches and the cycle counter.
fn prepare_core(core: &mut cortex_m::Peripherals) {
    softdock_crash::arm(&mut core.SCB, &mut core.MPU);
    memory::start_caches(core);
    core.DCB.enable_trace();
    DWT::unlock();
    core.DWT.enable_cycle_counter();
}

/// A number that differs from boot to boot.
fn boot_number(rng: Peri<'static, RNG>) -> u32 {
    Rng::new(rng, Irqs).next_u32()
}

/// Starts network, sensor and robot on its own executor.
#[embassy_executor::task]
async fn control(
    settings: BoardSettings,
    options: Options,
    robot: Option<&'static mut RobotTask<f64>>,
    pins: ethernet::Pins,
    sensor: sensor_link::Hardware,
    background: SendSpawner,
) {
    let spawner = executors::local().await;
    spawn(&spawner, watchdog::beat());
    let ethernet = ethernet::start(pins);
    spawn(&spawner, ethernet::watch());
    let Some(network) = sensor_link::start(&spawner, &settings, ethernet, sensor).await else {
        return boot::report_unusable();
    };
    let assembled = assemble(&settings, network, options, &spawner, background);
    let (Some((network, (port, queue))), Some(robot)) = (assembled, robot) else {
        return boot::report_unusable();
    };
    spawn(&spawner, network_task(network));
    spawn(&spawner, robot_task(robot, port, queue));
    boot::report_ready();
}

#[embassy_executor::task]
async fn network_task(mut network: NetworkRunner<sensor_link::Network>) -> ! {
    network.run().await
}

#[embassy_executor::task]
async fn robot_task(
    robot: &'static mut RobotTask<f64>,
    mut port: UdpPort,
    mut queue: Option<Queue>,
) {
    robot.run(&mut port, &UptimeClock, &mut queue).await;
}

/// Runs the parameter service until it asks for a restart.
#[embassy_executor::task]
async fn serve(prepared: Prepared<Flash>, pins: serial::Pins) {
    let Ok((reader, writer)) = serial::open(pins) else {
        defmt::error!("the serial port cannot be opened: no parameter service");
        return;
    };
    let trial = service::serve(prepared, reader, writer, softdock_crash::hang).await;
    softdock_crash::restart(trial.map(|trial| trial.encode()));
}
