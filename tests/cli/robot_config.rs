//! `softdock robot-config`: the file for the robot goes to a file or to standard output, the notes
//! for the person to standard error.

use softdock_tests::process::{scratch, softdock, words};
use std::fs;

#[test]
fn the_file_follows_the_settings() {
    let folder = scratch("cli_robot_config");
    let board = ["robot-config", "--board", "192.168.1.20:49152"];
    let printed = softdock(&folder, &board);
    assert!(printed.success, "{}", printed.stderr);
    assert!(
        printed.stdout.starts_with("<ROOT>") && printed.stdout.ends_with("</ROOT>\n"),
        "{}",
        printed.stdout
    );
    assert!(printed.stdout.contains("<PORT>49152</PORT>"));
    assert!(printed.stderr.contains("#RELATIVE"), "{}", printed.stderr);

    let written = softdock(&folder, &[&board[..], &["-o", "rsi.xml"]].concat());
    assert!(
        written.success && written.stdout.is_empty(),
        "{}",
        written.stderr
    );
    assert_eq!(
        fs::read_to_string(folder.join("rsi.xml")).unwrap(),
        printed.stdout
    );

    let absolute = "[control.robot]\ncorrection_mode = \"absolute\"\n[rsi]\nsentype = \"Dock\"\n";
    fs::write(folder.join("board.toml"), absolute).unwrap();
    let other = softdock(
        &folder,
        &[&board[..], &["--settings", "board.toml"]].concat(),
    );
    assert!(
        other.stdout.contains("<SENTYPE>Dock</SENTYPE>"),
        "{}",
        other.stdout
    );
    assert!(
        other
            .stdout
            .contains("TAG=\"RKorr.X\" TYPE=\"DOUBLE\" INDX=\"1\" HOLDON=\"1\""),
        "{}",
        other.stdout
    );
    assert!(other.stderr.contains("#ABSOLUTE"), "{}", other.stderr);
}

#[test]
fn wrong_settings_are_an_error() {
    let folder = scratch("cli_robot_config_wrong");
    fs::write(folder.join("board.toml"), "[rsi]\nsentipe = \"Dock\"\n").unwrap();
    let run = softdock(
        &folder,
        &words("robot-config --settings board.toml --board 192.168.1.20:49152"),
    );
    assert_eq!((run.code, run.stdout.as_str()), (Some(1), ""));
    let expected = "board.toml:2: unknown key `sentipe` in [rsi]; did you mean `sentype`?";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
}
