//! The docking-rig controller on Arm's MPS2 board as emulated by QEMU: the same tasks as on the real board, with a file here
//! for each device.
//!
//! | device | use | file |
//! |---|---|---|
//! | LAN9118 | RSI, UDP | [`lan9118`] |
//! | UART 0 | the sensor's CAN bus as SLCAN | [`uart`] |
//! | LAN9118 | with the feature `ethercat`: the sensor's segment | [`sensor_link`] |
//! | UART 1 | the log, defmt | [`logger`] |
//! | UART 2 | the parameter service | [`uart`] |
//! | PSRAM | the flash with settings and boot options | [`flash`] |
//! | counter, timer 0 | time | [`time`] |
//! | watchdog | ends a deliberate hang | [`watchdog`] |
//!
//! `cargo qemu` builds and runs it. [`chip`] contains the differences between the two chips.
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
#[cfg_attr(feature = "ethercat", path = "sensor_ethercat.rs")]
#[cfg_attr(not(feature = "ethercat"), path = "sensor_can.rs")]
mod sensor_link;
mod time;
mod uart;
mod watchdog;

use chip::Number;
use cortex_m::Peripherals;
use cortex_m::peripheral::SCB;
use embassy_executor::SendSpawner;
use flash::Psram;
use lan9118::Lan9118;
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
use softdock_app::settings::BoardSettings;
use softdock_app::store::{Origin, Store, WordFlash};
use static_cell::StaticCell;

type Flash = WordFlash<Psram>;

static STORE: StaticCell<Store<Flash>> = StaticCell::new();
static ROBOT: RobotCell<Number> = StaticCell::new();

const IDENTITY: Identity = Identity {
    version: env!("CARGO_PKG_VERSION"),
    git: env!("SOFTDOCK_GIT"),
    board: chip::NAME,
    processor: chip::PROCESSOR,
};

/// Locally administered; QEMU's network is private to the board.
const HARDWARE_ADDRESS: [u8; 6] = [0x02, 0x00, 0x00, 0x00, 0x00, 0x01];

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
    let Some(mut core) = Peripherals::take() else {
        // Only a second call of `main` could get here.
        SCB::sys_reset();
    };
    softdock_crash::arm(&mut core.SCB, &mut core.MPU);
    interrupts::set_priorities(&mut core.NVIC);
    time::start();
    let _ = uart::LOG.open();
    let options = flash::boot_options();
    let crash = softdock_crash::take_message();
    if let Some(kind) = options.crash.filter(|_| crash.is_none()) {
        crash::crash(kind);
    }
    let before = Before {
        crash: crash.as_deref(),
        retained: softdock_crash::take_retained(),
        // The emulator has no register with the cause of a reset.
        reset: "unknown",
    };
    // The launcher gives one number per launch; the count tells the starts of a launch apart.
    let starts = softdock_crash::count_start();
    let number = options.boot.wrapping_add(starts);
    let store = STORE.init_with(|| Store::new(WordFlash::new(Psram::new())));
    let Some((start, prepared)) = boot::boot(&IDENTITY, store, before, number) else {
        SCB::sys_reset();
    };
    // The emulator's memory is zero at power-up, so 1 is the first start. After a change of settings or a crash, the robot is
    // started by hand.
    let first = starts == 1;
    let usable = IDENTITY.processor.accepts(&start.settings).is_ok()
        && !matches!(start.origin, Origin::Defaults(_));
    let options = Options {
        identity: &IDENTITY,
        auto_start: options.start && first && usable,
        boot: number,
    };
    let robot = build_robot(&start.settings, options, &ROBOT);
    let spawners = executors::start();
    let control = control(start.settings, options, robot, spawners.background);
    send(spawners.control, control);
    send(spawners.background, monitor());
    send(spawners.service, serve(prepared));
}

/// Starts network, sensor and robot on its own executor.
#[embassy_executor::task]
async fn control(
    settings: BoardSettings,
    options: Options,
    robot: Option<&'static mut RobotTask<Number>>,
    background: SendSpawner,
) {
    let spawner = executors::local().await;
    let ethernet = Lan9118::start(HARDWARE_ADDRESS);
    let network = sensor_link::start(&spawner, &settings, ethernet);
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
    robot: &'static mut RobotTask<Number>,
    mut port: UdpPort,
    mut queue: Option<Queue>,
) {
    robot.run(&mut port, &UptimeClock, &mut queue).await;
}

/// Runs the parameter service until it asks for a restart.
#[embassy_executor::task]
async fn serve(prepared: Prepared<Flash>) {
    let (reader, writer) = uart::SERVICE.open();
    let trial = service::serve(prepared, reader, writer, watchdog::hang).await;
    softdock_crash::restart(trial.map(|trial| trial.encode()));
}
