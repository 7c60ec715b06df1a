//! The sensor's CAN bus as an SLCAN adapter on a TCP port. One client at a time; a new one takes
//! the place of the old.

use super::mailbox::Mailbox;
use anyhow::{Context, Result};
use softdock_app::board::{IoError, SensorBus};
use softdock_io::say;
use softdock_link::can::Frame;
use softdock_link::slcan::{MAX_LINE_BYTES, Slcan, SlcanEvent};
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Frames that may wait for the sensor task.
const QUEUE: usize = 256;
/// How often the thread looks whether the board stops.
const STOP_PERIOD: Duration = Duration::from_millis(20);

/// The connected client.
#[derive(Debug)]
struct Client {
    stream: TcpStream,
    adapter: Slcan,
}

/// The bus as the sensor task sees it.
#[derive(Debug)]
pub(super) struct SlcanBus {
    received: Mailbox<Frame>,
    client: Arc<Mutex<Option<Client>>>,
}

impl SlcanBus {
    pub(super) fn start(listener: TcpListener, stop: Arc<AtomicBool>) -> Result<Self> {
        listener
            .set_nonblocking(true)
            .context("the sensor's port")?;
        let bus = Self {
            received: Mailbox::new(QUEUE),
            client: Arc::default(),
        };
        let (received, client) = (bus.received.clone(), bus.client.clone());
        thread::spawn(move || {
            serve(&listener, &client, &received, &stop);
            received.close();
        });
        Ok(bus)
    }
}

fn lock(client: &Mutex<Option<Client>>) -> MutexGuard<'_, Option<Client>> {
    // A line is parsed to its end before anything could panic.
    client.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Accepts clients and reads from the newest.
fn serve(
    listener: &TcpListener,
    client: &Mutex<Option<Client>>,
    received: &Mailbox<Frame>,
    stop: &AtomicBool,
) {
    let mut reader: Option<TcpStream> = None;
    while !stop.load(Ordering::Relaxed) {
        if let Ok((stream, peer)) = listener.accept() {
            match connect(stream) {
                Ok((read, write)) => {
                    say!("board: SLCAN client {peer}");
                    reader = Some(read);
                    *lock(client) = Some(Client {
                        stream: write,
                        adapter: Slcan::new(),
                    });
                }
                Err(error) => say!("board: SLCAN client {peer} refused: {error}"),
            }
        }
        let Some(stream) = &mut reader else {
            thread::sleep(STOP_PERIOD);
            continue;
        };
        if !read(stream, client, received) {
            say!("board: SLCAN client has gone");
            reader = None;
            *lock(client) = None;
        }
    }
}

/// The two halves of a connection. A client that does not read must not hold the board up.
fn connect(stream: TcpStream) -> std::io::Result<(TcpStream, TcpStream)> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(STOP_PERIOD))?;
    stream.set_write_timeout(Some(STOP_PERIOD))?;
    Ok((stream.try_clone()?, stream))
}

/// Reads received bytes. Returns false if the client is gone.
fn read(stream: &mut TcpStream, client: &Mutex<Option<Client>>, received: &Mailbox<Frame>) -> bool {
    let mut buffer = [0; 512];
    let length = match stream.read(&mut buffer) {
        Ok(0) => return false,
        Ok(length) => length,
        Err(error) => {
            return matches!(
                error.kind(),
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
            );
        }
    };
    let mut client = lock(client);
    let Some(Client { stream, adapter }) = client.as_mut() else {
        return false;
    };
    let mut replies = Vec::new();
    for byte in &buffer[..length] {
        let event = adapter.push(*byte, &mut |reply| replies.extend_from_slice(reply));
        if let Some(SlcanEvent::Frame(frame)) = event {
            received.push(frame);
        }
    }
    replies.is_empty() || stream.write_all(&replies).is_ok()
}

impl SensorBus for SlcanBus {
    type Frame = Frame;

    async fn send(&mut self, frame: &Frame) -> Result<(), IoError> {
        let mut client = lock(&self.client);
        let Some(Client { stream, adapter }) = client.as_mut() else {
            // No client: the frame is not acknowledged, and the driver notices by its timeout.
            return Ok(());
        };
        let mut line = heapless::Vec::<u8, MAX_LINE_BYTES>::new();
        if adapter.encode(frame, &mut line).is_err() {
            return Ok(());
        }
        if stream.write_all(&line).is_ok() {
            return Ok(());
        }
        // A client that does not read would hold up every cycle, and a line cut in two would not be
        // understood: it may connect again.
        say!("board: SLCAN client does not read; disconnected");
        drop(stream.shutdown(Shutdown::Both));
        *client = None;
        Err(IoError::Lost)
    }

    async fn receive(&mut self) -> Result<Frame, IoError> {
        self.received.take().await
    }

    async fn recover(&mut self) -> Result<(), IoError> {
        Ok(())
    }
}
