//! Replays of a run that the control cycle itself made.

use super::sample::{file_of, read};
use proptest::prelude::*;
use softdock_app::record::{CycleRecord, Inputs, RobotReport};
use softdock_app::robot_cycle::RobotCycle;
use softdock_control::delay::LawName;
use softdock_control::io::{SensorSample, Sequence};
use softdock_control::modes::{Command, Mode};
use softdock_control::settings::Settings;
use softdock_io::recording::{Header, Recording};
use softdock_io::replay::{Replay, replay};
use std::sync::LazyLock;

/// A whole board's settings: the cycle's table and one that is none of its business. The run
/// below is made with the same settings in Rust.
const SETTINGS: &str = "
[network]
robot = \"172.31.1.147:49152\"

[control.body_k]
mass_kg = 400.0
velocity_m_s = [0.015, 0.0, 0.0]

[control.body_q]
fixed = true

[control.delay]
law = \"seed\"
";

const WALL_M: f64 = 0.002;
const STIFFNESS_N_PER_M: f64 = 80_000.0;
/// Four decimals of a millimetre.
const COUNTS_PER_M: f64 = 1e7;

/// A robot without delay runs into a spring and bounces back.
pub(super) static BOUNCE: LazyLock<Recording> = LazyLock::new(|| {
    let mut settings = Settings::default();
    settings.body_k.mass_kg = 400.0;
    settings.body_k.velocity_m_s = [0.015, 0.0, 0.0];
    settings.body_q.fixed = true;
    settings.delay.law = LawName::Seed;
    let mut controller = RobotCycle::<f64>::new(&settings).unwrap();
    let mut robot_counts = 0;
    let cycles = (0..500).map(|i| {
        let position_m = robot_counts as f64 / COUNTS_PER_M;
        let record = controller.step(&inputs(i, position_m));
        robot_counts += record.output.correction[0];
        record
    });
    Recording {
        cycles: cycles.collect(),
        header: Header {
            settings_toml: SETTINGS.to_owned(),
            ..Header::default()
        },
        ..Recording::default()
    }
});

fn inputs(cycle: u32, position_m: f64) -> Inputs {
    let force_n = -STIFFNESS_N_PER_M * (position_m - WALL_M).max(0.0);
    let word = (cycle % 7) as i16;
    Inputs {
        robot: RobotReport {
            counter: 4 * u64::from(cycle),
            sequence: match cycle {
                0 => Sequence::NewRun,
                _ => Sequence::Next,
            },
            pose: Some([position_m, 0.1, 0.2, 0.3, 0.0, -0.1]),
            late_answers: 0,
            status: 0,
        },
        sensor: SensorSample {
            counter: cycle + 1,
            wrench: [force_n, 0.0, 0.0, 0.0, 0.01, 0.0],
            counts: [word.into(), 1, 2, 3, 4, 5],
            status: 0,
            saturated: false,
        },
        command: match cycle {
            5 => Some(Command::Hold),
            10 => Some(Command::Arm),
            15 => Some(Command::Start),
            _ => None,
        },
    }
}

#[test]
fn the_run_is_one_that_matters() {
    let cycles = &BOUNCE.cycles;
    assert!(cycles.iter().all(|c| c.trace.fault.is_none()));
    assert_eq!(cycles[499].trace.mode, Mode::Running);
    let contact = |c: &CycleRecord| c.trace.wrench_at_m[0] < -20.0;
    assert!(cycles.iter().filter(|c| contact(c)).count() > 5);
    assert!(cycles[499].trace.sent_velocity[0] < -0.005, "it came back");
}

#[test]
fn a_replay_is_identical() {
    let recording = read(&file_of(&BOUNCE)).unwrap();
    let report = replay(&recording).unwrap();
    assert!(report.identical, "{report}");
    assert_eq!((report.cycles, &report.first_difference), (500, &None));
    let sentence = "All 500 cycles were recomputed; every number is identical, bit for bit.";
    assert_eq!(report.to_string(), sentence);
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["identical"], true);
    assert_eq!(json["first_difference"], serde_json::Value::Null);
}

