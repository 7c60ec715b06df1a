//! RSIPI's robot controller and a python-can sensor against the firmware in QEMU, at the robot's
//! pace of 4 ms.

use softdock_tests::peers::python::{RsipiRobot, sensor};
use softdock_tests::peers::{BUSY_COMPUTER, QemuBoard, counts};
use softdock_tests::process::softdock;

/// Cycles that RSIPI runs: 10 s.
const CYCLES: usize = 2500;
/// Velocity of the spacecraft, m/s.
const VELOCITY_M_S: [f64; 3] = [0.005, -0.001, 0.002];
/// Control cycle, s.
const CYCLE_S: f64 = 0.004;
const AXES: [&str; 3] = ["X", "Y", "Z"];

#[test]
#[ignore = "long: RSIPI against a board in QEMU"]
fn every_telegram_of_rsipi_is_answered_and_its_robot_moves() {
    let [x, y, z] = VELOCITY_M_S;
    let settings = format!(
        "{BUSY_COMPUTER}
[control.body_k]
velocity_m_s = [{x}, {y}, {z}]
[control.body_q]
fixed = true
"
    );
    let mut board = QemuBoard::start("qemu_rsipi", &settings, &["--start"]);
    let address = board.robot.to_string();
    let arguments = ["robot-config", "--settings", "board.toml", "--board"];
    let written = softdock(
        &board.folder,
        &[&arguments[..], &[&address, "-o", "rsi.xml"]].concat(),
    );
    assert!(written.success, "{}", written.stderr);
    let sensor = sensor(&board.folder, board.can);
    board.process().wait_for("sensor Running");
    let robot = RsipiRobot::start(&board.folder, "rsi.xml", CYCLES);
    let verdict = robot.verdict();
    let log = board.process().wait_for("robot silent");
    drop(sensor);
    board.stop();
    println!("RSIPI: {} of {CYCLES} cycles were late", verdict.late);

    // RSIPI accepts an answer only with the time stamp of its telegram.
    assert_eq!(verdict.rejected, Vec::<String>::new(), "{log}");
    assert_eq!(verdict.accepted.len(), CYCLES);
    for (axis, velocity) in AXES.iter().zip(VELOCITY_M_S) {
        let steps = verdict.accepted.iter().map(|(_, c)| counts(&c[*axis]));
        let sum_mm = steps.sum::<i64>() as f64 * 1e-4;
        let moved_mm = verdict.end[*axis] - verdict.start[*axis];
        assert!(
            (moved_mm - sum_mm).abs() < 1e-6,
            "{axis}: {moved_mm} mm, not {sum_mm} mm"
        );
        // Free flight: the ramp costs half of its 25 cycles and two zero cycles, and answers that
        // were late are not in the sum.
        let flight_mm = velocity * 1e3 * CYCLE_S * CYCLES as f64;
        assert!(
            (sum_mm - flight_mm).abs() < 0.02 * flight_mm.abs(),
            "{axis}: {sum_mm} mm, not {flight_mm} mm"
        );
    }
}
