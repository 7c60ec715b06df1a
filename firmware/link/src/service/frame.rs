//! Frames on a serial line.
//!
//! | bytes | what |
//! |---|---|
//! | 1 | version of the protocol; [`Kind::Hello`] and its answer are the same in all of them |
//! | 1 | [`Kind`] |
//! | 2 | sequence number: an answer bears that of its request |
//! | 4 | number of the conversation, which the board gives with its answer to a hello; 0 in the hello of the host |
//! | n | payload: a message in postcard's format |
//! | 4 | CRC-32 (ISO-HDLC) of everything before |
//!
//! Numbers are little-endian. COBS removes the zeros from these bytes; a zero precedes and follows them. So a lost or changed
//! byte damages one frame and never the next: if it was the zero after a frame, the one before the next frame ends it.

use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::Vec;

/// Bytes before the payload.
pub const HEADER_BYTES: usize = 8;
/// Longest payload: an entry of the list with its help. At 115,200 bit/s it takes 0.09 s.
pub const PAYLOAD_MAX_BYTES: usize = 1024;
/// Bytes behind the payload.
const CHECKSUM_BYTES: usize = 4;
const PLAIN_MAX_BYTES: usize = HEADER_BYTES + PAYLOAD_MAX_BYTES + CHECKSUM_BYTES;
/// Longest frame on the line: COBS adds a byte per 254 and one more, then there are two zeros.
pub const ENCODED_MAX_BYTES: usize = PLAIN_MAX_BYTES + PLAIN_MAX_BYTES / 254 + 1 + 2;

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Type of a frame's payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// "Who are you?", without payload. The same in every version of the protocol.
    Hello = 1,
    /// A [`Hello`](super::Hello). The same in every version of the protocol.
    HelloAnswer = 2,
    /// A [`Request`](super::Request).
    Request = 3,
    /// An [`Answer`](super::Answer).
    Answer = 4,
}

impl Kind {
    fn of(byte: u8) -> Option<Self> {
        [Self::Hello, Self::HelloAnswer, Self::Request, Self::Answer]
            .into_iter()
            .find(|kind| *kind as u8 == byte)
    }
}

/// Why bytes between two zeros are no frame, or a payload does not become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// Longer than any frame, or too short for one.
    #[error("bytes that are too many or too few for a frame")]
    Length,
    /// Not valid COBS.
    #[error("bytes that are no frame")]
    Stuffing,
    /// A byte was lost or changed.
    #[error("a damaged frame")]
    Checksum,
    /// A kind of frame that this version does not know.
    #[error("a frame of an unknown kind")]
    Kind,
}

/// A frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Version of the protocol.
    pub version: u8,
    /// Type of the payload.
    pub kind: Kind,
    /// Number of the request.
    pub sequence: u16,
    /// Number of the conversation, as the frame of the board's [`Hello`](super::Hello) bears it; 0 in that of the host.
    pub conversation: u32,
    /// The message.
    pub payload: &'a [u8],
}

impl<'a> Frame<'a> {
    /// The bytes for the line.
    ///
    /// # Errors
    /// The payload is longer than [`PAYLOAD_MAX_BYTES`].
    pub fn encode(&self) -> Result<Vec<u8, ENCODED_MAX_BYTES>, FrameError> {
        let mut plain = Vec::<u8, PLAIN_MAX_BYTES>::new();
        let sequence = self.sequence.to_le_bytes();
        let conversation = self.conversation.to_le_bytes();
        let parts: [&[u8]; 4] = [
            &[self.version, self.kind as u8],
            &sequence,
            &conversation,
            self.payload,
        ];
        for part in parts {
            plain
                .extend_from_slice(part)
                .map_err(|_| FrameError::Length)?;
        }
        let checksum = CHECKSUM.checksum(&plain).to_le_bytes();
        plain
            .extend_from_slice(&checksum)
            .map_err(|_| FrameError::Length)?;
        let mut line = Vec::new();
        line.resize(ENCODED_MAX_BYTES, 0)
            .map_err(|_| FrameError::Length)?;
        let stuffed = line.get_mut(1..).unwrap_or_default();
        let length = cobs::try_encode(&plain, stuffed).map_err(|_| FrameError::Length)?;
        line.truncate(length + 1);
        line.push(0).map_err(|_| FrameError::Length)?;
        Ok(line)
    }

    /// Decodes the frame between two zeros, in place.
    fn decode(bytes: &'a mut [u8]) -> Result<Self, FrameError> {
        let length = cobs::decode_in_place(bytes).map_err(|_| FrameError::Stuffing)?;
        let plain = bytes.get(..length).ok_or(FrameError::Stuffing)?;
        let (body, checksum) = plain
            .split_last_chunk::<CHECKSUM_BYTES>()
            .ok_or(FrameError::Length)?;
        if CHECKSUM.checksum(body) != u32::from_le_bytes(*checksum) {
            return Err(FrameError::Checksum);
        }
        let (header, payload) = body
            .split_first_chunk::<HEADER_BYTES>()
            .ok_or(FrameError::Length)?;
        let &[version, kind, q0, q1, c0, c1, c2, c3] = header;
        Ok(Self {
            version,
            kind: Kind::of(kind).ok_or(FrameError::Kind)?,
            sequence: u16::from_le_bytes([q0, q1]),
            conversation: u32::from_le_bytes([c0, c1, c2, c3]),
            payload,
        })
    }
}

/// Assembles frames, byte by byte.
#[derive(Debug, Default)]
pub struct FrameReader {
    bytes: Vec<u8, ENCODED_MAX_BYTES>,
    /// More bytes came than a frame can have.
    too_long: bool,
    /// The last zero was seen; the next byte begins a frame.
    ended: bool,
}

impl FrameReader {
    /// Nothing read.
    pub const fn new() -> Self {
        Self {
            bytes: Vec::new(),
            too_long: false,
            ended: false,
        }
    }

    /// Takes in a byte. At the end of a frame returns the frame, or why it is invalid; else `None`.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame<'_>, FrameError>> {
        if core::mem::take(&mut self.ended) {
            self.bytes.clear();
            self.too_long = false;
        }
        if byte != 0 {
            self.too_long |= self.bytes.push(byte).is_err();
            return None;
        }
        self.ended = true;
        if self.too_long {
            return Some(Err(FrameError::Length));
        }
        if self.bytes.is_empty() {
            return None;
        }
        Some(Frame::decode(&mut self.bytes))
    }
}
