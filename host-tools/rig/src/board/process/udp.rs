//! The robot's UDP socket.

use super::mailbox::Mailbox;
use anyhow::{Context, Result};
use softdock_app::board::{DatagramSocket, IoError};
use softdock_app::robot::TELEGRAM_BYTES;
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Datagrams that may wait; the task answers the newest and counts the others.
const QUEUE: usize = 64;
/// How often the thread looks whether the board stops.
const STOP_PERIOD: Duration = Duration::from_millis(50);

/// A UDP socket with a thread that reads it.
#[derive(Debug)]
pub(super) struct UdpPort {
    socket: Arc<UdpSocket>,
    received: Mailbox<(Vec<u8>, SocketAddr)>,
}

impl UdpPort {
    pub(super) fn start(socket: UdpSocket, stop: Arc<AtomicBool>) -> Result<Self> {
        socket
            .set_read_timeout(Some(STOP_PERIOD))
            .context("the robot's socket")?;
        let socket = Arc::new(socket);
        let received = Mailbox::new(QUEUE);
        let port = Self {
            socket: socket.clone(),
            received: received.clone(),
        };
        thread::spawn(move || {
            let mut buffer = [0; TELEGRAM_BYTES];
            while !stop.load(Ordering::Relaxed) {
                // After a timeout `stop` is checked; other errors are a peer's and are ignored.
                if let Ok((length, from)) = socket.recv_from(&mut buffer) {
                    received.push((buffer[..length].to_vec(), from));
                }
            }
            received.close();
        });
        Ok(port)
    }
}

fn copy((bytes, from): (Vec<u8>, SocketAddr), buffer: &mut [u8]) -> (usize, SocketAddr) {
    let length = bytes.len().min(buffer.len());
    buffer[..length].copy_from_slice(&bytes[..length]);
    (length, from)
}

impl DatagramSocket for UdpPort {
    async fn receive(&mut self, buffer: &mut [u8]) -> Result<(usize, SocketAddr), IoError> {
        self.received
            .take()
            .await
            .map(|datagram| copy(datagram, buffer))
    }

    fn try_receive(&mut self, buffer: &mut [u8]) -> Option<(usize, SocketAddr)> {
        self.received
            .try_take()
            .map(|datagram| copy(datagram, buffer))
    }

    async fn send(&mut self, datagram: &[u8], to: SocketAddr) -> Result<(), IoError> {
        self.socket
            .send_to(datagram, to)
            .map(|_| ())
            .map_err(|_| IoError::Lost)
    }
}
