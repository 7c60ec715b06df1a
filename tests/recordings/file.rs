//! Whole MCAP files.

use super::sample::{Source, exact, file_of, read};
use proptest::prelude::*;
use softdock_io::recording::{FORMAT, Header, Recording, RecordingWriter, WallClock};
use std::collections::BTreeMap;
use std::path::PathBuf;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn everything_comes_back(seed: u64, cycles in 0..200_usize, truth: bool) {
        let recording = Source(seed).recording(cycles, truth);
        let back = read(&file_of(&recording)).unwrap();
        prop_assert_eq!(exact(&back), exact(&recording));
    }
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn a_file_on_disk_comes_back() {
    let recording = Source(1).recording(100, true);
    let path = path("whole.mcap");
    recording.write(&path).unwrap();
    let back = Recording::open(&path).unwrap();
    assert_eq!(exact(&back), exact(&recording));
}

/// Viewers show the time of day where it is known; what is read back is the board's own time all the same.
#[test]
fn messages_carry_the_wall_clock_where_it_is_known() {
    let mut recording = Source(5).recording(100, false);
    for (cycle, number) in recording.cycles.iter_mut().zip(0u32..) {
        cycle.trace.time_s = 7.0 + f64::from(number) * 0.004;
    }
    let times = |recording: &Recording| -> Vec<u64> {
        let file = file_of(recording);
        let messages = mcap::MessageStream::new(&file).unwrap();
        let times = messages.map(|message| message.unwrap());
        let mut times: Vec<u64> = times
            .inspect(|message| assert_eq!(message.log_time, message.publish_time))
            .map(|message| message.log_time)
            .collect();
        times.dedup();
        times
    };
    for (wall_clock, first_ns) in [
        (None, 7_000_000_000),
        (
            Some(WallClock {
                unix_s: 1.7e9,
                at_time_s: 6.0,
            }),
            1_700_000_001_000_000_000,
        ),
    ] {
        recording.wall_clock = wall_clock;
        let expected: Vec<u64> = (0..100).map(|k| first_ns + k * 4_000_000).collect();
        assert_eq!(times(&recording), expected);
        let back = read(&file_of(&recording)).unwrap();
        assert_eq!(exact(&back), exact(&recording));
    }
}

#[test]
fn a_dropped_writer_leaves_a_whole_file() {
    let recording = Source(2).recording(100, false);
    let path = path("dropped.mcap");
    let mut writer = RecordingWriter::create(&path, &recording.header).unwrap();
    for cycle in &recording.cycles {
        writer.push(cycle, None).unwrap();
    }
    drop(writer);
    let back = Recording::open(&path).unwrap();
    assert_eq!(exact(&back), exact(&recording));
}

#[test]
fn what_is_cut_says_so_in_its_copy() {
    let mut recording = Source(3).recording(3, false);
    recording.cut = Some("the power went".into());
    assert_eq!(read(&file_of(&recording)).unwrap().cut, recording.cut);
}

#[test]
fn truth_for_some_cycles_only_is_refused() {
    let recording = Source(4).recording(2, true);
    let mut writer = RecordingWriter::new(Vec::new(), &recording.header).unwrap();
    let (cycles, truth) = (&recording.cycles, &recording.truth);
    writer.push(&cycles[0], Some(&truth[0])).unwrap();
    let error = writer.push(&cycles[1], None).unwrap_err().to_string();
    assert!(error.starts_with("cycle 1: the rig's truth"), "{error}");

    let mut recording = recording.clone();
    recording.truth.pop();
    let error = recording.write_to(Vec::new()).unwrap_err().to_string();
    assert!(error.contains("for all 2 cycles or for none, received 1"));
}

#[test]
fn a_missing_file_is_named() {
    let error = Recording::open("no/such.mcap".as_ref()).unwrap_err();
    assert!(error.to_string().contains("`no/such.mcap`"), "{error}");
    let error = Recording::default()
        .write("no/such.mcap".as_ref())
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("cannot write no/such.mcap: its folder does not exist"),
        "{error}"
    );
}

