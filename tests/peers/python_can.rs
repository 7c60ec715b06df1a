//! A sensor in Python, whose units are not SI and whose matrix couples the axes: on python-can's SLCAN client, and
//! behind an SLCAN adapter that the board opens.

use softdock_control::modes::Mode;
use softdock_io::recording::Recording;
use softdock_tests::peers::python::{adapter, sensor};
use softdock_tests::peers::{BUSY_COMPUTER, Board, Robot};
use softdock_tests::process::{Running, scratch, softdock_binary, words};
use std::process::Command;

/// Cycles of the start ramp, with some to spare.
const RAMP: usize = 40;

#[test]
fn the_board_reads_what_the_sensor_shows() {
    let mut board = Board::start("python_can", BUSY_COMPUTER, &["--start"]);
    let sensor = sensor(&board.folder, board.can);
    board.process.wait_for("sensor Running");
    reads_what_is_shown(board, sensor);
}

#[test]
fn the_board_opens_an_adapter_on_a_serial_line() {
    let (sensor, place) = adapter(&scratch("slcan_serial"), "serial");
    let mut board = Board::start_with_can("slcan_serial", BUSY_COMPUTER, &place, &["--start"]);
    board.process.wait_for("sensor Running");
    let mut sensor = reads_what_is_shown(board, sensor);
    // Whoever comes next finds a channel that can be set up.
    sensor.wait_for("closed");
}

/// An adapter on the network that goes away comes back with a closed channel.
#[test]
fn an_adapter_that_went_away_is_opened_again() {
    // Answers are lost after 20 ms here, so that the sensor is asked again at once.
    let patient = BUSY_COMPUTER.replace("answer_timeout_s = 1.0", "answer_timeout_s = 0.02");
    let (mut sensor, place) = adapter(&scratch("slcan_tcp"), "tcp");
    let mut board = Board::start_with_can("slcan_tcp", &patient, &place, &["--start"]);
    board.process.wait_for("sensor Running");
    sensor.say("drop");
    board.process.wait_for("has gone");
    board.process.wait_for("SLCAN channel opened");
    let log = board.process.transcript();
    assert!(!log.contains("refused"), "{log}");
    reads_what_is_shown(board, sensor);
}

#[test]
fn an_adapter_that_is_not_there_is_said_at_once() {
    for (place, said) in [
        ("/dev/no-such-adapter", "there is no such port"),
        ("tcp:127.0.0.1:1", "cannot connect to 127.0.0.1:1"),
    ] {
        let folder = scratch("slcan_absent");
        std::fs::write(folder.join("board.toml"), BUSY_COMPUTER).unwrap();
        let arguments = words("board --settings board.toml --robot 127.0.0.1:0");
        let output = Command::new(softdock_binary())
            .current_dir(&folder)
            .args(arguments)
            .args(["--can", place])
            .output()
            .unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && error.contains(said),
            "{place}: {error}"
        );
        assert!(error.contains("the SLCAN adapter"), "{error}");
    }
}

fn reads_what_is_shown(mut board: Board, mut sensor: Running) -> Running {
    let mut robot = Robot::new(board.robot);
    board.cycles_until(&mut robot, "mode Running");
    // No contact is allowed during the start ramp.
    for _ in 0..RAMP {
        robot.cycle();
    }
    sensor.say("force 12.5 -3 40 150");
    let mut cycles = 0;
    while sensor.heard("released ").is_none() {
        robot.cycle();
        cycles += 1;
        assert!(cycles < 1_000_000, "the sensor is not asked any more");
    }
    let (path, _) = board.stop();

    let shown = numbers_behind(&sensor.transcript(), "wrench ");
    let recording = Recording::open(&path).unwrap();
    let last = recording.cycles[recording.cycles.len() - 1];
    assert_eq!((last.trace.mode, last.trace.fault), (Mode::Running, None));
    assert!(
        last.inputs.sensor.counter > 100,
        "{} readings",
        last.inputs.sensor.counter
    );
    let mut samples = recording.cycles.iter().map(|cycle| cycle.inputs.sensor);
    let pushed = samples
        .find(|sample| sample.wrench[0] > 5.0)
        .expect("the force was never read");
    assert_eq!(pushed.status, 0);
    for (axis, (read, shown)) in pushed.wrench.iter().zip(shown).enumerate() {
        assert!(
            (read - shown).abs() < 1e-6,
            "axis {axis} reads {read}, the sensor shows {shown}"
        );
    }
    sensor
}

/// The numbers behind `word` in the sensor's output.
fn numbers_behind(log: &str, word: &str) -> Vec<f64> {
    let line = log
        .lines()
        .find_map(|line| line.strip_prefix(word))
        .expect("the sensor tells what it shows");
    line.split(' ')
        .map(|number| number.parse().unwrap())
        .collect()
}
