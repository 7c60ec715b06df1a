//! Checksum that identifies plans, factors and parts.

use crc::{CRC_64_XZ, Crc, Table};

/// Checksum of several texts and their lengths.
pub(super) fn checksum(texts: &[&[u8]]) -> u64 {
    // A table for sixteen bytes at a time, as the program file has a hundred million.
    const CRC: Crc<u64, Table<16>> = Crc::<u64, Table<16>>::new(&CRC_64_XZ);
    let mut digest = CRC.digest();
    for text in texts {
        digest.update(&(text.len() as u64).to_le_bytes());
        digest.update(text);
    }
    digest.finalize()
}
