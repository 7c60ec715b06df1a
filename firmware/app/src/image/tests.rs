use super::*;
use crate::settings::Text;
use proptest::prelude::*;

fn example() -> Image {
    let mut settings = BoardSettings::default();
    settings.control.sensor.tool_mass_kg = 3.25;
    settings.network.recorder = Text::try_from("192.168.1.5:49200").unwrap();
    Image {
        sequence: 7,
        settings,
    }
}

fn encoded() -> Vec<u8> {
    let mut bytes = vec![0; IMAGE_MAX_BYTES];
    let length = example().encode(&mut bytes).unwrap();
    bytes.truncate(length);
    bytes
}

#[test]
fn what_was_written_is_read_also_when_something_follows() {
    let mut bytes = encoded();
    assert_eq!(Image::decode(&bytes), Ok(example()));
    bytes.extend([0xff; 100]);
    assert_eq!(Image::decode(&bytes), Ok(example()));
}

#[test]
fn erased_flash_holds_no_settings() {
    for byte in [0x00, 0xff] {
        assert_eq!(Image::decode(&[byte; 64]), Err(ImageError::Absent));
    }
    assert_eq!(Image::decode(&[]), Err(ImageError::Absent));
}

#[test]
fn a_block_cut_off_anywhere_is_refused() {
    let bytes = encoded();
    for length in 0..bytes.len() {
        assert!(Image::decode(&bytes[..length]).is_err(), "{length} bytes");
    }
}

#[test]
fn a_block_that_is_cut_tells_how_long_it_would_be() {
    let bytes = encoded();
    for received in [HEADER_BYTES, bytes.len() - CHECKSUM_BYTES, bytes.len() - 1] {
        let error = ImageError::Length {
            expected: bytes.len(),
            received,
        };
        assert_eq!(Image::decode(&bytes[..received]), Err(error));
    }
}

#[test]
fn the_checksum_is_the_last_of_the_block() {
    let mut bytes = encoded();
    let last = bytes.last_chunk().copied().map(u32::from_le_bytes);
    bytes.extend([0xff; 100]);
    assert_eq!(checksum(&bytes), last);
}

#[test]
fn a_flipped_bit_anywhere_is_refused() {
    let bytes = encoded();
    for bit in 0..bytes.len() * 8 {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(Image::decode(&damaged).is_err(), "bit {bit}");
    }
}

#[test]
fn settings_of_another_firmware_are_refused_by_their_schema() {
    let mut bytes = encoded();
    bytes[4] ^= 1;
    let end = bytes.len() - CHECKSUM_BYTES;
    let checksum = CHECKSUM.checksum(&bytes[..end]).to_le_bytes();
    bytes[end..].copy_from_slice(&checksum);
    let expected = schema();
    let received = expected ^ 1;
    let error = ImageError::Schema { expected, received };
    assert_eq!(Image::decode(&bytes), Err(error));
}

#[test]
fn settings_out_of_range_are_not_written() {
    let mut image = example();
    image.settings.control.body_k.mass_kg = -1.0;
    let error = image.encode(&mut [0; IMAGE_MAX_BYTES]).unwrap_err();
    assert!(matches!(error, ImageError::Settings(_)), "{error}");
}

#[test]
fn too_little_room_is_an_error() {
    let length = encoded().len();
    for room in 0..length {
        assert!(example().encode(&mut vec![0; room]).is_err(), "{room}");
    }
    assert_eq!(example().encode(&mut vec![0; length]), Ok(length));
}

#[test]
fn the_schema_changes_only_with_the_settings() {
    // A change here means that blocks in the flash of boards in the field are refused: say so in
    // the notes of the release.
    assert_eq!(schema(), SCHEMA_OF_THIS_VERSION, "{:#010x}", schema());
}

/// See [`the_schema_changes_only_with_the_settings`].
const SCHEMA_OF_THIS_VERSION: u32 = 0x67c6_b1ae;

proptest! {
    #[test]
    fn any_bytes_are_survived(mut bytes in prop::collection::vec(any::<u8>(), 0..200), ours: bool) {
        if ours && bytes.len() >= 4 {
            bytes[..4].copy_from_slice(&MAGIC);
        }
        prop_assert!(Image::decode(&bytes).is_err());
    }
}
