//! Logs of other programs, which are kept as a table of what changes.

use super::sample::{Source, exact, file_of, read};
use proptest::prelude::*;
use softdock_app::record::CycleRecord;
use softdock_control::modes::{Fault, FaultCode, Mode};
use softdock_io::recording::{Header, Recording};
use std::sync::LazyLock;

/// A log of one axis: position, velocity, command and force, `digits` behind the point.
fn log(rows: usize, digits: i32) -> Recording {
    let mut source = Source(11);
    let scale = 10_f64.powi(digits);
    let mut number =
        |size: f64| (size * scale * (source.below(20_001) as f64 / 1e4 - 1.0)).round() / scale;
    let cycle = |n: usize| {
        let mut cycle = CycleRecord::default();
        cycle.trace.cycle = n as u64;
        cycle.trace.time_s = n as f64 * 4.0 / 1e3;
        cycle.trace.mode = Mode::Hold;
        cycle.trace.pose = [number(0.05), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        cycle.trace.executed_velocity[0] = number(0.1);
        cycle.trace.sent_velocity[0] = number(0.1);
        cycle.inputs.sensor.wrench[0] = number(50.0);
        cycle
    };
    Recording {
        header: Header {
            identity: "imported from log.csv".into(),
            ..Header::default()
        },
        cycles: (0..rows).map(cycle).collect(),
        ..Recording::default()
    }
}

/// Three chunks.
static WHOLE: LazyLock<Recording> = LazyLock::new(|| log(40_000, 7));
static FILE: LazyLock<Vec<u8>> = LazyLock::new(|| file_of(&WHOLE));

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Whatever changes and whatever does not, in whatever time.
    #[test]
    fn everything_comes_back(seed: u64, rows in 1..50_usize, same: bool) {
        let mut source = Source(seed);
        let mut recording = source.recording(rows, false);
        recording.header.settings_toml.clear();
        let first = recording.cycles[0];
        for cycle in &mut recording.cycles {
            let (number, time_s) = (cycle.trace.cycle, cycle.trace.time_s);
            if same {
                *cycle = first;
                cycle.inputs.sensor.wrench[0] = f64::from_bits(source.bits());
                cycle.trace.time_s = time_s + 1e-12;
            }
            cycle.trace.cycle = 3 * number;
        }
        let file = file_of(&recording);
        prop_assert_eq!(exact(&read(&file).unwrap()), exact(&recording));
    }

    /// A file that was cut off holds its whole chunks, and says so.
    #[test]
    fn cut_off_anywhere(place in 0.0..1.0_f64) {
        let found = read(&FILE[..(place * FILE.len() as f64) as usize]).unwrap();
        prop_assert!(found.cut.is_some());
        prop_assert!([0, 16_384, 32_768, 40_000].contains(&found.cycles.len()));
        prop_assert_eq!(&found.cycles[..], &WHOLE.cycles[..found.cycles.len()]);
    }

    #[test]
    fn a_flipped_bit_is_found(place in 0.0..1.0_f64, bit in 0..8_u32) {
        let mut file = FILE.clone();
        let byte = (place * file.len() as f64) as usize;
        file[byte] ^= 1 << bit;
        if let Ok(found) = read(&file) {
            prop_assert!(found.cut.is_some(), "bit {} of byte {}", bit, byte);
            prop_assert_eq!(&found.cycles[..], &WHOLE.cycles[..found.cycles.len()]);
        }
    }
}

/// A number that means something only beside one that changes.
#[test]
fn the_limit_of_changing_faults_comes_back() {
    let mut recording = log(2, 3);
    let fault = |code| Some(Fault::new(code, f64::NEG_INFINITY, 2.0));
    recording.cycles[0].trace.fault = fault(FaultCode::SustainedClamp);
    recording.cycles[1].trace.fault = fault(FaultCode::Overload);
    let read = read(&file_of(&recording)).unwrap();
    assert_eq!(exact(&read), exact(&recording));
}

#[test]
fn a_number_takes_eight_bytes_and_other_programs_find_their_way() {
    let values = 4 * WHOLE.cycles.len();
    let per_value = FILE.len() as f64 / values as f64;
    assert!(per_value < 8.0, "{per_value} bytes");
    let summary = mcap::Summary::read(&FILE).unwrap().unwrap();
    let channel = summary.channels.values().next().unwrap();
    assert_eq!(
        (summary.channels.len(), channel.topic.as_str()),
        (1, "/log")
    );
    assert_eq!(channel.metadata["status_mode"], "hold");
    assert_eq!(channel.metadata["motion_orientation_w"], "1.0");
    let schema = channel.schema.as_ref().unwrap();
    let text = std::str::from_utf8(&schema.data).unwrap();
    let numbers: Vec<&str> = text.lines().filter(|l| !l.starts_with('#')).collect();
    let expected = [
        "float64 inputs_sensor_force_x_n",
        "float64 motion_position_x_m",
        "float64 motion_linear_x_m_s",
        "float64 command_linear_x_m_s",
    ];
    assert_eq!(
        (schema.name.as_str(), numbers),
        ("softdock/msg/Log", expected.to_vec())
    );
    // What a reader without an index needs: it goes through the file.
    assert!(summary.chunk_indexes.is_empty());
    let messages = mcap::MessageStream::new(&FILE).unwrap();
    let times = messages.map(|message| message.unwrap().log_time);
    assert!(times.eq((0..40_000).map(|n| n * 4_000_000)));
}

/// A chunk of a few bytes that says to hold many is not unpacked.
#[test]
fn a_forged_size_is_refused() {
    let mut file = FILE.clone();
    let mut at = mcap::MAGIC.len();
    while file[at] != mcap::records::op::CHUNK {
        at += 9 + u64::from_le_bytes(file[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    // Behind opcode, length and two times.
    file[at + 25..at + 33].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    let found = read(&file).unwrap();
    assert!(
        found.cycles.is_empty() && found.cut.is_some(),
        "{:?}",
        found.cut
    );
}
