//! The cable as UDP: one frame in one datagram, in real time.

use super::segment::Segment;
use anyhow::{Context, Result};
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Whether a frame exchanges process data: its first datagram is LRW.
pub fn exchanges(frame: &[u8]) -> bool {
    const COMMAND: usize = 16;
    const LRW: u8 = 12;
    frame.get(COMMAND) == Some(&LRW)
}

/// Longest frame.
const FRAME_BYTES: usize = 1600;
/// Longest silence of the board before it is told again where the segment is; also how often `stop` is checked.
const SILENCE: Duration = Duration::from_millis(50);

/// Connects a segment to a board that listens on `board`, until `stop` is raised. `before` is called with each frame before it
/// passes, and sets what the sensor measures and what happens to the frame. The board answers whoever spoke last; a datagram that
/// is too short for a frame only tells it where the segment is.
///
/// # Errors
/// No port is free.
pub fn plug(
    board: SocketAddr,
    stop: &AtomicBool,
    segment: &mut Segment,
    mut before: impl FnMut(&mut Segment, &[u8]),
) -> Result<()> {
    let any = SocketAddr::new(board.ip(), 0);
    let socket = UdpSocket::bind(any).with_context(|| format!("no UDP port is free on {any}"))?;
    socket.set_read_timeout(Some(SILENCE))?;
    let mut frame = [0; FRAME_BYTES];
    while !stop.load(Ordering::Relaxed) {
        match socket.recv_from(&mut frame) {
            Ok((length, from)) if from == board => {
                let frame = &frame[..length];
                before(segment, frame);
                for (_, back) in segment.pass(frame) {
                    // A board that has gone may come back.
                    let _ = socket.send_to(&back, board);
                }
            }
            Ok(_) => {}
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                let _ = socket.send_to(&[], board);
            }
            // The board has not begun to listen.
            Err(_) => std::thread::sleep(SILENCE),
        }
    }
    Ok(())
}
