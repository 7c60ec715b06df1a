//! Files that were cut off or damaged, and bytes that never were a recording.

use super::sample::{Source, exact, file_of, read};
use proptest::prelude::*;
use softdock_io::recording::Recording;
use std::sync::LazyLock;

/// Three chunks: 64, 64 and 2 cycles.
static WHOLE: LazyLock<Recording> = LazyLock::new(|| Source(7).recording(130, true));
static CYCLES: LazyLock<Vec<String>> = LazyLock::new(|| WHOLE.cycles.iter().map(exact).collect());
static FILE: LazyLock<Vec<u8>> = LazyLock::new(|| file_of(&WHOLE));

/// Begin and end of each chunk: records of MCAP are opcode, length and content.
static PLACES: LazyLock<Vec<(usize, usize)>> = LazyLock::new(|| {
    let (mut places, mut begin) = (Vec::new(), mcap::MAGIC.len());
    while let Some((opcode, rest)) = FILE[begin..].split_first() {
        let Some(length) = rest.first_chunk() else {
            break;
        };
        let end = begin + 9 + u64::from_le_bytes(*length) as usize;
        if *opcode == mcap::records::op::CHUNK {
            places.push((begin, end));
        }
        begin = end;
    }
    places
});

/// End of each chunk in the file and the cycles up to there.
static CHUNKS: LazyLock<Vec<(usize, usize)>> = LazyLock::new(|| {
    let ends = PLACES.iter().map(|(_, end)| *end);
    ends.zip([64, 128, 130]).collect()
});

/// Where the first chunk begins.
static HEADER_END: LazyLock<usize> = LazyLock::new(|| PLACES[0].0);

/// What is left is whole, and it is all that can be left.
fn check_cut_at(byte: usize) {
    let found = read(&FILE[..byte]).unwrap();
    let mut whole = CHUNKS.iter().rev().filter(|(end, _)| *end <= byte);
    let cycles = whole.next().map_or(0, |(_, cycles)| *cycles);
    assert_eq!(found.cycles.len(), cycles, "cut at {byte}");
    assert_eq!(found.truth.len(), cycles, "cut at {byte}");
    if let Some(last) = found.cycles.last() {
        assert_eq!(exact(last), CYCLES[cycles - 1], "cut at {byte}");
        assert_eq!(found.header, WHOLE.header, "cut at {byte}");
    }
    let told = found.cut.unwrap();
    let counted = match cycles {
        0 => "no cycle is whole".to_owned(),
        _ => format!("{cycles} cycles up to {:.3} s", (cycles - 1) as f64 * 0.004),
    };
    assert!(told.starts_with(&counted), "cut at {byte}: {told}");
}

#[test]
fn cut_off_in_magic_header_metadata_and_footer() {
    let end = FILE.len();
    // The footer and the magic are the last 37 bytes.
    for byte in (0..*HEADER_END + 100).chain(end - 300..end) {
        check_cut_at(byte);
    }
    assert_eq!(read(&FILE).unwrap().cut, None);
}

#[test]
fn cut_off_around_the_ends_of_chunks() {
    for (end, _) in CHUNKS.iter() {
        for byte in end - 40..end + 40 {
            check_cut_at(byte);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn cut_off_anywhere(place in 0.0..1.0_f64) {
        check_cut_at((place * FILE.len() as f64) as usize);
    }

    /// One wrong bit is never taken for data, wherever it is.
    #[test]
    fn a_flipped_bit_is_found(place in 0.0..1.0_f64, bit in 0..8_u32) {
        let mut file = FILE.clone();
        let byte = (place * file.len() as f64) as usize;
        file[byte] ^= 1 << bit;
        if let Ok(found) = read(&file) {
            prop_assert!(found.cut.is_some(), "bit {} of byte {}", bit, byte);
            for cycle in &found.cycles {
                prop_assert_eq!(&exact(cycle), &CYCLES[cycle.trace.cycle as usize]);
            }
        }
    }

    #[test]
    fn any_bytes_are_no_recording(bytes: Vec<u8>) {
        prop_assert_eq!(read(&bytes).is_ok(), mcap::MAGIC.starts_with(&bytes));
    }

    /// A chunk without checksum is believed; what is in it is not.
    #[test]
    fn any_records_in_a_chunk_are_survived(
        records in prop::collection::vec((1..16_u8, any::<Vec<u8>>(), any::<u64>()), 0..4),
    ) {
        let mut content = Vec::new();
        for (opcode, bytes, lie) in records {
            let length = if lie % 2 == 0 { bytes.len() as u64 } else { lie };
            content.push(opcode);
            content.extend_from_slice(&length.to_le_bytes());
            content.extend_from_slice(&bytes);
        }
        let size = content.len() as u64;
        let mut chunk = vec![0; 16];
        chunk.extend_from_slice(&size.to_le_bytes());
        chunk.extend_from_slice(&[0; 8]);
        chunk.extend_from_slice(&size.to_le_bytes());
        chunk.extend_from_slice(&content);

        let mut file = FILE[..*HEADER_END].to_vec();
        file.push(mcap::records::op::CHUNK);
        file.extend_from_slice(&(chunk.len() as u64).to_le_bytes());
        file.extend_from_slice(&chunk);
        if let Ok(found) = read(&file) {
            prop_assert!(found.cut.is_some());
            prop_assert!(found.cycles.is_empty());
        }
    }

    /// Bytes that are believed for a while: the beginning of a file, then anything.
    #[test]
    fn any_end_of_a_file_is_survived(
        keep in 0..1000_usize,
        opcode in 0..16_u8,
        length in prop_oneof![0..200_u64, any::<u64>()],
        bytes: Vec<u8>,
    ) {
        let mut file = FILE[..keep].to_vec();
        file.push(opcode);
        file.extend_from_slice(&length.to_le_bytes());
        file.extend_from_slice(&bytes);
        if let Ok(found) = read(&file) {
            prop_assert!(found.cut.is_some());
            prop_assert!(found.cycles.is_empty());
        }
    }
}

/// Every bit of the parts that no chunk's checksum covers: magic, header, metadata, summary.
#[test]
fn a_flipped_bit_outside_of_chunks_is_found() {
    let end = FILE.len();
    for byte in (0..*HEADER_END).chain(end - 200..end) {
        for bit in 0..8 {
            let mut file = FILE.clone();
            file[byte] ^= 1 << bit;
            let told = read(&file).map_or(true, |found| found.cut.is_some());
            assert!(told, "bit {bit} of byte {byte} of {end}");
        }
    }
}
