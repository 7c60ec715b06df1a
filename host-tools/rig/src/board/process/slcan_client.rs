//! The sensor's CAN bus behind a real SLCAN adapter: a serial device, or one on the network.

use super::mailbox::Mailbox;
use anyhow::{Context, Result};
use softdock_app::board::{IoError, SensorBus};
use softdock_io::port::Port;
use softdock_io::say;
use softdock_link::can::Frame;
use softdock_link::slcan::{
    AdapterEvent, AdapterLines, CLOSING, MAX_LINE_BYTES, OPENING, encode_frame_line,
};
use std::io::{self, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Frames that may wait for the sensor task.
const QUEUE: usize = 256;
/// Longest wait for the answer to a command while the channel is opened. Adapters answer within a millisecond, or
/// not at all.
const ANSWER_PATIENCE: Duration = Duration::from_millis(200);
/// From one try to reach an adapter that has gone to the next.
const RETRY_PERIOD: Duration = Duration::from_secs(1);
/// How often the thread looks whether the board stops.
const STOP_PERIOD: Duration = Duration::from_millis(20);

/// Where an adapter is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterPort {
    /// Serial device, or `tcp:HOST:PORT`.
    pub name: String,
    /// Speed of a serial device, bit/s; one that is USB all the way has none and ignores it.
    pub baud_rate: u32,
}

impl AdapterPort {
    /// Fails, with what to do, where the adapter cannot be opened now.
    pub(super) fn check(&self) -> Result<()> {
        self.open().map(drop)
    }

    fn open(&self) -> Result<Port> {
        Port::open(&self.name, self.baud_rate).context("the SLCAN adapter")
    }
}

/// The bus as the sensor task sees it.
pub(super) struct AdapterBus {
    received: Mailbox<Frame>,
    /// While the channel is open.
    writer: Writer,
}

type Writer = Arc<Mutex<Option<Port>>>;

impl AdapterBus {
    /// Starts the bus. An adapter that is missing, or gone later, is looked for until `stop` is raised.
    pub(super) fn start(place: AdapterPort, stop: Arc<AtomicBool>) -> Self {
        let bus = Self {
            received: Mailbox::new(QUEUE),
            writer: Writer::default(),
        };
        let (received, writer) = (bus.received.clone(), bus.writer.clone());
        thread::spawn(move || {
            serve(&place, &writer, &received, &stop);
            received.close();
        });
        bus
    }
}

fn lock(writer: &Writer) -> MutexGuard<'_, Option<Port>> {
    writer.lock().unwrap_or_else(PoisonError::into_inner)
}

fn serve(place: &AdapterPort, writer: &Writer, received: &Mailbox<Frame>, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        if let Ok(port) = place.open() {
            match run(port, writer, received, stop) {
                Ok(()) => return,
                Err(error) => say!("board: SLCAN adapter {} has gone: {error}", place.name),
            }
            *lock(writer) = None;
        }
        let retry = Instant::now() + RETRY_PERIOD;
        while Instant::now() < retry && !stop.load(Ordering::Relaxed) {
            thread::sleep(STOP_PERIOD);
        }
    }
}

/// Opens the channel and passes frames on until `stop` is raised.
fn run(
    mut port: Port,
    writer: &Writer,
    received: &Mailbox<Frame>,
    stop: &AtomicBool,
) -> io::Result<()> {
    let mut lines = AdapterLines::default();
    for command in OPENING {
        port.write_all(command)?;
        let refused = !carried_out(&mut port, &mut lines, received)?;
        // A channel that is not open cannot be closed, and some adapters say so.
        if refused && command != CLOSING {
            let command = String::from_utf8_lossy(command);
            say!(
                "board: the SLCAN adapter refused `{}`; expected one that does 1 Mbit/s and whose channel nobody else has opened",
                command.trim()
            );
        }
    }
    *lock(writer) = Some(port.try_clone()?);
    say!("board: SLCAN channel opened at 1 Mbit/s");
    let mut puzzled = false;
    while !stop.load(Ordering::Relaxed) {
        for event in read(&mut port, &mut lines)? {
            match event {
                AdapterEvent::Frame(frame) => received.push(frame),
                AdapterEvent::NotUnderstood if !puzzled => {
                    puzzled = true;
                    say!("board: the SLCAN adapter sends lines that are no frames");
                }
                AdapterEvent::Done | AdapterEvent::Refused | AdapterEvent::NotUnderstood => {}
            }
        }
    }
    port.write_all(CLOSING)
}

/// Waits for the answers to a command, until the adapter has been silent for a while. Returns false for a refusal; an adapter
/// that does not answer is taken to agree.
fn carried_out(
    port: &mut Port,
    lines: &mut AdapterLines,
    received: &Mailbox<Frame>,
) -> io::Result<bool> {
    let patience = Instant::now() + ANSWER_PATIENCE;
    let mut answer = None;
    while Instant::now() < patience {
        let events = read(port, lines)?;
        if events.is_empty() && answer.is_some() {
            break;
        }
        for event in events {
            match event {
                AdapterEvent::Done => answer = Some(true),
                AdapterEvent::Refused => answer = Some(false),
                AdapterEvent::Frame(frame) => received.push(frame),
                AdapterEvent::NotUnderstood => {}
            }
        }
    }
    Ok(answer.unwrap_or(true))
}

fn read(port: &mut Port, lines: &mut AdapterLines) -> io::Result<Vec<AdapterEvent>> {
    let mut piece = [0; 512];
    let length = port.read(&mut piece)?;
    Ok(piece[..length]
        .iter()
        .filter_map(|byte| lines.push(*byte))
        .collect())
}

impl SensorBus for AdapterBus {
    type Frame = Frame;

    async fn send(&mut self, frame: &Frame) -> Result<(), IoError> {
        let mut writer = lock(&self.writer);
        let Some(port) = writer.as_mut() else {
            // No bus: the frame is not acknowledged, which the driver's timeout tells.
            return Ok(());
        };
        let mut line = heapless::Vec::<u8, MAX_LINE_BYTES>::new();
        encode_frame_line(frame, &mut line);
        if port.write_all(&line).is_ok() {
            return Ok(());
        }
        *writer = None;
        Err(IoError::Lost)
    }

    async fn receive(&mut self) -> Result<Frame, IoError> {
        self.received.take().await
    }

    async fn recover(&mut self) -> Result<(), IoError> {
        Ok(())
    }
}
