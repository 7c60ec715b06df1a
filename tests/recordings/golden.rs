//! What the program answered when it was first released, kept: a change of structure changes no bit.
//!
//! The recordings are of version 0.1.0 (`softdock run host-tools/scenarios/spring-rod.toml
//! --speed-mm-s 10 --law NAME`, 1.4 s), but for that of `predictor`, which is made anew with its law;
//! `reproduce.json` is of `softdock reproduce --json`. Where a number is meant to change, the file is made anew by
//! the same command, and the commit says why.

use crc::{CRC_64_XZ, Crc};
use softdock_app::settings::BoardSettings;
use softdock_control::delay::LawName;
use softdock_io::recording::Recording;
use softdock_io::replay::replay;
use softdock_lockstep::Session;
use softdock_tests::lockstep::story;
use softdock_tests::process::{done, scratch};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Cycles of the story: every mode, faults of the sensor and of the line, strangers, garbage.
const CYCLES: usize = 25_000;
/// Checksum of all answers to them.
const ANSWERS: u64 = 0x1e5e_8a7e_e1c5_e036;

fn kept(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/golden");
    folder.join(name)
}

#[test]
fn recordings_of_the_first_release_replay_bit_for_bit() {
    let folder = scratch("golden_recordings");
    for law in ["predictor", "seed", "lead"] {
        let file = folder.join(format!("{law}.mcap"));
        let unpacked = Command::new("gzip")
            .arg("-dc")
            .arg(kept(&format!("{law}.mcap.gz")))
            .stdout(File::create(&file).unwrap())
            .status();
        assert!(unpacked.expect("gzip is part of Debian").success());
        let found = replay(&Recording::open(&file).unwrap()).unwrap();
        assert!(found.identical, "{law}: {found}");
        assert_eq!(found.cycles, 350, "{law}");
    }
}

#[test]
fn the_papers_experiment_is_reproduced_with_the_same_numbers() {
    let folder = scratch("golden_reproduce");
    let run = done(&folder, &["reproduce", "-o", "all", "--json"]);
    let expected = fs::read_to_string(kept("reproduce.json")).unwrap();
    for (n, (received, expected)) in run.lines().zip(expected.lines()).enumerate() {
        assert_eq!(received, expected, "line {}", n + 1);
    }
    assert_eq!(run.lines().count(), expected.lines().count());
}

#[test]
fn a_board_sends_the_same_answers() {
    let mut settings = BoardSettings::default();
    settings.control.delay.law = LawName::Predictor;
    settings.control.delay.predictor.interlock = false;
    settings.control.limits.box_m = [5.0; 3];
    settings.control.limits.clamp_fault_cycles = 10_000;
    settings.control.start.max_force_n = 1000.0;
    settings.control.start.max_zero_force_n = 1000.0;
    let mut session = Session::<f64>::new(&settings).unwrap();
    let crc = Crc::<u64>::new(&CRC_64_XZ);
    let mut answers = crc.digest();
    for step in story(&settings, CYCLES) {
        answers.update(&session.take(&step, &mut ()).answer);
    }
    assert_eq!(answers.finalize(), ANSWERS);
}
