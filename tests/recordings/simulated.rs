//! Recordings of simulated runs: what was computed is in single precision in the file, and has all digits when it is read.

use super::replay::{BOUNCE, flip};
use super::sample::{exact, file_of, read};
use proptest::prelude::*;
use softdock_app::record::CycleRecord;
use softdock_io::recording::{FORMAT, Recording, RecordingWriter};
use softdock_io::replay::{FirstDifference, replay};

/// The file of a simulated run.
fn simulated(recording: &Recording) -> Vec<u8> {
    let writer = RecordingWriter::new(Vec::new(), &recording.header).unwrap();
    let mut writer = writer.simulated();
    for cycle in &recording.cycles {
        writer.push(cycle, None).unwrap();
    }
    writer.finish().unwrap()
}

#[test]
fn all_digits_come_back() {
    let file = simulated(&BOUNCE);
    let back = read(&file).unwrap();
    assert_eq!(exact(&back), exact(&*BOUNCE));
    assert!(replay(&back).unwrap().identical);
    // Of a copy, too, which has everything in full.
    let full = file_of(&back);
    assert_eq!(exact(&read(&full).unwrap()), exact(&*BOUNCE));
    let (short, long) = (file.len(), full.len());
    assert!(4 * short < 3 * long, "{short} and {long} bytes");
}

#[test]
fn as_much_comes_back_as_is_left_of_a_file() {
    let file = simulated(&BOUNCE);
    for byte in (0..file.len()).step_by(997) {
        let left = read(&file[..byte]).unwrap();
        let whole = &BOUNCE.cycles[..left.cycles.len()];
        assert_eq!(exact(&left.cycles), exact(&whole), "cut at {byte}");
        assert_eq!(left.rounded, None);
    }
}

/// What does not begin with the board's first cycle cannot be computed again.
#[test]
fn a_later_piece_is_in_full() {
    let piece = Recording {
        cycles: BOUNCE.cycles[200..].to_vec(),
        ..BOUNCE.clone()
    };
    let file = simulated(&piece);
    assert_eq!(file, file_of(&piece));
    assert_eq!(exact(&read(&file).unwrap()), exact(&piece));
}

/// What other programs see: the measured motion in full, what was computed in single precision.
#[test]
fn the_schemas_say_how_many_digits_there_are() {
    let summary = mcap::Summary::read(&simulated(&BOUNCE)).unwrap().unwrap();
    let schema = |topic: &str| {
        let mut channels = summary.channels.values();
        let channel = channels.find(|channel| channel.topic == topic).unwrap();
        let schema = channel.schema.as_ref().unwrap();
        let text = String::from_utf8(schema.data.to_vec()).unwrap();
        (schema.name.clone(), text)
    };
    let (name, text) = schema("/command");
    assert_eq!(name, "softdock/msg/Command32");
    for line in [
        "\ngeometry_msgs/Point32 position_m\n",
        "\nsoftdock/QuaternionWxyz32 orientation\n",
        "\nMSG: geometry_msgs/Point32\nfloat32 x\n",
    ] {
        assert!(text.contains(line), "{line:?}: {text}");
    }
    assert!(!text.contains("float64"), "{text}");
    for topic in ["/motion", "/inputs/robot", "/status"] {
        assert!(!schema(topic).1.contains("float32"), "{topic}");
    }
    assert!(schema("/checksum").1.contains("\nuint32 crc32\n"));
}

/// Nothing in single precision is taken for all digits.
#[test]
fn a_file_without_its_checksums_is_refused() {
    let mut writer = mcap::WriteOptions::new()
        .profile("ros2")
        .create(std::io::Cursor::new(Vec::new()))
        .unwrap();
    let file = simulated(&BOUNCE);
    let entries = [
        ("format", FORMAT),
        ("identity", ""),
        ("settings", BOUNCE.header.settings_toml.as_str()),
    ];
    let metadata = mcap::records::Metadata {
        name: "softdock".into(),
        metadata: entries.map(|(k, v)| (k.into(), v.into())).into(),
    };
    writer.write_metadata(&metadata).unwrap();
    for message in mcap::MessageStream::new(&file).unwrap() {
        let message = message.unwrap();
        if message.channel.topic != "/checksum" {
            writer.write(&message).unwrap();
        }
    }
    writer.finish().unwrap();
    let error = format!("{:#}", read(&writer.into_inner().into_inner()).unwrap_err());
    let expected = "`/inputs/robot` comes twice before `/checksum`";
    assert!(error.contains(expected), "{error}");
}

fn rounded(x: f64) -> f64 {
    f64::from(x as f32)
}

/// A version that computes otherwise says so, and gives what the file has.
#[test]
fn another_version_gets_seven_digits() {
    let mut other = BOUNCE.clone();
    let settings = &mut other.header.settings_toml;
    *settings = settings.replace("400.0", "400.1");
    let found = read(&simulated(&other)).unwrap();
    let place = found.rounded.unwrap().place;
    let same = |c: &[CycleRecord; 2]| exact(&c[0].trace) == exact(&c[1].trace);
    let pairs = || {
        found
            .cycles
            .iter()
            .zip(&BOUNCE.cycles)
            .map(|(a, b)| [*a, *b])
    };
    assert!(
        place > 15 && pairs().take(place).all(|pair| same(&pair)),
        "{place}"
    );
    for [found, expected] in pairs().skip(place) {
        let (found, expected) = (found.trace, expected.trace);
        assert_eq!(found.command_pose, expected.command_pose.map(rounded));
        assert_eq!(found.law_velocity, expected.law_velocity.map(rounded));
        assert_eq!((found.pose, found.time_s), (expected.pose, expected.time_s));
    }
    let notes: Vec<String> = found.notes().collect();
    assert!(
        notes[0].starts_with(&format!(
            "From cycle {place} on, this version computes other numbers"
        )),
        "{notes:?}"
    );
    let report = replay(&found).unwrap();
    assert_eq!(report.first_difference.unwrap().cycle, place as u64);
}

/// The first difference that a replay finds in the file of a run in which a bit was another.
fn found_of(cycle: usize, place: usize, bit: u32) -> (Recording, &'static str, FirstDifference) {
    let mut recording = BOUNCE.clone();
    let quantity = flip(&mut recording.cycles[cycle], place, bit);
    let found = read(&simulated(&recording)).unwrap();
    let first = replay(&found).unwrap().first_difference.unwrap();
    (found, quantity, first)
}

#[test]
fn a_difference_is_named_if_single_precision_has_it() {
    let (_, quantity, first) = found_of(300, 4, 40);
    assert_eq!(first.quantity, quantity);
    let (_, _, first) = found_of(300, 4, 3);
    assert_eq!(first.quantity, "checksum_crc32");
}

proptest! {
    /// Whatever it was that was computed otherwise, from there on and not before.
    #[test]
    fn one_flipped_bit_is_found(cycle in 0..500_usize, place in 0..8_usize, bit in 0..64_u32) {
        let (found, quantity, first) = found_of(cycle, place, bit);
        let before = found.cycles.iter().zip(&BOUNCE.cycles).take(cycle);
        for (found, expected) in before {
            prop_assert_eq!(exact(found), exact(expected));
        }
        prop_assert_eq!(first.cycle, cycle as u64);
        let computed = (2..6).contains(&place);
        prop_assert!(first.quantity == quantity || computed && first.quantity == "checksum_crc32");
        prop_assert_eq!(found.rounded.map(|r| r.place), computed.then_some(cycle));
        prop_assert_ne!(first.recorded, first.recomputed);
    }
}
