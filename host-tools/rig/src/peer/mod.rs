//! The simulated rig in real time: robot, sensor and mechanism as peers of a board that runs elsewhere, as a process,
//! in QEMU or on a desk.
//!
//! | file | |
//! |---|---|
//! | `telegrams` | RSI as the simulated robot speaks it |
//! | `slcan` | the client's side of an SLCAN adapter |
//! | `plant` | the rig and its clock, between the robot's thread and the sensor's |
//! | `robot` | the robot's cycle, paced by absolute deadlines |
//! | `sensor` | the sensor on CAN or EtherCAT |
//! | `tally` | what was counted |
//!
//! A telegram leaves at its deadline whether or not the last one was answered; an answer counts for the telegram whose
//! time stamp it carries, until the next one leaves; a patient rig lets its clock wait for it. If this computer itself is late by a cycle or more, the rig's
//! clock stands still for so long: that is no fault of the board, and is counted apart.

mod plant;
mod robot;
mod sensor;
pub mod slcan;
mod tally;
pub mod telegrams;
#[cfg(test)]
mod tests;

pub use tally::{Summary, Tally};

use crate::rig::RigSettings;
use anyhow::{Context, Result};
use plant::Plant;
use softdock_app::settings::BoardSettings;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::thread;
use std::time::{Duration, Instant};

/// How often it is looked whether to end.
const STOP_PERIOD: Duration = Duration::from_millis(20);
/// How often the counters are shown.
const SHOW_PERIOD: Duration = Duration::from_millis(250);

/// Where the board takes its sensor from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorLink {
    /// SLCAN on a TCP address.
    Can(SocketAddr),
    /// Frames of an EtherCAT segment in datagrams to a UDP address.
    Ethercat(SocketAddr),
}

/// A rig, and the board that it belongs to.
#[derive(Clone, Debug)]
pub struct Peer {
    /// The rig.
    pub rig: RigSettings,
    /// Where the robot stands when RSI begins: X Y Z (m), A B C (rad).
    pub start_pose: [f64; 6],
    /// Seed of all random numbers.
    pub seed: u64,
    /// Settings of the board that its peers have to know: names of RSI, the sensor on CAN.
    pub board: BoardSettings,
    /// UDP address on which the board waits for the robot.
    pub robot: SocketAddr,
    /// The sensor's link.
    pub sensor: SensorLink,
    /// How long the rig's clock waits for a late answer. 0: not at all, as with a real robot.
    pub patience: Duration,
}

/// Observer of a run.
pub trait Watcher: Sync {
    /// Something happened.
    fn say(&self, what: &str);
    /// Shows the counters so far; called a few times per second.
    fn show(&self, tally: &Tally);
    /// The capture switch closed: the board has to stop.
    fn captured(&self);
}

impl Peer {
    /// Plays the rig until `stop` is raised or so many seconds have passed. `poses` receives orientations (A, B, C in rad) to
    /// which the robot turns slowly, as a program of its own would.
    ///
    /// # Errors
    /// Settings that are not valid, or no free port.
    pub fn run(
        &self,
        stop: &AtomicBool,
        seconds: Option<f64>,
        poses: Receiver<[f64; 3]>,
        watcher: &dyn Watcher,
    ) -> Result<Tally> {
        let plant = Plant::new(self)?;
        let socket = socket(self.robot)?;
        let over = AtomicBool::new(false);
        let end = seconds.map(|s| Instant::now() + Duration::from_secs_f64(s));
        thread::scope(|scope| {
            let (plant, socket, over) = (&plant, &socket, &over);
            scope.spawn(move || robot::receive(plant, socket, over));
            scope.spawn(move || robot::run(self.robot, plant, socket, &poses, over, watcher));
            scope.spawn(move || sensor::run(self, plant, over, watcher));
            let mut shown = Instant::now();
            let mut captured = false;
            while !stop.load(Ordering::Relaxed) && end.is_none_or(|end| Instant::now() < end) {
                thread::sleep(STOP_PERIOD);
                let closed = plant.tally().asks_to_stop;
                if closed && !captured {
                    watcher.captured();
                }
                captured = closed;
                if shown.elapsed() >= SHOW_PERIOD {
                    shown = Instant::now();
                    watcher.show(&plant.tally());
                }
            }
            over.store(true, Ordering::Relaxed);
        });
        Ok(plant.tally())
    }
}

/// A socket whose peer is the board.
fn socket(board: SocketAddr) -> Result<UdpSocket> {
    let any: IpAddr = match board {
        SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        SocketAddr::V6(_) => std::net::Ipv6Addr::UNSPECIFIED.into(),
    };
    let socket = UdpSocket::bind((any, 0)).context("no UDP port is free")?;
    socket
        .connect(board)
        .with_context(|| format!("UDP {board} cannot be reached from this computer"))?;
    socket.set_read_timeout(Some(STOP_PERIOD))?;
    Ok(socket)
}
