//! The adapter's side: bytes from the client into actions and replies.

use heapless::Vec;

use super::line::{self, CARRIAGE_RETURN, MAX_LINE_BYTES, SlcanError};
use crate::can::Frame;

const OK: &[u8] = b"\r";
const BEL: &[u8] = b"\x07";
/// A standard frame was sent.
const SENT_STANDARD: &[u8] = b"z\r";
/// An extended frame was sent.
const SENT_EXTENDED: &[u8] = b"Z\r";
/// Hardware 1.0, software 1.0.
const VERSION: &[u8] = b"V1010\r";
/// Serial number; there is none.
const SERIAL_NUMBER: &[u8] = b"N0000\r";
/// No error flag is set.
const NO_ERRORS: &[u8] = b"F00\r";

/// Every time stamp: there is no clock here. Some clients ask for stamps whenever they open the channel, and expect them.
const NO_TIME: u16 = 0;

/// Request of the client to the adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlcanEvent {
    /// Put this frame on the bus.
    Frame(Frame),
    /// The channel was opened, for sending as well or only for listening.
    Opened,
    /// The channel was closed.
    Closed,
}

/// Whether frames pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    Closed,
    Open,
    ListenOnly,
}

/// An SLCAN adapter.
///
/// It is as tolerant as clients need: empty lines, line feeds, a second `O`, a `C` on a closed channel, and `O`
/// without a bit rate are accepted. The bit rate and the acceptance filter are checked and have no effect, since the
/// bus belongs to the board.
#[derive(Clone, Debug)]
pub struct Slcan {
    line: Vec<u8, MAX_LINE_BYTES>,
    channel: Channel,
    timestamps: bool,
}

impl Default for Slcan {
    fn default() -> Self {
        Self::new()
    }
}

impl Slcan {
    /// Adapter with a closed channel.
    pub fn new() -> Self {
        Self {
            line: Vec::new(),
            channel: Channel::Closed,
            timestamps: false,
        }
    }

    /// Takes in a byte from the client; `reply` is called with the answer to the client.
    ///
    /// Every line is complete in itself, so after any garbage the next carriage return brings both sides back in
    /// step.
    pub fn push(&mut self, byte: u8, reply: &mut impl FnMut(&[u8])) -> Option<SlcanEvent> {
        match byte {
            b'\n' => return None,
            CARRIAGE_RETURN => {}
            _ => {
                // A line that does not fit is cut, and no command is as long as what is left.
                let _ = self.line.push(byte);
                return None;
            }
        }
        let line = core::mem::take(&mut self.line);
        self.execute(&line, reply)
    }

    /// Writes a frame of the bus as a line for the client, replacing what is in `out`.
    ///
    /// # Errors
    /// [`SlcanError::Closed`]; `out` is then empty.
    pub fn encode(
        &self,
        frame: &Frame,
        out: &mut Vec<u8, MAX_LINE_BYTES>,
    ) -> Result<(), SlcanError> {
        out.clear();
        if !self.is_open() {
            return Err(SlcanError::Closed);
        }
        let stamp = self.timestamps.then_some(NO_TIME);
        line::encode(frame, stamp, out);
        Ok(())
    }

    /// Whether the client gets the frames of the bus.
    pub fn is_open(&self) -> bool {
        self.channel != Channel::Closed
    }

    /// Carries out one line.
    fn execute(&mut self, line: &[u8], reply: &mut impl FnMut(&[u8])) -> Option<SlcanEvent> {
        let closed = self.channel == Channel::Closed;
        match line {
            [] => reply(OK),
            b"O" => return self.open(Channel::Open, reply),
            b"L" => return self.open(Channel::ListenOnly, reply),
            b"C" => {
                reply(OK);
                self.channel = Channel::Closed;
                return (!closed).then_some(SlcanEvent::Closed);
            }
            [b't' | b'T' | b'r' | b'R', ..] => return self.transmit(line, reply),
            b"V" => reply(VERSION),
            b"N" => reply(SERIAL_NUMBER),
            b"F" if !closed => reply(NO_ERRORS),
            b"Z0" | b"Z1" if closed => {
                self.timestamps = line == b"Z1";
                reply(OK);
            }
            [b'S', b'0'..=b'8'] if closed => reply(OK),
            [b's', registers @ ..] if closed && is_hex(registers, 4) => reply(OK),
            [b'M' | b'm', filter @ ..] if closed && is_hex(filter, 8) => reply(OK),
            _ => reply(BEL),
        }
        None
    }

    fn open(&mut self, channel: Channel, reply: &mut impl FnMut(&[u8])) -> Option<SlcanEvent> {
        reply(OK);
        let was_closed = !self.is_open();
        self.channel = channel;
        was_closed.then_some(SlcanEvent::Opened)
    }

    fn transmit(&self, line: &[u8], reply: &mut impl FnMut(&[u8])) -> Option<SlcanEvent> {
        match line::parse(line) {
            Ok(frame) if self.channel == Channel::Open => {
                let extended = line.first().is_some_and(u8::is_ascii_uppercase);
                reply(if extended {
                    SENT_EXTENDED
                } else {
                    SENT_STANDARD
                });
                Some(SlcanEvent::Frame(frame))
            }
            _ => {
                reply(BEL);
                None
            }
        }
    }
}

fn is_hex(digits: &[u8], len: usize) -> bool {
    digits.len() == len && line::hex(digits).is_some()
}
