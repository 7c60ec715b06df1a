//! All settings as one block of bytes, as they lie in a flash slot and travel to a board.
//!
//! | bytes | what |
//! |---|---|
//! | 4 | [`MAGIC`] |
//! | 4 | schema: [`schema()`] of the firmware that wrote the block |
//! | 4 | sequence: the block with the higher one is the newer |
//! | 2 | length of the payload |
//! | n | payload: [`BoardSettings`] in postcard's format |
//! | 4 | CRC-32 (ISO-HDLC) of everything before |
//!
//! Numbers are little-endian. A block is taken whole or not at all: magic, length and checksum say
//! whether it is one, the schema whether this firmware can read it, and the settings' own checks
//! whether it may be used.

mod slots;

pub(crate) use slots::newest_of;
pub use slots::{Slot, newest};

use crate::checksum::CHECKSUM;
use crate::settings::{BoardSettings, BoardSettingsError};

/// First bytes of a block.
pub const MAGIC: [u8; 4] = *b"SDK1";

/// First bytes of a block that needs a confirmation to count: see [`crate::store`].
pub const MAGIC_ON_TRIAL: [u8; 4] = *b"SDT1";

/// Longest block, bytes: the settings take about 1.4 kB.
pub const IMAGE_MAX_BYTES: usize = 4096;

const HEADER_BYTES: usize = 14;
const CHECKSUM_BYTES: usize = 4;

/// The schema of [`BoardSettings`]: it changes when their form does.
pub fn schema() -> u32 {
    crate::schema::of::<BoardSettings>().unwrap_or_default()
}

/// Why a block cannot be written or used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ImageError {
    /// There is no block: erased flash or something else.
    #[error("there are no settings")]
    Absent,
    /// The block is cut off or longer than there is room for.
    #[error("settings take {expected} bytes; there are {received}")]
    Length {
        /// Bytes that it needs.
        expected: usize,
        /// Bytes that there are.
        received: usize,
    },
    /// The block is damaged.
    #[error("settings are damaged: checksum {received:08x} in place of {expected:08x}")]
    Checksum {
        /// Computed from its bytes.
        expected: u32,
        /// Written in it.
        received: u32,
    },
    /// A firmware with other settings wrote it.
    #[error(
        "settings are of another firmware: schema {received:08x} in place of {expected:08x}; upload them again from their file"
    )]
    Schema {
        /// Of this firmware.
        expected: u32,
        /// Of the block.
        received: u32,
    },
    /// Its payload does not hold settings.
    #[error("what should be settings cannot be read")]
    Payload,
    /// The settings were on trial, and nobody confirmed them.
    #[error("settings were on trial, and nobody confirmed them")]
    NotConfirmed,
    /// The settings in it may not be used.
    #[error("{0}")]
    Settings(BoardSettingsError),
}

/// Settings of a block.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The block with the higher sequence is the newer.
    pub sequence: u32,
    /// The settings.
    pub settings: BoardSettings,
}

impl Image {
    /// Writes the block into `out` (at most [`IMAGE_MAX_BYTES`] are needed) and gives its length.
    /// Settings that may not be used are not written.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, ImageError> {
        encode(MAGIC, self.sequence, &self.settings, out)
    }

    /// Writes a block that needs a confirmation to count.
    pub(crate) fn encode_on_trial(
        sequence: u32,
        settings: &BoardSettings,
        out: &mut [u8],
    ) -> Result<usize, ImageError> {
        encode(MAGIC_ON_TRIAL, sequence, settings, out)
    }

    /// Reads a block at the start of `bytes`; bytes after it are ignored.
    pub fn decode(bytes: &[u8]) -> Result<Self, ImageError> {
        decode(MAGIC, bytes)
    }

    /// Reads a block that needs a confirmation to count.
    pub(crate) fn decode_on_trial(bytes: &[u8]) -> Result<Self, ImageError> {
        decode(MAGIC_ON_TRIAL, bytes)
    }
}

