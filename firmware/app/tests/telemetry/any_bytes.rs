//! Any bytes from the network are either parsed or refused.

use proptest::prelude::*;
use softdock_app::record::CycleRecord;
use softdock_app::telemetry::{
    Announcement, DATAGRAM_MAX_BYTES, Datagram, DatagramError, HEADER_BYTES, Kind, MAGIC,
    MessageError, MessagePart, VERSION, read_record,
};

fn example() -> Datagram {
    let part = MessagePart {
        kind: Kind::Record,
        part: 1,
        parts: 2,
        boot: 0x0102_0304,
        sequence: 5,
        schema: 6,
        lost: 7,
        payload: b"payload",
    };
    let mut bytes = Datagram::new();
    part.write(&mut bytes);
    bytes
}

/// The layout in the documentation, with a checksum from Python's `zlib.crc32`.
#[test]
fn known_bytes() {
    let expected = [
        b"SDKT\x01\x01\x01\x02\x04\x03\x02\x01".as_slice(),
        b"\x05\0\0\0\x06\0\0\0\x07\0\0\0payload",
        &CHECKSUM_OF_PYTHON.to_le_bytes(),
    ];
    assert_eq!(example().as_slice(), expected.concat());
}

/// See [`known_bytes`].
const CHECKSUM_OF_PYTHON: u32 = 0xd83a_861a;

#[test]
fn a_flipped_bit_anywhere_is_refused() {
    let bytes = example();
    for bit in 0..bytes.len() * 8 {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let error = MessagePart::read(&damaged).unwrap_err();
        match bit / 8 {
            0..4 => assert_eq!(error, DatagramError::Foreign),
            4 => assert!(matches!(error, DatagramError::Version { .. })),
            _ => assert!(matches!(error, DatagramError::Checksum { .. })),
        }
    }
}

#[test]
fn a_datagram_cut_off_anywhere_is_refused() {
    let bytes = example();
    for length in 0..bytes.len() {
        assert!(
            MessagePart::read(&bytes[..length]).is_err(),
            "{length} bytes"
        );
    }
}

#[test]
fn what_is_longer_than_any_datagram_is_refused() {
    let mut bytes = [MAGIC.as_slice(), &[VERSION]].concat();
    bytes.resize(DATAGRAM_MAX_BYTES + 1, 0);
    let error = DatagramError::Length {
        most: DATAGRAM_MAX_BYTES,
        received: DATAGRAM_MAX_BYTES + 1,
    };
    assert_eq!(MessagePart::read(&bytes), Err(error));
}

#[test]
fn kinds_and_part_numbers_that_are_none_are_refused() {
    for (place, value) in [(5, 0), (5, 4), (6, 2), (7, 0), (7, 1)] {
        let mut bytes = example();
        bytes[place] = value;
        let end = bytes.len() - 4;
        let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&bytes[..end]);
        bytes[end..].copy_from_slice(&checksum.to_le_bytes());
        assert_eq!(
            MessagePart::read(&bytes),
            Err(DatagramError::Header),
            "{place}: {value}"
        );
    }
}

#[test]
fn a_record_with_something_behind_it_is_refused() {
    let mut buffer = [0; 2000];
    let length = postcard::to_slice(&CycleRecord::default(), &mut buffer)
        .unwrap()
        .len();
    assert!(read_record(&buffer[..length]).is_ok());
    assert_eq!(
        read_record(&buffer[..length + 1]),
        Err(MessageError::Trailing { received: 1 })
    );
}

proptest! {
    #[test]
    fn any_datagram_is_survived(mut bytes in prop::collection::vec(any::<u8>(), 0..2000), ours: bool) {
        if ours && bytes.len() >= HEADER_BYTES {
            bytes[..4].copy_from_slice(&MAGIC);
            bytes[4] = VERSION;
        }
        prop_assert!(MessagePart::read(&bytes).is_err());
    }

    /// A valid checksum does not exclude nonsense written by the firmware.
    #[test]
    fn any_message_is_survived(bytes in prop::collection::vec(any::<u8>(), 0..3000)) {
        let _ = read_record(&bytes);
        let _ = Announcement::read(&bytes);
    }
}
