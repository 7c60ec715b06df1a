//! The port to the EtherCAT segment: one Ethernet frame in one UDP datagram. Frames go to the address of the last datagram
//! received; a datagram that is too short for a frame only announces that address.

use super::mailbox::Mailbox;
use anyhow::{Context as _, Result};
use softdock_app::board::{EthernetPort, IoError};
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::thread;
use std::time::Duration;

/// Frames that may wait.
const QUEUE: usize = 64;
/// Longest frame.
const FRAME_BYTES: usize = 1600;
/// How often the thread looks whether the board stops.
const STOP_PERIOD: Duration = Duration::from_millis(20);

/// A UDP socket with a thread that reads it.
#[derive(Debug)]
pub(super) struct SegmentPort {
    socket: Arc<UdpSocket>,
    received: Mailbox<Vec<u8>>,
    segment: Arc<Mutex<Option<SocketAddr>>>,
}

impl SegmentPort {
    pub(super) fn start(socket: UdpSocket, stop: Arc<AtomicBool>) -> Result<Self> {
        socket
            .set_read_timeout(Some(STOP_PERIOD))
            .context("the EtherCAT segment's socket")?;
        let port = Self {
            socket: Arc::new(socket),
            received: Mailbox::new(QUEUE),
            segment: Arc::default(),
        };
        let (socket, received) = (port.socket.clone(), port.received.clone());
        let segment = port.segment.clone();
        thread::spawn(move || {
            let mut buffer = [0; FRAME_BYTES];
            while !stop.load(Ordering::Relaxed) {
                if let Ok((length, from)) = socket.recv_from(&mut buffer) {
                    *segment.lock().unwrap_or_else(PoisonError::into_inner) = Some(from);
                    received.push(buffer[..length].to_vec());
                }
            }
            received.close();
        });
        Ok(port)
    }
}

impl EthernetPort for SegmentPort {
    fn poll_receive(
        &mut self,
        context: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<Result<usize, IoError>> {
        self.received.poll_take(context).map(|frame| {
            let frame = frame?;
            let room = buffer.get_mut(..frame.len()).ok_or(IoError::Lost)?;
            room.copy_from_slice(&frame);
            Ok(frame.len())
        })
    }

    fn poll_send(&mut self, _context: &mut Context<'_>, frame: &[u8]) -> Poll<()> {
        let segment = *self.segment.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(segment) = segment {
            // If the segment is gone the frame is lost, as on an unplugged cable.
            let _ = self.socket.send_to(frame, segment);
        }
        Poll::Ready(())
    }
}
