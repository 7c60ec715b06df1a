//! A checksum by which plans, factors and parts are told apart.

use crc::{CRC_64_XZ, Crc, Table};

/// A checksum over texts.
pub(super) fn checksum(texts: &[&[u8]]) -> u64 {
    // Sixteen bytes at a time: the program has a hundred million.
    const CRC: Crc<u64, Table<16>> = Crc::<u64, Table<16>>::new(&CRC_64_XZ);
    let mut digest = CRC.digest();
    for text in texts {
        digest.update(&(text.len() as u64).to_le_bytes());
        digest.update(text);
    }
    digest.finalize()
}
