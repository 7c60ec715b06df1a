//! The sensor in real time: on CAN behind the board's SLCAN port, or on EtherCAT.

use super::plant::Plant;
use super::slcan::{self, frames};
use super::{Peer, STOP_PERIOD, SensorLink, Watcher};
use crate::board::{ReadingSampler, SimulatedSensor};
use crate::ethercat::wire::plug;
use crate::ethercat::{Description, Segment, SubDevice};
use anyhow::{Context, Result};
use softdock_link::ethercat::Product;
use softdock_link::slcan::{AdapterLines, OPENING};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Pause between attempts to connect, and how long one may take.
const RETRY: Duration = Duration::from_millis(200);
const CONNECT: Duration = Duration::from_secs(1);
/// Silence after which it is reported that nothing requests a reading.
const SILENCE: Duration = Duration::from_secs(3);

/// Plays the sensor.
pub(super) fn run(peer: &Peer, plant: &Plant, over: &AtomicBool, watcher: &dyn Watcher) {
    let played = match peer.sensor {
        SensorLink::Can(board) => can(board, peer, plant, over, watcher),
        SensorLink::Ethercat(board) => ethercat(board, peer, plant, over),
    };
    if let Err(error) = played {
        watcher.say(&format!("the sensor cannot go on: {error:#}"));
    }
}

/// Is an EtherCAT segment.
fn ethercat(board: SocketAddr, peer: &Peer, plant: &Plant, over: &AtomicBool) -> Result<()> {
    let axia = SubDevice::new(Description::of(Product::Axia80));
    let mut segment = Segment::new(vec![axia]);
    let mut sampler = ReadingSampler::new(peer.rig.sensor.calibration());
    let start = Instant::now();
    plug(board, over, &mut segment, |segment, _| {
        sampler.measure(segment, micros_since(start), &mut || plant.sense());
    })
}

/// Connects to the board's SLCAN port, and again when the connection has ended.
fn can(
    board: SocketAddr,
    peer: &Peer,
    plant: &Plant,
    over: &AtomicBool,
    watcher: &dyn Watcher,
) -> Result<()> {
    let mut told = false;
    while !over.load(Ordering::Relaxed) {
        match TcpStream::connect_timeout(&board, CONNECT) {
            Ok(stream) => {
                watcher.say(&format!("the sensor is connected to TCP {board}"));
                let device = SimulatedSensor::new(&peer.board.can, peer.rig.sensor.calibration())?;
                Line::new(device, plant, over).serve(stream, board, watcher)?;
                told = over.load(Ordering::Relaxed);
                if !told {
                    watcher.say("the board has let go of the sensor; connecting again ..");
                    told = true;
                }
            }
            Err(error) if !told => {
                told = true;
                watcher.say(&format!(
                    "nobody takes the sensor on TCP {board} ({error}): does the board run, and is \
                     this its --can address? Waiting .."
                ));
            }
            Err(_) => {}
        }
        thread::sleep(RETRY);
    }
    Ok(())
}

/// The sensor on an open line.
struct Line<'a> {
    device: Mutex<SimulatedSensor>,
    /// A frame came or the line ended.
    changed: Condvar,
    start: Instant,
    plant: &'a Plant,
    over: &'a AtomicBool,
    closed: AtomicBool,
}

impl<'a> Line<'a> {
    fn new(device: SimulatedSensor, plant: &'a Plant, over: &'a AtomicBool) -> Self {
        Self {
            device: Mutex::new(device),
            changed: Condvar::new(),
            start: Instant::now(),
            plant,
            over,
            closed: AtomicBool::new(false),
        }
    }

    fn is_open(&self) -> bool {
        !self.over.load(Ordering::Relaxed) && !self.closed.load(Ordering::Relaxed)
    }

    fn lock(&self) -> MutexGuard<'_, SimulatedSensor> {
        self.device.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Serves the board until the line ends.
    fn serve(self, stream: TcpStream, board: SocketAddr, watcher: &dyn Watcher) -> Result<()> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(STOP_PERIOD))?;
        let mut write = stream.try_clone().context("the sensor's line")?;
        thread::scope(|scope| {
            scope.spawn(|| {
                // A line that cannot be written to is closed for the reader as well.
                drop(self.speak(&mut write));
                self.closed.store(true, Ordering::Relaxed);
            });
            self.listen(stream, board, watcher);
            self.closed.store(true, Ordering::Relaxed);
            self.changed.notify_all();
        });
        Ok(())
    }

    /// Takes the board's frames.
    fn listen(&self, mut stream: TcpStream, board: SocketAddr, watcher: &dyn Watcher) {
        let mut quiet = true;
        let mut lines = AdapterLines::default();
        let mut buffer = [0; 512];
        while self.is_open() {
            let length = match stream.read(&mut buffer) {
                Ok(0) => return,
                Ok(length) => length,
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
                {
                    if quiet && self.start.elapsed() > SILENCE {
                        quiet = false;
                        watcher.say(&format!(
                            "nobody asks the sensor for readings on TCP {board}: is this the \
                             board's --can address, and do its settings name a sensor on CAN?"
                        ));
                    }
                    continue;
                }
                Err(_) => return,
            };
            for frame in frames(&mut lines, &buffer[..length]) {
                quiet = false;
                let now_us = micros_since(self.start);
                self.lock()
                    .receive(&frame, now_us, &mut || self.plant.sense());
                self.changed.notify_all();
            }
        }
    }

    /// Puts the sensor's frames on the line when they are due.
    fn speak(&self, stream: &mut impl Write) -> std::io::Result<()> {
        stream.write_all(&OPENING.concat())?;
        while self.is_open() {
            let mut device = self.lock();
            let now_us = micros_since(self.start);
            let due = std::iter::from_fn(|| device.poll(now_us, &mut || self.plant.sense()));
            let due: Vec<_> = due.collect();
            if due.is_empty() {
                let wait = Duration::from_micros(device.next_us().saturating_sub(now_us));
                drop(self.changed.wait_timeout(device, wait.min(STOP_PERIOD)));
                continue;
            }
            drop(device);
            slcan::send(stream, due)?;
        }
        Ok(())
    }
}

fn micros_since(start: Instant) -> u64 {
    u64::try_from(start.elapsed().as_micros()).unwrap_or(u64::MAX)
}
