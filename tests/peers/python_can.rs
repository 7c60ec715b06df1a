//! python-can's SLCAN client with a sensor of its own behind it, whose units are not SI and whose
//! matrix couples the axes.

use softdock_analysis::recording::Recording;
use softdock_control::modes::Mode;
use softdock_tests::peers::python::sensor;
use softdock_tests::peers::{BUSY_COMPUTER, Board, Robot};

/// Cycles of the start ramp, with some to spare.
const RAMP: usize = 40;

#[test]
fn the_board_reads_what_the_sensor_shows() {
    let mut board = Board::start("python_can", BUSY_COMPUTER, &["--start"]);
    let mut sensor = sensor(&board.folder, board.can);
    board.process.wait_for("sensor Running");

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