/// The places where a bit is flipped, with the names that must be reported.
pub(super) fn flip(record: &mut CycleRecord, place: usize, bit: u32) -> &'static str {
    let flipped = |number: &mut f64| *number = f64::from_bits(number.to_bits() ^ (1 << bit));
    let trace = &mut record.trace;
    match place {
        0 => {
            record.output.correction[4] ^= 1 << bit;
            "output_correction_b_counts"
        }
        1 => {
            record.output.stop ^= true;
            "output_stop"
        }
        2 => {
            flipped(&mut trace.wrench_at_m[5]);
            "wrench_torque_z_n_m"
        }
        3 => {
            flipped(&mut trace.law_parts[6][3]);
            "law_back_angular_x_rad_s"
        }
        4 => {
            flipped(&mut trace.command_pose[6]);
            "command_orientation_z"
        }
        5 => {
            flipped(&mut trace.body_q.velocity[2]);
            "model_q_linear_z_m_s"
        }
        6 => {
            trace.limits.0 ^= 1 << (bit % 16);
            "status_limits"
        }
        _ => {
            trace.sensor_age ^= 1 << (bit % 32);
            "status_sensor_age_cycles"
        }
    }
}

proptest! {
    #[test]
    fn one_flipped_bit_is_named(cycle in 0..500_usize, place in 0..8_usize, bit in 0..64_u32) {
        let mut recording = BOUNCE.clone();
        let quantity = flip(&mut recording.cycles[cycle], place, bit);
        let report = replay(&recording).unwrap();
        prop_assert!(!report.identical);
        prop_assert_eq!(report.cycles, cycle as u64 + 1);
        let first = report.first_difference.unwrap();
        prop_assert_eq!(first.cycle, cycle as u64);
        prop_assert_eq!(first.quantity, quantity);
        prop_assert_ne!(first.recorded, first.recomputed);
        prop_assert_ne!(first.recorded_bits, first.recomputed_bits);
    }
}

#[test]
fn the_sentence_names_everything() {
    let mut recording = BOUNCE.clone();
    recording.cycles[7].output.correction[0] = 12;
    let report = replay(&recording).unwrap();
    let sentence = "Cycle 7 differs: `output_correction_x_counts` is 12 in the recording and 0 \
                    in the replay (0x000000000000000c and 0x0000000000000000).";
    assert_eq!(report.to_string(), sentence);
}

#[test]
fn other_settings_give_another_run() {
    let mut recording = BOUNCE.clone();
    let settings = &mut recording.header.settings_toml;
    *settings = settings.replace("400.0", "400.1");
    let report = replay(&recording).unwrap();
    assert!(!report.identical);
}

#[test]
fn what_cannot_be_replayed_says_why() {
    let why = |change: fn(&mut Recording)| {
        let mut recording = BOUNCE.clone();
        change(&mut recording);
        format!("{:#}", replay(&recording).unwrap_err())
    };
    let error = why(|r| drop(r.cycles.drain(..1)));
    assert!(error.contains("begins with cycle 1"), "{error}");
    let error = why(|r| r.cycles.clear());
    assert!(error.contains("no whole cycle"), "{error}");
    let error = why(|r| r.header.settings_toml.clear());
    assert!(error.contains("missing key `control`"), "{error}");
    let error = why(|r| r.header.settings_toml = "[control.robot]\ncycle_ms = 4".into());
    assert!(error.contains("cycle_ms"), "{error}");
    let error = why(|r| r.header.settings_toml = "[control.robot]\ncycle_s = 4".into());
    assert!(error.contains("robot.cycle_s"), "{error}");
}

/// The pieces of a run are replayed as one run, and only in their order.
#[test]
fn pieces_are_replayed_together() {
    let piece = |cycles: &[CycleRecord]| Recording {
        cycles: cycles.to_vec(),
        ..BOUNCE.clone()
    };
    let (first, rest) = BOUNCE.cycles.split_at(200);
    let mut whole = Replay::default();
    assert_eq!(whole.take(&piece(first)).unwrap().cycles, 200);
    let report = whole.take(&piece(rest)).unwrap();
    assert!(report.identical && report.cycles == 500, "{report}");

    let error = Replay::default()
        .take(&piece(rest))
        .unwrap_err()
        .to_string();
    assert!(error.contains("begins with cycle 200"), "{error}");
    let mut gap = Replay::default();
    gap.take(&piece(first)).unwrap();
    let error = gap.take(&piece(&rest[1..])).unwrap_err().to_string();
    assert!(
        error.contains("the one before ended with cycle 199"),
        "{error}"
    );
    let mut other = piece(rest);
    other.header.settings_toml = SETTINGS.replace("400.0", "500.0");
    let mut whole = Replay::default();
    whole.take(&piece(first)).unwrap();
    let error = whole.take(&other).unwrap_err().to_string();
    assert!(
        error.contains("settings of this recording are others"),
        "{error}"
    );
}
