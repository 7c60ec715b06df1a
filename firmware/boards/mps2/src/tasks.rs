//! The firmware's tasks on this board's devices.

use crate::IDENTITY;
use crate::chip::Number;
use crate::executors;
use crate::flash::Slots;
use crate::lan9118::Lan9118;
use crate::uart::{self, UartReader, UartWriter};
use cortex_m::peripheral::SCB;
use embassy_executor::SendSpawner;
use embassy_net::{Runner, StackResources};
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
use softdock_app::slcan_bus::SlcanBus;
use static_cell::{ConstStaticCell, StaticCell};

/// State that tasks of all priorities share.
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

/// Starts network, sensor and robot on the executor that it runs on. `boot` differs from start to
/// start.
#[embassy_executor::task]
pub(crate) async fn start(settings: BoardSettings, auto_start: bool, boot: u32, low: SendSpawner) {
    static RESOURCES: StaticCell<Sockets> = StaticCell::new();
    static METADATA: StaticCell<UdpMetadataQueues> = StaticCell::new();
    static DATAGRAMS: ConstStaticCell<[u8; UDP_BYTES]> = ConstStaticCell::new([0; UDP_BYTES]);
    let spawner = executors::local().await;

    let Ok(network) = settings.network.build() else {
        return boot::report_unusable();
    };
    let ethernet = Lan9118::start(HARDWARE_ADDRESS);
    let resources = RESOURCES.init_with(StackResources::new);
    let (stack, runner) = embassy_net::new(ethernet, static_address(&network), resources, SEED);
    let given = Given {
        shared: &SHARED,
        queues: UdpQueues {
            metadata: METADATA.init_with(UdpMetadataQueues::new),
            bytes: DATAGRAMS.take(),
        },
        auto_start,
        identity: &IDENTITY,
        boot,
    };
    let Some(assembly) = assemble::<Number>(stack, &network, &settings, given) else {
        return boot::report_unusable();
    };
    let (reader, writer) = uart::CAN.open();
    let bus = SlcanBus::new(reader, writer);
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
pub(crate) async fn serve(prepared: Prepared<Slots>) {
    let (reader, writer) = uart::SERVICE.open();
    let trial = service::serve(prepared, &SHARED, reader, writer).await;
    if let Some(trial) = trial {
        softdock_crash::retain(trial.encode());
    }
    SCB::sys_reset();
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
