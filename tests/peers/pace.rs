//! The robot is the clock: a board process keeps up with one that is faster than real time and
//! with one that is slower.

use softdock_control::modes::Mode;
use softdock_io::recording::Recording;
use softdock_tests::peers::{BUSY_COMPUTER, Board, Robot, Sensor};
use std::time::Duration;

/// Runs a board that starts by itself for so many cycles with a pause after each, and checks that
/// the loop was closed to the end and that every answer is in the recording.
fn run(test: &str, cycles: usize, pause: Duration) {
    let mut board = Board::start(test, BUSY_COMPUTER, &["--start"]);
    let sensor = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    let mut robot = Robot::new(board.robot);
    let mut answers = Vec::new();
    for _ in 0..cycles {
        answers.push(robot.cycle());
        if !pause.is_zero() {
            std::thread::sleep(pause);
        }
    }
    let (path, log) = board.stop();
    assert!(
        log.contains(&format!(
            " {cycles} cycles, 0 lost, 0 twice, 0 overtaken, 0 malformed, 0 foreign"
        )),
        "{log}"
    );
    assert!(
        sensor.readings() > cycles as u64 / 2,
        "{} readings",
        sensor.readings()
    );

    let recording = Recording::open(&path).unwrap();
    assert_eq!((recording.cut, recording.cycles.len()), (None, cycles));
    for (cycle, answer) in recording.cycles.iter().zip(&answers) {
        assert_eq!(
            (cycle.inputs.robot.counter, cycle.output.correction),
            (answer.ipoc, answer.correction)
        );
    }
    let modes: Vec<Mode> = recording.cycles.iter().map(|c| c.trace.mode).collect();
    let running = modes
        .iter()
        .position(|mode| *mode == Mode::Running)
        .expect("the loop was never closed");
    assert!(running <= 10, "hold, arm and start took {running} cycles");
    assert!(
        modes[running..].iter().all(|mode| *mode == Mode::Running),
        "the loop did not stay closed"
    );
}

#[test]
fn faster_than_real_time() {
    run("pace_fast", 5000, Duration::ZERO);
}

#[test]
fn slower_than_real_time() {
    run("pace_slow", 100, Duration::from_millis(30));
}
