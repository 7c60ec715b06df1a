//! The way from the board's network to the EtherCAT segment: QEMU sends each frame to one address in a datagram, and the
//! segment is wherever the last one came from.

use super::ports;
use anyhow::{Context, Result};
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// How often it is looked whether QEMU has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// Longest frame; a datagram shorter than an Ethernet header says only where the segment is.
const FRAME_BYTES: usize = 1600;
const HEADER_BYTES: usize = 14;

/// A thread that passes frames on.
pub(super) struct Relay {
    /// Address at which QEMU is to listen.
    pub(super) board: SocketAddr,
    /// Address to which it is to send.
    pub(super) segment: SocketAddr,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Relay {
    /// Passes frames on between QEMU and whoever sends to `socket`.
    pub(super) fn start(socket: UdpSocket) -> Result<Self> {
        let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let free = ports::bound(UdpSocket::bind, any).context("no UDP port is free")?;
        let board = free.local_addr()?;
        let segment = socket.local_addr()?;
        socket.set_read_timeout(Some(POLL_INTERVAL))?;
        let ended = Arc::new(AtomicBool::new(false));
        let stop = ended.clone();
        Ok(Self {
            board,
            segment,
            ended,
            thread: Some(thread::spawn(move || pass(&socket, board, &stop))),
        })
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn pass(socket: &UdpSocket, board: SocketAddr, stop: &AtomicBool) {
    let mut frame = [0; FRAME_BYTES];
    let mut segment = None;
    while !stop.load(Ordering::Relaxed) {
        // After a timeout `stop` is checked; other errors are a peer's and are ignored.
        let Ok((length, from)) = socket.recv_from(&mut frame) else {
            continue;
        };
        let to = match from == board {
            true => segment,
            false => {
                segment = Some(from);
                Some(board).filter(|_| length >= HEADER_BYTES)
            }
        };
        if let Some(to) = to {
            let _ = socket.send_to(&frame[..length], to);
        }
    }
}
