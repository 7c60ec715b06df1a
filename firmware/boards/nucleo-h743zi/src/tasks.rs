//! The firmware's tasks on this board's devices.

use crate::IDENTITY;
use crate::can::Bus;
use crate::ethernet::{self, Driver, Pins};
use crate::executors;
use crate::flash::Slots;
use crate::lamps::{self, Leds};
use crate::line;
use crate::watchdog;
use cortex_m::peripheral::SCB;
use embassy_executor::SendSpawner;
use embassy_net::{Runner, StackResources};
use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG1;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use softdock_app::micro::boot;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::service::{self, Prepared};
use softdock_app::micro::start::{Given, assemble, send, spawn};
use softdock_app::micro::telemetry::{Encoder, Queue, Transmitter};
use softdock_app::micro::udp::{UDP_BYTES, UdpMetadataQueues, UdpPort, UdpQueues, static_address};
use softdock_app::micro::watch;
use softdock_app::robot::RobotTask;
use softdock_app::sensor;
use softdock_app::settings::BoardSettings;
use static_cell::{ConstStaticCell, StaticCell};

/// State that tasks of all priorities share.
pub(crate) type Shared = softdock_app::shared::Shared<CriticalSectionRawMutex>;

static SHARED: Shared = Shared::new();

/// Sockets of the network stack.
const SOCKETS: usize = 2;
/// Only ports that are given by settings are used, so nothing has to be random.
const SEED: u64 = 0;

type Robot = RobotTask<'static, CriticalSectionRawMutex, f64>;

/// Starts network, sensor, robot and telemetry, of which the encoder has the lower executor. `boot`
/// differs from boot to boot.
pub(crate) fn start_high(
    (high, low): (SendSpawner, SendSpawner),
    settings: BoardSettings,
    pins: Pins,
    bus: Bus,
    boot: u32,
) {
    send(high, start(settings, pins, bus, boot, low));
}

/// Starts log, lamps and watchdog.
pub(crate) fn start_low(spawner: SendSpawner, leds: Leds, iwdg: Peri<'static, IWDG1>) {
    send(spawner, watch());
    send(spawner, lamps::show(&SHARED, leds));
    send(spawner, watchdog::feed(&SHARED, iwdg));
}

/// Starts the parameter service.
pub(crate) fn start_service(spawner: SendSpawner, prepared: Prepared<Slots>, pins: line::Pins) {
    send(spawner, serve(prepared, pins));
}

#[embassy_executor::task]
async fn start(settings: BoardSettings, pins: Pins, bus: Bus, boot: u32, low: SendSpawner) {
    static RESOURCES: StaticCell<StackResources<SOCKETS>> = StaticCell::new();
    static METADATA: StaticCell<UdpMetadataQueues> = StaticCell::new();
    static DATAGRAMS: ConstStaticCell<[u8; UDP_BYTES]> = ConstStaticCell::new([0; UDP_BYTES]);
    let spawner = executors::local().await;
    spawn(&spawner, watchdog::beat());

    let Ok(network) = settings.network.build() else {
        return boot::report_unusable();
    };
    let ethernet = ethernet::start(pins);
    let resources = RESOURCES.init_with(StackResources::new);
    let (stack, runner) = embassy_net::new(ethernet, static_address(&network), resources, SEED);
    let given = Given {
        shared: &SHARED,
        queues: UdpQueues {
            metadata: METADATA.init_with(UdpMetadataQueues::new),
            bytes: DATAGRAMS.take(),
        },
        // A real robot is started by a person.
        auto_start: false,
        identity: &IDENTITY,
        boot,
    };
    let Some(assembly) = assemble::<f64>(stack, &network, &settings, given) else {
        return boot::report_unusable();
    };
    let queue = assembly.telemetry.map(|(queue, encoder, transmitter)| {
        send(low, encoder_task(encoder));
        spawn(&spawner, transmitter_task(transmitter));
        queue
    });
    spawn(&spawner, network_task(runner));
    spawn(&spawner, sensor_task(settings, bus));
    spawn(&spawner, robot_task(assembly.robot, assembly.port, queue));
    boot::report_ready();
}

/// Runs the parameter service until the board is to start over.
#[embassy_executor::task]
async fn serve(prepared: Prepared<Slots>, pins: line::Pins) {
    let Ok((reader, writer)) = line::open(pins) else {
        defmt::error!("the serial line cannot be opened: no parameter service");
        return;
    };
    let trial = service::serve(prepared, &SHARED, reader, writer).await;
    if let Some(trial) = trial {
        softdock_crash::retain(trial.encode());
    }
    SCB::sys_reset();
}

#[embassy_executor::task]
async fn network_task(mut runner: Runner<'static, Driver>) -> ! {
    runner.run().await
}

#[embassy_executor::task]
async fn sensor_task(settings: BoardSettings, mut bus: Bus) {
    sensor::run(&SHARED, &mut bus, &UptimeClock, settings.can.driver()).await;
}

#[embassy_executor::task]
async fn robot_task(task: Robot, mut port: UdpPort<'static>, mut queue: Option<Queue>) {
    task.run(&mut port, &UptimeClock, &mut queue).await;
}

#[embassy_executor::task]
async fn transmitter_task(transmitter: Transmitter) {
    transmitter.run().await;
}

#[embassy_executor::task]
async fn encoder_task(encoder: Encoder) {
    encoder.run().await;
}

/// Logs what changes.
#[embassy_executor::task]
async fn watch() -> ! {
    watch::run(&SHARED, &UptimeClock).await
}
