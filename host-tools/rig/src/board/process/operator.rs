//! The operator on standard input, and the onlooker that tells on standard error what happens.

use super::Shared;
use softdock_app::shared::Status;
use softdock_control::modes::Command;
use softdock_io::say;
use softdock_link::sensor::SensorState;
use std::io::BufRead;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// How often the onlooker looks for changes of mode and for faults.
const WATCH_PERIOD: Duration = Duration::from_millis(50);

/// A thread that reads the operator's commands, for the board that is running at the time. It ends
/// with standard input.
pub(super) fn start_operator(current: Arc<Mutex<Arc<Shared>>>) {
    thread::spawn(move || {
        // Bytes that are no text are no command, but the thread goes on.
        for line in std::io::stdin().lock().split(b'\n') {
            let Ok(line) = line else { return };
            let line = String::from_utf8_lossy(&line);
            let word = line.trim();
            let shared = current
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .clone();
            match Command::from_word(word) {
                Some(command) => {
                    if shared.commands.try_send(command).is_err() {
                        say!("board: `{word}` is lost: too many commands wait already");
                    } else if !shared.status().connected {
                        say!("board: `{word}` waits: the robot is silent (a new RSI run drops it)");
                    }
                }
                None if word.is_empty() => {}
                None => {
                    let known: Vec<&str> = Command::WORDS.iter().map(|(word, _)| *word).collect();
                    say!(
                        "board: `{word}` is no command; expected one of {}",
                        known.join(", ")
                    );
                }
            }
        }
    });
}

/// A thread that reports changes of mode, faults and refused commands. It ends with `ended`, which it
/// raises itself when `stop` is raised.
pub(super) fn start_watch(
    shared: Arc<Shared>,
    stop: Arc<AtomicBool>,
    ended: Arc<AtomicBool>,
) -> thread::JoinHandle<()> {
    thread::spawn(move || {
        // From the state at boot on: a quick start is a change as well.
        let mut last = Status::default();
        while !ended.load(Ordering::Relaxed) {
            thread::sleep(WATCH_PERIOD);
            if stop.load(Ordering::Relaxed) {
                ended.store(true, Ordering::Relaxed);
            }
            let now = shared.status();
            if now.mode != last.mode {
                say!("board: mode {:?}", now.mode);
            }
            if let Some(fault) = now.fault.filter(|_| now.fault != last.fault) {
                let softdock_control::modes::Fault {
                    code,
                    expected,
                    received,
                } = fault;
                say!(
                    "board: fault: {code}: expected {expected}, received {received}; `reset` when it is mended"
                );
            }
            if let Some((command, refusal)) = now.refusal.filter(|_| now.refusal != last.refusal) {
                say!("board: {} refused: {refusal}", command.word());
            }
            if let Some(sensor) = now.sensor.filter(|_| now.sensor != last.sensor) {
                match sensor {
                    SensorState::Failed(fault) => say!("board: sensor {sensor:?}: {fault}"),
                    state => say!("board: sensor {state:?}"),
                }
            }
            last = now;
        }
    })
}
