//! The firmware's tasks on this board's devices.

use crate::IDENTITY;
use crate::can::Bus;
use crate::ethernet::{self, Driver, Pins};
use crate::executors;
use crate::lamps::{self, Leds};
use crate::watchdog;
use embassy_executor::{SendSpawner, SpawnError, SpawnToken, Spawner};
use embassy_net::{Runner, StackResources};
use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG1;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use softdock_app::auto_start::AutoStart;
use softdock_app::micro::boot;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::telemetry::{self, Encoder, Queue, Transmitter};
use softdock_app::micro::udp::{UdpBuffers, UdpPort, static_address};
use softdock_app::micro::watch;
use softdock_app::robot::RobotTask;
use softdock_app::robot_link::RobotLink;
use softdock_app::sensor;
use softdock_app::settings::BoardSettings;
use static_cell::{ConstStaticCell, StaticCell};

/// State that tasks of both priorities share.
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

#[embassy_executor::task]
async fn start(settings: BoardSettings, pins: Pins, bus: Bus, boot: u32, low: SendSpawner) {
    static RESOURCES: StaticCell<StackResources<SOCKETS>> = StaticCell::new();
    static BUFFERS: ConstStaticCell<UdpBuffers> = ConstStaticCell::new(UdpBuffers::new());
    let spawner = executors::local().await;
    spawn(&spawner, watchdog::beat());

    let Ok(network) = settings.network.build() else {
        return boot::report_unusable();
    };
    let ethernet = ethernet::start(pins);
    let resources = RESOURCES.init_with(StackResources::new);
    let (stack, runner) = embassy_net::new(ethernet, static_address(&network), resources, SEED);
    let port = UdpPort::bind(stack, network.rsi_port, BUFFERS.take());
    let link = RobotLink::new(&settings);
    let (Ok(port), Ok(link)) = (port, link) else {
        return boot::report_unusable();
    };
    let robot = RobotTask {
        shared: &SHARED,
        link,
        // A real robot is started by a person.
        auto_start: AutoStart::new(false),
        sample_wait_us: settings.can.sample_wait_us(),
    };
    let telemetry = network.recorder.and_then(|recorder| {
        let port = network.rsi_port.wrapping_add(1);
        telemetry::prepare(stack, port, recorder, &settings, &IDENTITY, boot)
    });
    let queue = telemetry.map(|(queue, encoder, transmitter)| {
        send(low, encoder_task(encoder));
        spawn(&spawner, transmitter_task(transmitter));
        queue
    });
    spawn(&spawner, network_task(runner));
    spawn(&spawner, sensor_task(settings, bus));
    spawn(&spawner, robot_task(robot, port, queue));
    boot::report_ready();
}

/// Spawns a task of this executor. There is one of each, so there is room.
fn spawn<S>(spawner: &Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(token) => spawner.spawn(token),
        Err(_) => defmt::error!("a task was started twice"),
    }
}

/// Spawns a task of another executor.
fn send<S: Send>(spawner: SendSpawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(token) => spawner.spawn(token),
        Err(_) => defmt::error!("a task was started twice"),
    }
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
