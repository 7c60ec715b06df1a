//! Layout of the emulated flash of a board in QEMU, for its firmware and for the launcher that writes it.
//!
//! | offset | what |
//! |---|---|
//! | 0 | the first slot of [`crate::store`]; the launcher writes a block of [`crate::image`] |
//! | 128 KiB | the second slot |
//! | 1 MiB | the boot options: a block of [`BootOptions`] |

use crate::checksum::CHECKSUM;

/// Size of the emulated flash, bytes.
pub const FLASH_BYTES: usize = 16 << 20;
/// Offset of the two slots for settings, one after the other.
pub const SETTINGS_OFFSET: usize = 0;
/// Size of a slot, bytes: a sector of the STM32H743's flash.
pub const SLOT_BYTES: usize = 128 << 10;
/// Offset of the boot options: beyond all space that slots of settings may ever use.
pub const BOOT_OPTIONS_OFFSET: usize = 1 << 20;

/// Length of a block of boot options, bytes.
pub const BOOT_OPTIONS_BYTES: usize = 13;
/// First bytes of the block.
const MAGIC: [u8; 4] = *b"SDB3";
/// Flag in the fifth byte.
const START: u8 = 1;
/// Position of the number of a [`Crash`] in the fifth byte.
const CRASH_SHIFT: u32 = 1;

/// A way to crash, for tests of its report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crash {
    /// The firmware gives up by itself.
    Panic,
    /// The stack grows until it leaves its memory.
    StackOverflow,
    /// An invalid instruction.
    Fault,
}

impl Crash {
    /// All of them; their numbers are their places, from 1.
    const ALL: [Self; 3] = [Self::Panic, Self::StackOverflow, Self::Fault];

    fn number(crash: Option<Self>) -> u8 {
        let place = Self::ALL.iter().position(|known| Some(*known) == crash);
        // At most three.
        place.map_or(0, |place| place as u8 + 1)
    }

    fn of(number: u8) -> Option<Self> {
        let place = usize::from(number).checked_sub(1)?;
        Self::ALL.get(place).copied()
    }
}

/// Requests of the launcher to the firmware. A board with real flash has none: there a person starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BootOptions {
    /// Arm and start as soon as robot and sensor are healthy, at the first start.
    pub start: bool,
    /// Crash at the first start.
    pub crash: Option<Crash>,
    /// A number that differs from that of every other boot.
    pub boot: u32,
}

impl BootOptions {
    /// The block: magic, flags, boot, CRC-32 (ISO-HDLC) of all; numbers are little-endian.
    pub fn encode(self) -> [u8; BOOT_OPTIONS_BYTES] {
        let [m0, m1, m2, m3] = MAGIC;
        let flags = (u8::from(self.start) * START) | (Crash::number(self.crash) << CRASH_SHIFT);
        let [b0, b1, b2, b3] = self.boot.to_le_bytes();
        let body = [m0, m1, m2, m3, flags, b0, b1, b2, b3];
        let mut block = [0; BOOT_OPTIONS_BYTES];
        let checksum = CHECKSUM.checksum(&body).to_le_bytes();
        for (byte, value) in block.iter_mut().zip(body.into_iter().chain(checksum)) {
            *byte = value;
        }
        block
    }

    /// Reads a block at the start of `bytes`; anything but a valid block gives the default, which asks for nothing.
    pub fn decode(bytes: &[u8]) -> Self {
        let Some(&[_, _, _, _, flags, b0, b1, b2, b3, ..]) =
            bytes.first_chunk::<BOOT_OPTIONS_BYTES>()
        else {
            return Self::default();
        };
        let options = Self {
            start: flags & START != 0,
            crash: Crash::of(flags >> CRASH_SHIFT),
            boot: u32::from_le_bytes([b0, b1, b2, b3]),
        };
        match bytes.starts_with(&options.encode()) {
            true => options,
            false => Self::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_back() {
        let crashes = Crash::ALL.map(Some).into_iter().chain([None]);
        for (crash, boot) in crashes.zip([0, 1, u32::MAX, 0x1234_5678]) {
            for start in [false, true] {
                let options = BootOptions { start, crash, boot };
                let mut bytes = options.encode().to_vec();
                bytes.extend([0xff; 10]);
                assert_eq!(BootOptions::decode(&bytes), options);
            }
        }
    }

    #[test]
    fn a_damaged_block_starts_nothing() {
        let (start, crash, boot) = (true, None, 7);
        let block = BootOptions { start, crash, boot }.encode();
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