/// Times are nanoseconds of the run where nobody knows the time of day, one message per cycle and topic, in chunks of a quarter of
/// a second.
#[test]
fn other_programs_find_their_way() {
    let mut recording = Source(5).recording(130, true);
    recording.wall_clock = None;
    let file = file_of(&recording);
    let summary = mcap::Summary::read(&file).unwrap().unwrap();
    // What a reader without an index needs: it goes through the file.
    assert!(summary.chunk_indexes.is_empty());
    let stats = summary.stats.unwrap();
    assert_eq!(stats.chunk_count, 3);
    assert_eq!(stats.channel_message_counts.len(), 15);
    assert!(stats.channel_message_counts.values().all(|n| *n == 130));
    assert_eq!(stats.message_end_time, 129 * 4_000_000);
    for channel in summary.channels.values() {
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(channel.message_encoding, "cdr");
        assert_eq!(schema.encoding, "ros2msg");
        assert!(schema.name.starts_with("softdock/msg/"));
    }
    let mut topics: Vec<_> = summary.channels.values().map(|c| &c.topic).collect();
    topics.sort();
    let expected = [
        "/command",
        "/inputs/command",
        "/inputs/robot",
        "/inputs/sensor",
        "/law",
        "/law/status",
        "/model/docking",
        "/model/k",
        "/model/q",
        "/model/velocity",
        "/motion",
        "/output",
        "/status",
        "/truth",
        "/wrench",
    ];
    assert_eq!(topics, expected);
}

#[test]
fn another_version_is_refused_by_name() {
    let mut file = file_of(&Source(6).recording(1, false));
    let position = file
        .windows(FORMAT.len())
        .position(|w| w == FORMAT.as_bytes())
        .unwrap();
    file[position + FORMAT.len() - 1] = b'2';
    let error = read(&file).unwrap_err().to_string();
    let expected = "expected a recording of format `softdock/1`, received `softdock/2`";
    assert!(error.starts_with(expected), "{error}");
}

/// An MCAP file of another program, with anything in it.
fn foreign(
    profile: &str,
    with: impl FnOnce(&mut mcap::Writer<std::io::Cursor<Vec<u8>>>),
) -> String {
    let mut writer = mcap::WriteOptions::new()
        .profile(profile)
        .library("roverlog 3")
        .create(std::io::Cursor::new(Vec::new()))
        .unwrap();
    with(&mut writer);
    writer.finish().unwrap();
    let file = writer.into_inner().into_inner();
    format!("{:#}", read(&file).unwrap_err())
}

#[test]
fn files_of_other_programs_are_refused() {
    let error = foreign("ros1", |_| ());
    let expected = "expected profile `ros2`, received `ros1`, written by `roverlog 3`";
    assert!(error.contains(expected), "{error}");

    // A recording of a robot that is not ours, and one of ours from before.
    let error = foreign("ros2", |_| ());
    assert!(error.contains("no metadata `softdock`"), "{error}");
    let error = foreign("softdock", |_| ());
    assert!(error.contains("no metadata `softdock`"), "{error}");

    let error = foreign("softdock", |writer| {
        let id = writer.add_channel(0, "/law", "json", &BTreeMap::new());
        id.map(drop).unwrap();
    });
    assert!(error.contains("no metadata `softdock`"), "{error}");

    let error = format!("{:#}", read(b"time_s,x\n0.0,1.0\n").unwrap_err());
    assert!(error.contains("not an MCAP file"), "{error}");
}

fn our_metadata() -> mcap::records::Metadata {
    let entries = [
        ("format", FORMAT),
        ("identity", "softdock 0.0.7 (0123abc)"),
        ("settings", ""),
    ];
    mcap::records::Metadata {
        name: "softdock".into(),
        metadata: entries.map(|(k, v)| (k.into(), v.into())).into(),
    }
}

#[test]
fn a_topic_with_other_fields_is_refused() {
    let error = foreign("softdock", |writer| {
        writer.write_metadata(&our_metadata()).unwrap();
        let schema = writer.add_schema("softdock/msg/Law", "ros2msg", b"float64 x\n");
        let id = writer.add_channel(schema.unwrap(), "/law", "cdr", &BTreeMap::new());
        id.map(drop).unwrap();
    });
    for says in [
        "topic `/law` has other fields",
        "recorded by `softdock 0.0.7 (0123abc)`",
        "`softdock export RUN.mcap -o run.csv`",
        "`softdock import run.csv --mapping MAPPING.toml -o FOLDER`",
    ] {
        assert!(error.contains(says), "`{says}`: {error}");
    }
}

/// A cycle that lacks a topic is not a cycle.
#[test]
fn a_filtered_file_is_refused() {
    let file = file_of(&Source(9).recording(2, false));
    let error = foreign("softdock", |writer| {
        writer.write_metadata(&our_metadata()).unwrap();
        for message in mcap::MessageStream::new(&file).unwrap() {
            let message = message.unwrap();
            if message.channel.topic != "/law" {
                writer.write(&message).unwrap();
            }
        }
    });
    let expected = "`/inputs/robot` comes twice before `/law`";
    assert!(error.contains(expected), "{error}");
}

#[test]
fn a_recording_without_cycles_is_whole() {
    let recording = Recording {
        header: Header {
            identity: "nothing happened".into(),
            ..Header::default()
        },
        ..Recording::default()
    };
    assert_eq!(read(&file_of(&recording)).unwrap(), recording);
}
