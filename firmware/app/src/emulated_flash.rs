//! What lies where in the emulated flash of a board in QEMU, for its firmware and for the launcher
//! that writes it.
//!
//! | offset | what |
//! |---|---|
//! | 0 | the settings: a block of [`crate::image`] |
//! | 1 MiB | the boot options: a block of [`BootOptions`] |

use crate::checksum::CHECKSUM;

/// Size of the emulated flash, bytes.
pub const FLASH_BYTES: usize = 16 << 20;
/// Where the settings lie.
pub const SETTINGS_OFFSET: usize = 0;
/// Where the boot options lie: beyond what slots of settings may ever take.
pub const BOOT_OPTIONS_OFFSET: usize = 1 << 20;

/// Length of a block of boot options, bytes.
pub const BOOT_OPTIONS_BYTES: usize = 9;
/// First bytes of the block.
const MAGIC: [u8; 4] = *b"SDB1";
/// Flag in the fifth byte.
const START: u8 = 1;

/// What the launcher asks of the firmware. A board with real flash has none of it: there, it is a
/// person who starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BootOptions {
    /// Arm and start as soon as robot and sensor are healthy.
    pub start: bool,
}

impl BootOptions {
    /// The block: magic, flags, CRC-32 (ISO-HDLC, little-endian) of both.
    pub fn encode(self) -> [u8; BOOT_OPTIONS_BYTES] {
        let [m0, m1, m2, m3] = MAGIC;
        let flags = u8::from(self.start) * START;
        let [c0, c1, c2, c3] = CHECKSUM.checksum(&[m0, m1, m2, m3, flags]).to_le_bytes();
        [m0, m1, m2, m3, flags, c0, c1, c2, c3]
    }

    /// Reads a block at the start of `bytes`. Anything but a whole block asks for nothing.
    pub fn decode(bytes: &[u8]) -> Self {
        let block: Option<&[u8; BOOT_OPTIONS_BYTES]> = bytes.first_chunk();
        let started = Self { start: true };
        match block == Some(&started.encode()) {
            true => started,
            false => Self::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_back() {
        for start in [false, true] {
            let options = BootOptions { start };
            let mut bytes = options.encode().to_vec();
            bytes.extend([0xff; 10]);
            assert_eq!(BootOptions::decode(&bytes), options);
        }
    }

    #[test]
    fn a_damaged_block_starts_nothing() {
        let block = BootOptions { start: true }.encode();
        for bit in 0..block.len() * 8 {
            let mut damaged = block;
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(!BootOptions::decode(&damaged).start, "bit {bit}");
        }
        for length in 0..block.len() {
            assert!(!BootOptions::decode(&block[..length]).start);
        }
        assert!(!BootOptions::decode(&[0xff; 16]).start);
    }
}
