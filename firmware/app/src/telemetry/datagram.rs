//! One datagram of the telemetry: a part of a message behind a header.

use crate::checksum::CHECKSUM;

/// First bytes of each datagram.
pub const MAGIC: [u8; 4] = *b"SDKT";
/// Version of the layout of a datagram, not of what it carries: that is the schema's.
pub const VERSION: u8 = 1;

/// Longest payload, bytes.
pub const PAYLOAD_MAX_BYTES: usize = 1400;
/// Bytes before the payload.
pub const HEADER_BYTES: usize = 24;
const CHECKSUM_BYTES: usize = 4;
/// Longest datagram, bytes. An Ethernet frame takes 1500 - 20 (IPv4) - 8 (UDP) = 1472, so that
/// none is ever fragmented; with IPv6 1452.
pub const DATAGRAM_MAX_BYTES: usize = HEADER_BYTES + PAYLOAD_MAX_BYTES + CHECKSUM_BYTES;

/// A datagram as bytes.
pub type Datagram = heapless::Vec<u8, DATAGRAM_MAX_BYTES>;

/// Kind of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The record of a cycle.
    Record,
    /// Settings and identity of the board.
    Announcement,
    /// State of the board itself ([`Machine`](softdock_link::service::Machine)).
    Machine,
}

/// A part of a message, and where it belongs.
///
/// | bytes | what |
/// |---|---|
/// | 4 | [`MAGIC`] |
/// | 1 | [`VERSION`] |
/// | 1 | kind of the message: 1 record, 2 announcement, 3 how the board itself is |
/// | 1 | number of this part, from 0 |
/// | 1 | parts of the message, at least 1 |
/// | 4 | boot: differs between any two boots of any two boards |
/// | 4 | sequence: number of this datagram since boot, from 0; wraps |
/// | 4 | schema of the records ([`super::schema`]) |
/// | 4 | records that the board has lost since boot for want of room; wraps |
/// | n | payload, at most [`PAYLOAD_MAX_BYTES`] |
/// | 4 | CRC-32 (ISO-HDLC) of everything before |
///
/// Numbers are little-endian. The parts of a message have consecutive sequence numbers, and all
/// but the last are of full length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessagePart<'a> {
    /// Kind of the message.
    pub kind: Kind,
    /// Number of this part, below `parts`.
    pub part: u8,
    /// Parts of the message.
    pub parts: u8,
    /// Boot of the board.
    pub boot: u32,
    /// Number of this datagram.
    pub sequence: u32,
    /// Schema of the records.
    pub schema: u32,
    /// Records that the board has lost.
    pub lost: u32,
    /// This part of the message; [`Self::write`] cuts off what is beyond [`PAYLOAD_MAX_BYTES`].
    pub payload: &'a [u8],
}

/// Why a datagram is not a part of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DatagramError {
    /// It does not begin with the magic bytes: it comes from another program.
    #[error("not a datagram of softdock's telemetry")]
    Foreign,
    /// A firmware with another layout sent it.
    #[error("telemetry of version {received}; expected is version {expected}")]
    Version {
        /// Of this program.
        expected: u8,
        /// Of the datagram.
        received: u8,
    },
    /// It is shorter than header and checksum, or longer than any datagram.
    #[error(
        "a datagram of {received} bytes; expected are {} to {most}",
        HEADER_BYTES + CHECKSUM_BYTES
    )]
    Length {
        /// Longest length, bytes.
        most: usize,
        /// Its length, bytes.
        received: usize,
    },
    /// It is damaged.
    #[error("a damaged datagram: checksum {received:08x} in place of {expected:08x}")]
    Checksum {
        /// Computed from its bytes.
        expected: u32,
        /// Written in it.
        received: u32,
    },
    /// Its kind or its part numbers are invalid.
    #[error("a datagram with a kind or part number that is none")]
    Header,
}

impl Kind {
    fn code(self) -> u8 {
        match self {
            Self::Record => 1,
            Self::Announcement => 2,
            Self::Machine => 3,
        }
    }

    fn from_code(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::Record),
            2 => Some(Self::Announcement),
            3 => Some(Self::Machine),
            _ => None,
        }
    }
}

impl<'a> MessagePart<'a> {
    /// Writes the datagram over whatever is in `out`.
    pub fn write(&self, out: &mut Datagram) {
        out.clear();
        let payload = self.payload.get(..PAYLOAD_MAX_BYTES);
        let kind = [VERSION, self.kind.code(), self.part, self.parts];
        let numbers = [self.boot, self.sequence, self.schema, self.lost].map(u32::to_le_bytes);
        let fields: [&[u8]; 4] = [
            &MAGIC,
            &kind,
            numbers.as_flattened(),
            payload.unwrap_or(self.payload),
        ];
        for bytes in fields {
            // The lengths add up to no more than the capacity.
            let _ = out.extend_from_slice(bytes);
        }
        let checksum = CHECKSUM.checksum(out).to_le_bytes();
        let _ = out.extend_from_slice(&checksum);
    }

    /// Reads a datagram.
    pub fn read(datagram: &'a [u8]) -> Result<Self, DatagramError> {
        let (magic, rest) = take::<4>(datagram).ok_or(DatagramError::Foreign)?;
        if magic != MAGIC {
            return Err(DatagramError::Foreign);
        }
        let length = DatagramError::Length {
            most: DATAGRAM_MAX_BYTES,
            received: datagram.len(),
        };
        // The version comes before all else: another one may have another layout.
        let ([version], _) = take::<1>(rest).ok_or(length)?;
        if version != VERSION {
            return Err(DatagramError::Version {
                expected: VERSION,
                received: version,
            });
        }
        let (body, checksum) = datagram.split_last_chunk().ok_or(length)?;
        if body.len() < HEADER_BYTES || datagram.len() > DATAGRAM_MAX_BYTES {
            return Err(length);
        }
        let (expected, received) = (CHECKSUM.checksum(body), u32::from_le_bytes(*checksum));
        if expected != received {
            return Err(DatagramError::Checksum { expected, received });
        }
        Self::fields(body).ok_or(DatagramError::Header)
    }

    /// The fields of an undamaged datagram.
    fn fields(body: &'a [u8]) -> Option<Self> {
        let ([.., kind, part, parts], rest) = take::<8>(body)?;
        let (boot, rest) = take::<4>(rest)?;
        let (sequence, rest) = take::<4>(rest)?;
        let (schema, rest) = take::<4>(rest)?;
        let (lost, payload) = take::<4>(rest)?;
        let part = Self {
            kind: Kind::from_code(kind)?,
            part,
            parts,
            boot: u32::from_le_bytes(boot),
            sequence: u32::from_le_bytes(sequence),
            schema: u32::from_le_bytes(schema),
            lost: u32::from_le_bytes(lost),
            payload,
        };
        (part.part < part.parts).then_some(part)
    }
}

fn take<const N: usize>(bytes: &[u8]) -> Option<([u8; N], &[u8])> {
    bytes
        .split_first_chunk()
        .map(|(first, rest)| (*first, rest))
}
