//! The firmware's tasks on this board's devices.

use crate::IDENTITY;
use crate::chip::Number;
use crate::executors;
use crate::lan9118::Lan9118;
use crate::uart::{self, UartReader, UartWriter};
use embassy_executor::{SendSpawner, SpawnError, SpawnToken, Spawner};
use embassy_net::{Runner, StackResources};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use softdock_app::auto_start::AutoStart;
use softdock_app::emulated_flash::BootOptions;
use softdock_app::micro::boot;
use softdock_app::micro::clock::UptimeClock;
use softdock_app::micro::telemetry::{self, Encoder, Queue, Transmitter};
use softdock_app::micro::udp::{UdpBuffers, UdpPort, static_address};
use softdock_app::micro::watch;
use softdock_app::robot::RobotTask;
use softdock_app::robot_link::RobotLink;
use softdock_app::sensor;
use softdock_app::settings::BoardSettings;
use softdock_app::slcan_bus::SlcanBus;
use static_cell::StaticCell;

/// State that tasks of both priorities share.
type Shared = softdock_app::shared::Shared<CriticalSectionRawMutex>;

static SHARED: Shared = Shared::new();

/// Sockets of the network stack.
const SOCKETS: usize = 2;
/// Locally administered; QEMU's network is private to the board.
const HARDWARE_ADDRESS: [u8; 6] = [0x02, 0x00, 0x00, 0x00, 0x00, 0x01];
/// Only ports that are given by settings are used, so nothing has to be random.
const SEED: u64 = 0;

type Sockets = StackResources<SOCKETS>;
type CanLine = SlcanBus<UartReader, UartWriter>;
type Robot = RobotTask<'static, CriticalSectionRawMutex, Number>;

/// Starts network, sensor and robot on the executor that it runs on.
#[embassy_executor::task]
pub(crate) async fn start(settings: BoardSettings, options: BootOptions, low: SendSpawner) {
    static RESOURCES: StaticCell<Sockets> = StaticCell::new();
    static BUFFERS: StaticCell<UdpBuffers> = StaticCell::new();
    let spawner = executors::local().await;

    let Ok(network) = settings.network.build() else {
        return boot::report_unusable();
    };
    let ethernet = Lan9118::start(HARDWARE_ADDRESS);
    let resources = RESOURCES.init_with(StackResources::new);
    let (stack, runner) = embassy_net::new(ethernet, static_address(&network), resources, SEED);
    let buffers = BUFFERS.init_with(UdpBuffers::new);
    let port = UdpPort::bind(stack, network.rsi_port, buffers);
    let link = RobotLink::new(&settings);
    let (Ok(port), Ok(link)) = (port, link) else {
        return boot::report_unusable();
    };
    let robot = RobotTask {
        shared: &SHARED,
        link,
        auto_start: AutoStart::new(options.start),
        sample_wait_us: settings.can.sample_wait_us(),
    };
    let (reader, writer) = uart::CAN.open();
    let bus = SlcanBus::new(reader, writer);
    let telemetry = network.recorder.and_then(|recorder| {
        let port = network.rsi_port.wrapping_add(1);
        telemetry::prepare(stack, port, recorder, &settings, &IDENTITY, options.boot)
    });
    let queue = telemetry.map(|(queue, encoder, transmitter)| {
        if let Ok(task) = encoder_task(encoder) {
            low.spawn(task);
        }
        spawn(&spawner, transmitter_task(transmitter));
        queue
    });
    spawn(&spawner, network_task(runner));
    spawn(&spawner, sensor_task(settings, bus));
    spawn(&spawner, robot_task(robot, port, queue));
    boot::report_ready();
}

/// Spawns a task. There is one of each, so there is room.
fn spawn<S>(spawner: &Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(token) => spawner.spawn(token),
        Err(_) => defmt::error!("a task was started twice"),
    }
}

#[embassy_executor::task]
async fn network_task(mut runner: Runner<'static, Lan9118>) -> ! {
    runner.run().await
}

#[embassy_executor::task]
async fn sensor_task(settings: BoardSettings, mut bus: CanLine) {
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

/// Logs what changes; for the executor of everything that may wait.
#[embassy_executor::task]
pub(crate) async fn watch() -> ! {
    watch::run(&SHARED, &UptimeClock).await
}
