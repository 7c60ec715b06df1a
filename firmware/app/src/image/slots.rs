//! Two places for settings, so that one of them is intact while the other is written.

use super::{Image, ImageError};

/// A place for settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The first place.
    A,
    /// The second place.
    B,
}

impl Slot {
    /// The other place.
    pub fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// The newer of the usable blocks in the two places, and its place. If neither can be used, the error of one: rather a damage
/// than an absence. Sequences wrap: 0 is newer than [`u32::MAX`].
pub fn newest(a: &[u8], b: &[u8]) -> Result<(Image, Slot), ImageError> {
    newest_of(Image::decode(a), Image::decode(b))
}

/// The same for decoded blocks.
pub(crate) fn newest_of(
    a: Result<Image, ImageError>,
    b: Result<Image, ImageError>,
) -> Result<(Image, Slot), ImageError> {
    match (a, b) {
        (Ok(a), Ok(b)) if newer(b.sequence, a.sequence) => Ok((b, Slot::B)),
        (Ok(a), _) => Ok((a, Slot::A)),
        (Err(_), Ok(b)) => Ok((b, Slot::B)),
        (Err(ImageError::Absent), Err(b)) => Err(b),
        (Err(a), Err(_)) => Err(a),
    }
}

/// Whether `this` comes after `other`, with wrapping.
fn newer(this: u32, other: u32) -> bool {
    this != other && this.wrapping_sub(other) <= u32::MAX / 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::IMAGE_MAX_BYTES;
    use crate::settings::BoardSettings;

    fn block(sequence: u32) -> Vec<u8> {
        let settings = BoardSettings::default();
        let mut bytes = vec![0xff; IMAGE_MAX_BYTES];
        Image { sequence, settings }.encode(&mut bytes).unwrap();
        bytes
    }

    fn slot(a: &[u8], b: &[u8]) -> (u32, Slot) {
        let (image, slot) = newest(a, b).unwrap();
        (image.sequence, slot)
    }

    #[test]
    fn the_newer_block_wins_wherever_it_lies() {
        assert_eq!(slot(&block(4), &block(5)), (5, Slot::B));
        assert_eq!(slot(&block(5), &block(4)), (5, Slot::A));
        assert_eq!(slot(&block(4), &block(400)), (400, Slot::B));
        assert_eq!(slot(&block(u32::MAX), &block(0)), (0, Slot::B));
    }

    #[test]
    fn a_damaged_block_leaves_the_other() {
        let mut damaged = block(9);
        damaged[100] ^= 1;
        assert_eq!(slot(&damaged, &block(8)), (8, Slot::B));
        assert_eq!(slot(&block(8), &damaged), (8, Slot::A));
    }

    #[test]
    fn without_a_usable_block_the_damage_is_told() {
        let (erased, cut) = (&[0xff; 64][..], &block(1)[..50]);
        assert_eq!(newest(erased, erased), Err(ImageError::Absent));
        for (a, b) in [(erased, cut), (cut, erased)] {
            let error = newest(a, b).unwrap_err();
            assert!(matches!(error, ImageError::Length { .. }), "{error}");
        }
    }
}
