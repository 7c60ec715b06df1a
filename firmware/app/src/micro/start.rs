//! Puts the control cycle of a microcontroller together, and spawns its tasks.

use super::boot::Identity;
use super::telemetry::{self, Encoder, Queue, Transmitter};
use super::udp::{UdpPort, UdpQueues};
use crate::auto_start::AutoStart;
use crate::robot::RobotTask;
use crate::robot_link::RobotLink;
use crate::settings::{BoardSettings, Network};
use crate::shared::Shared;
use embassy_executor::{SendSpawner, SpawnError, SpawnToken, Spawner};
use embassy_net::Stack;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use softdock_control::scalar::Scalar;

/// The robot task with its socket, and the telemetry if there is a recorder.
pub struct Assembly<S: Scalar> {
    /// The task.
    pub robot: RobotTask<'static, CriticalSectionRawMutex, S>,
    /// Its socket.
    pub port: UdpPort<'static>,
    /// For the robot task, for the executor of what may wait, and for that of the network.
    pub telemetry: Option<(Queue, Encoder, Transmitter)>,
}

/// What differs from board to board and from start to start.
pub struct Given {
    /// State shared with the other tasks.
    pub shared: &'static Shared<CriticalSectionRawMutex>,
    /// Memory of the robot's socket.
    pub queues: UdpQueues,
    /// Arm and start without a person.
    pub auto_start: bool,
    /// Who the firmware is.
    pub identity: &'static Identity,
    /// A number that differs from start to start.
    pub boot: u32,
}

/// Puts together what the settings ask for; none if they may not be used.
pub fn assemble<S: Scalar>(
    stack: Stack<'static>,
    network: &Network,
    settings: &BoardSettings,
    given: Given,
) -> Option<Assembly<S>> {
    let Given {
        shared,
        queues,
        auto_start,
        identity,
        boot,
    } = given;
    let robot = RobotTask {
        shared,
        link: RobotLink::new(settings).ok()?,
        auto_start: AutoStart::new(auto_start),
        sample_wait_us: settings.can.sample_wait_us(),
    };
    let telemetry = network.recorder.and_then(|recorder| {
        let port = network.rsi_port.wrapping_add(1);
        telemetry::prepare(stack, port, recorder, settings, identity, boot)
    });
    Some(Assembly {
        robot,
        port: UdpPort::bind(stack, network.rsi_port, queues).ok()?,
        telemetry,
    })
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
