//! Recordings in files of a bounded size.

use softdock_tests::peers::{BUSY_COMPUTER, Board, Robot};
use softdock_tests::process::{done, json, scratch};
use std::path::Path;

/// Of 250 cycles.
const PIECES: [&str; 3] = ["run.mcap", "run-2.mcap", "run-3.mcap"];

/// In whatever order they are given, as by a shell.
fn assert_replayed(folder: &Path) {
    let mut given = PIECES;
    given.sort_unstable();
    assert_ne!(given, PIECES);
    let replayed = json(folder, &[["replay"].as_slice(), &given].concat());
    assert_eq!(
        (&replayed["identical"], &replayed["cycles"]),
        (&true.into(), &250.into())
    );
}

/// 250 cycles of a run, 100 in a file: whole pieces that replay together, bit for bit.
#[test]
fn the_pieces_of_a_run_replay_together() {
    let folder = scratch("run_pieces");
    done(&folder, &["init", "rig"]);
    let run = ["run", "rig/scenario.toml", "--duration-s", "1"];
    let pieces = ["-o", "run.mcap", "--piece-cycles", "100"];
    let ran = json(&folder, &[run.as_slice(), &pieces].concat());
    assert_eq!(ran["pieces"], serde_json::json!(PIECES));
    assert_replayed(&folder);
    // A short run has one file, and says nothing of pieces.
    let short = json(&folder, &[run.as_slice(), &["-o", "short.mcap"]].concat());
    assert_eq!(short.get("pieces"), None);
}

#[test]
fn the_pieces_of_a_board_replay_together() {
    let pieces = ["--piece-cycles", "100"];
    let board = Board::start("board_pieces", BUSY_COMPUTER, &pieces);
    let mut robot = Robot::new(board.robot);
    for _ in 0..250 {
        robot.cycle();
    }
    let folder = board.folder.clone();
    board.stop();
    assert_replayed(&folder);
}
