//! The robot's cycle in real time.

use super::plant::{Next, Plant};
use super::{STOP_PERIOD, Watcher};
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::thread;
use std::time::{Duration, Instant};

/// Room for what a board or somebody else sends.
const DATAGRAM_BYTES: usize = 2048;
/// How often the first telegram is repeated.
const REPEAT: Duration = Duration::from_millis(100);
/// Silence after which it is reported that the board does not answer.
const SILENCE: Duration = Duration::from_secs(2);
/// Pause before a robot that has stopped begins again, as its operator would.
const RESTART: Duration = Duration::from_secs(1);

/// Takes what the board sends.
pub(super) fn receive(plant: &Plant, socket: &UdpSocket, over: &AtomicBool) {
    let mut datagram = [0; DATAGRAM_BYTES];
    while !over.load(Ordering::Relaxed) {
        match socket.recv(&mut datagram) {
            Ok(length) => plant.take(&datagram[..length]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            // The board does not listen yet, or no more.
            Err(_) => thread::sleep(STOP_PERIOD),
        }
    }
}

/// Runs RSI, and again when it has ended.
pub(super) fn run(
    board: SocketAddr,
    plant: &Plant,
    socket: &UdpSocket,
    poses: &Receiver<[f64; 3]>,
    over: &AtomicBool,
    watcher: &dyn Watcher,
) {
    while !over.load(Ordering::Relaxed) {
        let ended = begin(board, plant, socket, over, watcher)
            .and_then(|()| cycles(plant, socket, poses, over, watcher));
        match ended {
            Ok(Some(reason)) => {
                watcher.say(&format!(
                    "the robot has stopped: {reason}; it begins again at its start pose"
                ));
                pause(RESTART, over);
            }
            Ok(None) => {}
            Err(error) => {
                watcher.say(&format!("the robot cannot go on: {error:#}"));
                return;
            }
        }
    }
}

/// Sends the first telegram until it is answered.
fn begin(
    board: SocketAddr,
    plant: &Plant,
    socket: &UdpSocket,
    over: &AtomicBool,
    watcher: &dyn Watcher,
) -> anyhow::Result<()> {
    let telegram = plant.begin_run()?;
    let mut quiet_since = Some(Instant::now());
    while !over.load(Ordering::Relaxed) {
        let sent = socket.send(&telegram);
        if plant.first_answer(REPEAT) {
            watcher.say(&format!("the board on UDP {board} answers: RSI runs"));
            return Ok(());
        }
        if quiet_since.is_some_and(|since| since.elapsed() > SILENCE) {
            quiet_since = None;
            let why = match sent {
                Err(error) => error.to_string(),
                Ok(_) => "silence".to_owned(),
            };
            watcher.say(&format!(
                "no board answers on UDP {board} ({why}): does it run, and is this its --robot \
                 address? Waiting .."
            ));
        }
    }
    Ok(())
}

/// Sends a telegram at each deadline. Returns why the robot stopped; None if `over` was raised.
fn cycles(
    plant: &Plant,
    socket: &UdpSocket,
    poses: &Receiver<[f64; 3]>,
    over: &AtomicBool,
    watcher: &dyn Watcher,
) -> anyhow::Result<Option<String>> {
    // The first contact of a run is told; the others are counted.
    let (mut touched, mut parted) = (false, false);
    while !over.load(Ordering::Relaxed) {
        thread::sleep(plant.deadline().saturating_duration_since(Instant::now()));
        if let Err(reason) = plant.wait_for_answer(over) {
            return Ok(Some(reason));
        }
        match plant.next(poses.try_recv().ok())? {
            Next::Telegram(telegram, touches) => {
                // A board that has gone may come back.
                drop(socket.send(&telegram));
                if touches && !touched {
                    watcher.say("the spacecraft touch");
                } else if touched && !touches && !parted {
                    parted = true;
                    watcher.say("the spacecraft have parted");
                }
                touched |= touches;
            }
            Next::Stopped(reason) => return Ok(Some(reason)),
        }
    }
    Ok(None)
}

fn pause(length: Duration, over: &AtomicBool) {
    let end = Instant::now() + length;
    while Instant::now() < end && !over.load(Ordering::Relaxed) {
        thread::sleep(STOP_PERIOD);
    }
}
