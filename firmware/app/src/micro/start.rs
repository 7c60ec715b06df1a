//! Assembles network, control cycle and telemetry of a microcontroller, and spawns tasks.

use super::SHARED;
use super::identity::Identity;
use super::stamped::Stamped;
use super::telemetry::{self, Queue, encoder_task, transmitter_task};
use super::udp::{UdpPort, static_address};
use crate::auto_start::AutoStart;
use crate::meter::Meter;
use crate::robot_link::{Prepared, RobotLink};
use crate::settings::BoardSettings;
use embassy_executor::{SendSpawner, SpawnError, SpawnToken, Spawner};
use embassy_net::driver::Driver;
use embassy_net::{Runner, StackResources};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use softdock_control::scalar::Scalar;
use static_cell::StaticCell;

/// Sockets of the network stack: the robot's and the telemetry's.
const SOCKETS: usize = 2;
/// Seed of the network stack. Only ports that are given by settings are used, so nothing has to be
/// random.
const SEED: u64 = 0;

/// Spawners of a board's three executors, highest priority first: the control cycle interrupts
/// everything that is not needed for it, and everything interrupts the service.
#[derive(Clone, Copy)]
pub struct Spawners {
    /// Network, sensor and robot.
    pub control: SendSpawner,
    /// Everything that may wait for the control cycle.
    pub background: SendSpawner,
    /// The parameter service, which formats texts and writes flash.
    pub service: SendSpawner,
}

/// Options that differ between boards and between starts.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Identity of the firmware.
    pub identity: &'static Identity,
    /// Arm and start without a person.
    pub auto_start: bool,
    /// A number that differs from start to start.
    pub boot: u32,
}

/// The robot task of a microcontroller.
pub type RobotTask<S> = crate::robot::RobotTask<'static, CriticalSectionRawMutex, S>;

/// Memory of the robot task.
pub type RobotCell<S> = StaticCell<RobotTask<S>>;

/// Builds the robot task in its memory; `None` if called more than once or if the settings may not be used. With its law it takes
/// 24 kB, and building it twice as much stack: to be called at boot, while nothing else is on the stack.
#[inline(never)]
pub fn build_robot<S: Scalar>(
    settings: &BoardSettings,
    options: Options,
    cell: &'static RobotCell<S>,
) -> Option<&'static mut RobotTask<S>> {
    let prepared = Prepared::new(settings).ok()?;
    cell.try_init_with(|| RobotTask {
        shared: &SHARED,
        link: RobotLink::new(prepared),
        auto_start: AutoStart::new(options.auto_start),
        sample_wait_us: settings.sample_wait_us(),
        meter: Meter::default(),
    })
}

/// The network's task of a board whose driver is `D`.
pub type NetworkRunner<D> = Runner<'static, Stamped<D>>;

/// What the robot task runs on: its socket, and its end of the telemetry if there is a recorder.
pub type Io = (UdpPort, Option<Queue>);

/// Assembles what the settings ask for on a network driver, and spawns the telemetry's tasks if there is a recorder; once. The
/// caller, a task of the control executor (`spawner`), spawns the rest. `None` if the settings may not be used.
pub fn assemble<D: Driver>(
    settings: &BoardSettings,
    driver: D,
    options: Options,
    spawner: &Spawner,
    background: SendSpawner,
) -> Option<(NetworkRunner<D>, Io)> {
    static RESOURCES: StaticCell<StackResources<SOCKETS>> = StaticCell::new();
    let network = settings.network.build().ok()?;
    let resources = RESOURCES.try_init_with(StackResources::new)?;
    let driver = Stamped::new(driver, network.rsi_port);
    let (stack, runner) = embassy_net::new(driver, static_address(&network), resources, SEED);
    let port = UdpPort::bind(stack, network.rsi_port)?;
    let telemetry = network.recorder.and_then(|recorder| {
        let port = network.rsi_port.wrapping_add(1);
        telemetry::prepare(
            stack,
            port,
            recorder,
            settings,
            (options.identity, options.boot),
        )
    });
    let queue = telemetry.map(|(queue, encoder, transmitter)| {
        send(background, encoder_task(encoder));
        spawn(spawner, transmitter_task(transmitter));
        queue
    });
    Some((runner, (port, queue)))
}

/// Spawns a task of this executor. There is one of each, so there is room.
pub fn spawn<S>(spawner: &Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(token) => spawner.spawn(token),
        Err(_) => defmt::error!("a task was started twice"),
    }
}

/// Spawns a task of another executor.
pub fn send<S: Send>(spawner: SendSpawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(token) => spawner.spawn(token),
        Err(_) => defmt::error!("a task was started twice"),
    }
}
