//! RSIPI's robot controller and a python-can sensor against a board process, with the Ethernet
//! configuration that `softdock robot-config` writes.
//!
//! Nothing here depends on how fast the computer is: RSIPI drops answers that come late, as a robot
//! does, and what is compared are the answers that it accepted.

use softdock_app::record::Correction;
use softdock_app::record::CycleRecord;
use softdock_control::modes::Mode;
use softdock_io::recording::Recording;
use softdock_tests::peers::python::{RsipiRobot, Verdict, sensor};
use softdock_tests::peers::{BUSY_COMPUTER, Board, counts};
use softdock_tests::process::{Running, json, softdock};
use std::collections::BTreeMap;

/// Mass of the moving spacecraft, kg.
const MASS_KG: f64 = 500.0;
/// Control cycle, s.
const CYCLE_S: f64 = 0.004;
/// Its initial velocity, m/s.
const VELOCITY_M_S: [f64; 3] = [0.005, -0.001, 0.002];
/// One count of the sensor's gauge 0, N: 1.25 counts of force / 1000 counts per lbf.
const FLICKER_N: f64 = 0.006;
/// One unit of a correction, m (10⁻⁴ mm).
const COUNT_M: f64 = 1e-7;
const AXES: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];

/// A board that starts by itself, its configuration for the robot, and its sensor.
fn start(test: &str) -> (Board, Running) {
    let [x, y, z] = VELOCITY_M_S;
    let settings = format!(
        "{BUSY_COMPUTER}
[control.body_k]
mass_kg = {MASS_KG:.1}
velocity_m_s = [{x}, {y}, {z}]
[control.body_q]
fixed = true
"
    );
    let mut board = Board::start(test, &settings, &["--start"]);
    let address = board.robot.to_string();
    let arguments = [
        "robot-config",
        "--settings",
        "board.toml",
        "--board",
        &address,
        "-o",
        "rsi.xml",
    ];
    let written = softdock(&board.folder, &arguments);
    assert!(written.success, "{}", written.stderr);
    let sensor = sensor(&board.folder, board.can);
    board.process.wait_for("sensor Running");
    (board, sensor)
}

/// Ends the board and reads what it recorded; a replay must find the same corrections.
fn recorded(board: Board) -> Recording {
    let folder = board.folder.clone();
    let (path, log) = board.stop();
    let report = json(&folder, &["replay", "run.mcap"]);
    assert_eq!(report["identical"], true, "{report}\n{log}");
    let recording = Recording::open(&path).unwrap();
    assert_eq!(recording.cut, None);
    recording
}

/// Every answer that RSIPI accepted is the one that was recorded, and its robot stands where they
/// add up to. Returns that sum.
fn check_answers(verdict: &Verdict, recording: &Recording) -> Correction {
    let sent: BTreeMap<u64, Correction> = recording
        .cycles
        .iter()
        .map(|c| (c.inputs.robot.counter, c.output.correction))
        .collect();
    let mut sum = Correction::default();
    for (ipoc, correction) in &verdict.accepted {
        let received = AXES.map(|axis| counts(&correction[axis]));
        assert_eq!(Some(&received), sent.get(ipoc), "correction of {ipoc}");
        for (sum, step) in sum.iter_mut().zip(received) {
            *sum += step;
        }
    }
    for (axis, counts) in AXES.iter().zip(sum) {
        let moved = verdict.end[*axis] - verdict.start[*axis];
        let meant = counts as f64 * 1e-4;
        assert!(
            (moved - meant).abs() < 1e-6,
            "RIst {axis} moved {moved}, the answers say {meant}"
        );
    }
    sum
}

fn running(recording: &Recording) -> Vec<&CycleRecord> {
    let cycles: Vec<_> = recording
        .cycles
        .iter()
        .filter(|c| c.trace.mode == Mode::Running)
        .collect();
    assert!(!cycles.is_empty(), "the loop was never closed");
    cycles
}