fn encode(
    magic: [u8; 4],
    sequence: u32,
    settings: &BoardSettings,
    out: &mut [u8],
) -> Result<usize, ImageError> {
    settings.validate().map_err(ImageError::Settings)?;
    let too_small = ImageError::Length {
        expected: IMAGE_MAX_BYTES,
        received: out.len(),
    };
    let room = out.get_mut(HEADER_BYTES..).ok_or(too_small)?;
    let payload = postcard::to_slice(settings, room).map_err(|_| too_small)?;
    let length = u16::try_from(payload.len()).map_err(|_| too_small)?;
    let fields: [&[u8]; 4] = [
        &magic,
        &schema().to_le_bytes(),
        &sequence.to_le_bytes(),
        &length.to_le_bytes(),
    ];
    let header = fields.into_iter().flatten();
    for (byte, value) in out.iter_mut().zip(header) {
        *byte = *value;
    }
    let end = HEADER_BYTES + usize::from(length);
    let (body, rest) = out.split_at_mut_checked(end).ok_or(too_small)?;
    let checksum = CHECKSUM.checksum(body).to_le_bytes();
    rest.get_mut(..CHECKSUM_BYTES)
        .ok_or(too_small)?
        .copy_from_slice(&checksum);
    Ok(end + CHECKSUM_BYTES)
}

fn decode(magic: [u8; 4], bytes: &[u8]) -> Result<Image, ImageError> {
    let (found_magic, rest) = take::<4>(bytes).ok_or(ImageError::Absent)?;
    if found_magic != magic {
        return Err(ImageError::Absent);
    }
    let cut = |expected| ImageError::Length {
        expected,
        received: bytes.len(),
    };
    let header = cut(HEADER_BYTES);
    let (found, rest) = take::<4>(rest).ok_or(header)?;
    let (sequence, rest) = take::<4>(rest).ok_or(header)?;
    let (length, rest) = take::<2>(rest).ok_or(header)?;
    let length = usize::from(u16::from_le_bytes(length));
    let whole = HEADER_BYTES + length + CHECKSUM_BYTES;
    let (payload, rest) = rest.split_at_checked(length).ok_or(cut(whole))?;
    let (checksum, _) = take::<CHECKSUM_BYTES>(rest).ok_or(cut(whole))?;
    let body = bytes.get(..HEADER_BYTES + length).unwrap_or_default();
    compare(CHECKSUM.checksum(body), u32::from_le_bytes(checksum))
        .map_err(|(expected, received)| ImageError::Checksum { expected, received })?;
    compare(schema(), u32::from_le_bytes(found))
        .map_err(|(expected, received)| ImageError::Schema { expected, received })?;
    let settings: BoardSettings = postcard::from_bytes(payload).map_err(|_| ImageError::Payload)?;
    settings.validate().map_err(ImageError::Settings)?;
    Ok(Image {
        sequence: u32::from_le_bytes(sequence),
        settings,
    })
}

/// The checksum that is written in the block at the start of `bytes`.
pub(crate) fn checksum(bytes: &[u8]) -> Option<u32> {
    let length = bytes.get(HEADER_BYTES - 2..)?.first_chunk::<2>()?;
    let end = HEADER_BYTES + usize::from(u16::from_le_bytes(*length));
    let checksum = bytes.get(end..)?.first_chunk::<CHECKSUM_BYTES>()?;
    Some(u32::from_le_bytes(*checksum))
}

fn take<const N: usize>(bytes: &[u8]) -> Option<([u8; N], &[u8])> {
    bytes
        .split_first_chunk()
        .map(|(first, rest)| (*first, rest))
}

fn compare(expected: u32, received: u32) -> Result<(), (u32, u32)> {
    match expected == received {
        true => Ok(()),
        false => Err((expected, received)),
    }
}

#[cfg(test)]
mod tests;
