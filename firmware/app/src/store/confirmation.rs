//! The word after a block on trial that confirms it.
//!
//! | bytes | what |
//! |---|---|
//! | 4 | "SDOK" |
//! | 4 | sequence of the block |
//! | 4 | checksum of the block |
//! | 4 | CRC-32 (ISO-HDLC) of everything before |
//!
//! Numbers are little-endian; the rest of the word is erased flash.

use crate::checksum::CHECKSUM;

/// The smallest unit that the STM32H7's flash writes at once, and only once between two erasures (RM0433, 4.3.9); other flash
/// writes smaller units, and can write this one as well.
pub const WORD_BYTES: usize = 32;

const MAGIC: [u8; 4] = *b"SDOK";
/// Erased flash.
pub(super) const ERASED: u8 = 0xff;

/// The word for a block.
pub(super) fn word(sequence: u32, checksum: u32) -> [u8; WORD_BYTES] {
    let body = [MAGIC, sequence.to_le_bytes(), checksum.to_le_bytes()];
    let check = CHECKSUM.checksum(body.as_flattened()).to_le_bytes();
    let mut word = [ERASED; WORD_BYTES];
    for (byte, value) in word
        .iter_mut()
        .zip(body.as_flattened().iter().chain(&check))
    {
        *byte = *value;
    }
    word
}
