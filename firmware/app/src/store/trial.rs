//! Settings on trial, as handed over from one start to the next.

use crate::checksum::CHECKSUM;
use crate::image::Slot;

/// Length of the bytes of a trial.
pub const TRIAL_BYTES: usize = 16;
const BODY_BYTES: usize = TRIAL_BYTES - 4;

/// Settings that were written and not confirmed yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trial {
    /// Their slot.
    pub slot: Slot,
    /// Number of the set.
    pub sequence: u32,
    /// Checksum of their block.
    pub checksum: u32,
    /// Time within which they have to be confirmed, from the start on, s.
    pub confirm_within_s: u16,
}

impl Trial {
    /// Bytes for memory that survives a reset.
    pub fn encode(&self) -> [u8; TRIAL_BYTES] {
        let [s0, s1, s2, s3] = self.sequence.to_le_bytes();
        let [c0, c1, c2, c3] = self.checksum.to_le_bytes();
        let [t0, t1] = self.confirm_within_s.to_le_bytes();
        let slot = u8::from(self.slot == Slot::B);
        let body: [u8; BODY_BYTES] = [b'T', slot, s0, s1, s2, s3, c0, c1, c2, c3, t0, t1];
        let [k0, k1, k2, k3] = CHECKSUM.checksum(&body).to_le_bytes();
        let [b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11] = body;
        [
            b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11, k0, k1, k2, k3,
        ]
    }

    /// Reads the bytes of [`Self::encode`]. `None` if they are invalid, as after power-up.
    pub fn decode(bytes: &[u8; TRIAL_BYTES]) -> Option<Self> {
        let &[_, slot, s0, s1, s2, s3, c0, c1, c2, c3, t0, t1, ..] = bytes;
        let trial = Self {
            slot: match slot {
                0 => Slot::A,
                _ => Slot::B,
            },
            sequence: u32::from_le_bytes([s0, s1, s2, s3]),
            checksum: u32::from_le_bytes([c0, c1, c2, c3]),
            confirm_within_s: u16::from_le_bytes([t0, t1]),
        };
        (trial.encode() == *bytes).then_some(trial)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_comes_back_and_nothing_else_does() {
        let trial = Trial {
            slot: Slot::B,
            sequence: 0x0102_0304,
            checksum: 0xa0b0_c0d0,
            confirm_within_s: 300,
        };
        let other = Trial {
            slot: Slot::A,
            ..trial
        };
        assert_eq!(Trial::decode(&other.encode()), Some(other));
        let bytes = trial.encode();
        assert_eq!(Trial::decode(&bytes), Some(trial));
        for bit in 0..8 * TRIAL_BYTES {
            let mut damaged = bytes;
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Trial::decode(&damaged), None, "bit {bit}");
        }
        assert_eq!(Trial::decode(&[0; TRIAL_BYTES]), None);
        assert_eq!(Trial::decode(&[0xff; TRIAL_BYTES]), None);
    }
}
