//! Takes datagrams from a socket as they come.
//!
//! The system buffers about ninety datagrams, each counted with its overhead, in a receive buffer of 208 KiB: a third of a
//! second of cycles. A separate thread keeps that buffer empty whatever the disk does.

use anyhow::{Context, Result};
use softdock_app::telemetry::DATAGRAM_MAX_BYTES;
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Datagrams that may wait to be written: one minute of cycles, about 20 MB.
const QUEUE: usize = 15_000;
/// Period at which the thread checks whether it shall end.
const STOP_PERIOD: Duration = Duration::from_millis(50);
/// Most datagrams that are still read from the system at the end: more than its buffer holds.
const MOST_QUEUED: usize = 4096;

/// A datagram and its sender.
pub type Received = (Vec<u8>, SocketAddr);

/// A socket and the thread that receives from it.
#[derive(Debug)]
pub struct Listener {
    address: SocketAddr,
    queue: Receiver<Received>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// Ends the thread, so that the port is free again.
impl Drop for Listener {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The thread may wait for room in a queue that nobody empties any more: disconnect the queue.
            self.queue = sync_channel(0).1;
            let _ = thread.join();
        }
    }
}

impl Listener {
    /// Listens on an address.
    ///
    /// # Errors
    /// The address is taken, or not one of this computer.
    pub fn bind(address: SocketAddr) -> Result<Self> {
        let socket = UdpSocket::bind(address).with_context(|| {
            format!(
                "cannot listen for telemetry on UDP {address}; is another recorder running, or is \
                 this not an address of this computer?"
            )
        })?;
        let address = socket.local_addr()?;
        socket.set_read_timeout(Some(STOP_PERIOD))?;
        let (sender, queue) = sync_channel(QUEUE);
        let stop = Arc::new(AtomicBool::new(false));
        let raised = stop.clone();
        let thread = thread::spawn(move || listen(&socket, &sender, &raised));
        Ok(Self {
            address,
            queue,
            stop,
            thread: Some(thread),
        })
    }

    /// The local address of the socket.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The next datagram; None if none comes within the timeout.
    pub fn receive(&self, timeout: Duration) -> Option<Received> {
        self.queue.recv_timeout(timeout).ok()
    }

    /// Ends listening and returns all datagrams that have come until now.
    pub fn close(mut self) -> impl Iterator<Item = Received> {
        // The iterator ends when the thread has ended and dropped its sender.
        self.stop.store(true, Ordering::Relaxed);
        self.thread = None;
        std::mem::replace(&mut self.queue, sync_channel(0).1).into_iter()
    }
}

fn listen(socket: &UdpSocket, queue: &SyncSender<Received>, stop: &AtomicBool) {
    // One byte more than the longest datagram, to detect those that are too long.
    let mut buffer = [0; DATAGRAM_MAX_BYTES + 1];
    while !stop.load(Ordering::Relaxed) {
        match socket.recv_from(&mut buffer) {
            Ok((length, from)) => {
                if queue.send((buffer[..length].to_vec(), from)).is_err() {
                    return;
                }
            }
            // The timeout lets the loop check `stop`.
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            // Any other error may be a peer's and pass. If it persists, the pause keeps the loop from using up a core.
            Err(_) => thread::sleep(STOP_PERIOD),
        }
    }
    // Record also what the system received before the end.
    if socket.set_nonblocking(true).is_err() {
        return;
    }
    for _ in 0..MOST_QUEUED {
        let Ok((length, from)) = socket.recv_from(&mut buffer) else {
            return;
        };
        if queue.send((buffer[..length].to_vec(), from)).is_err() {
            return;
        }
    }
}