#[test]
fn rsipi_moves_as_the_board_says() {
    const CYCLES: usize = 2500;
    let (board, sensor) = start("rsipi_free");
    let robot = RsipiRobot::start(&board.folder, "rsi.xml", CYCLES);
    let verdict = robot.verdict();
    drop(sensor);
    let recording = recorded(board);
    println!("RSIPI: {} of {CYCLES} cycles were late", verdict.late);

    assert_eq!(verdict.rejected, Vec::<String>::new());
    assert_eq!(verdict.accepted.len(), CYCLES);
    let accepted = check_answers(&verdict, &recording);

    // The board's own idea: the commanded pose is the sum of all that it sent, to the last digit.
    let cycles = running(&recording);
    let (first, last) = (cycles[0].trace.command_pose, cycles[cycles.len() - 1].trace);
    assert_eq!(last.mode, Mode::Running);
    for axis in 0..3 {
        let sent: i64 = cycles[1..].iter().map(|c| c.output.correction[axis]).sum();
        let commanded = last.command_pose[axis] - first[axis];
        let off = (commanded - sent as f64 * COUNT_M).abs();
        assert!(
            off <= COUNT_M,
            "axis {axis}: commanded {commanded} m, sent {sent} counts"
        );
        // Free flight: the ramp costs half of its 25 cycles and two zero cycles.
        let flight = VELOCITY_M_S[axis] * CYCLE_S * (cycles.len() as f64 - 15.0);
        assert!(
            (commanded - flight).abs() < 0.02 * flight.abs(),
            "{commanded} m, not {flight} m"
        );
        if verdict.late == 0 {
            assert_eq!(
                accepted[axis], sent,
                "no answer was late, so the robot took all of them"
            );
        }
    }
}

#[test]
fn a_push_on_the_sensor_changes_the_velocity_by_its_impulse() {
    const CYCLES: usize = 1000;
    let (board, mut sensor) = start("rsipi_push");
    let mut robot = RsipiRobot::start(&board.folder, "rsi.xml", CYCLES);
    robot.process.wait_for("cycles 300");
    sensor.say("force -40 0 10 50");
    let shown = sensor.wait_for("wrench ");
    let shown: Vec<f64> = shown
        .split(' ')
        .skip(1)
        .map(|word| word.parse().unwrap())
        .collect();
    sensor.wait_for("released ");
    let verdict = robot.verdict();
    assert_eq!(verdict.rejected, Vec::<String>::new());
    let recording = recorded(board);
    check_answers(&verdict, &recording);

    // Cycles whose sample shows the push; the sensor has told what it shows.
    let cycles = running(&recording);
    let pushed: Vec<bool> = cycles
        .iter()
        .map(|c| c.inputs.sensor.wrench[0] < -20.0)
        .collect();
    let count = pushed.iter().filter(|pushed| **pushed).count();
    let begin = pushed
        .iter()
        .position(|pushed| *pushed)
        .expect("the push was never seen");
    assert!(count >= 5, "only {count} cycles saw the push");
    for (axis, force_n) in shown.iter().enumerate() {
        let read = cycles[begin].inputs.sensor.wrench[axis];
        assert!(
            (read - force_n).abs() < 1e-6,
            "axis {axis} reads {read}, the sensor shows {force_n}"
        );
    }
    let (before, after) = (cycles[begin - 1].trace, cycles[cycles.len() - 1].trace);
    for (axis, force_n) in shown.iter().enumerate().take(3) {
        let change = after.body_k.velocity[axis] - before.body_k.velocity[axis];
        let impulse = force_n * CYCLE_S / MASS_KG;
        let expected = impulse * count as f64;
        // One cycle more or less at the edges, and the flickering count all the time.
        let flicker = FLICKER_N * CYCLE_S / MASS_KG * cycles.len() as f64;
        let tolerance = impulse.abs() + flicker;
        assert!(
            (change - expected).abs() <= tolerance,
            "axis {axis}: {change} m/s, not {expected} m/s"
        );
    }
    assert!(
        after.sent_velocity[0] < 0.0,
        "the push turns the spacecraft around"
    );
}
