//! The client's side of SLCAN: the frames that an adapter sends, and those that it is given.

use softdock_link::can::Frame;
use softdock_link::slcan::{MAX_LINE_BYTES, encode_frame_line, parse_frame_line};
use std::io::{Result, Write};

/// Closes the channel, sets 1 Mbit/s and opens it.
pub const OPEN: &[u8] = b"C\rS8\rO\r";
/// How an adapter refuses a line.
const BEL: u8 = 0x07;

/// Lines of an adapter as they come.
#[derive(Clone, Debug, Default)]
pub struct Lines(Vec<u8>);

impl Lines {
    /// Takes the next byte: the frame that it completes, if it does. What is no frame is passed over.
    pub fn push(&mut self, byte: u8) -> Option<Frame> {
        if matches!(byte, b'\r' | BEL) {
            return parse_frame_line(&std::mem::take(&mut self.0)).ok();
        }
        // A line that is too long for a frame stays too long until its end.
        if self.0.len() <= MAX_LINE_BYTES {
            self.0.push(byte);
        }
        None
    }
}

/// Puts frames on the bus, in one piece.
///
/// # Errors
/// The adapter has gone.
pub fn send(stream: &mut impl Write, frames: impl IntoIterator<Item = Frame>) -> Result<()> {
    let mut text = Vec::new();
    for frame in frames {
        let mut line = heapless::Vec::<u8, MAX_LINE_BYTES>::new();
        encode_frame_line(&frame, &mut line);
        text.extend_from_slice(&line);
    }
    stream.write_all(&text)
}
