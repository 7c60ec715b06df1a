//! The operator of a board process: commands on standard input, Ctrl-C, and start-up errors.

use softdock_control::modes::{Command, Mode};
use softdock_io::recording::Recording;
use softdock_tests::peers::{BUSY_COMPUTER, Board, Robot, Sensor};
use softdock_tests::process::{scratch, softdock, words};

const VELOCITY: &str = "[control.body_k]\nvelocity_m_s = [0.005, 0.0, 0.0]\n";

#[test]
fn commands_lead_through_the_modes() {
    let mut board = Board::start("commands", &format!("{BUSY_COMPUTER}\n{VELOCITY}"), &[]);
    let sensor = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    // A command that is given before the RSI run begins is dropped, and that is said.
    board.process.say("hold");
    board.process.wait_for("`hold` waits: the robot is silent");

    let mut robot = Robot::new(board.robot);
    robot.cycle();
    for (command, says) in [
        ("start", "start refused: it does not apply in this mode"),
        (
            "dance",
            "`dance` is no command; expected one of hold, arm, start, stop, reset, zero",
        ),
        ("hold", "mode Hold"),
        ("arm", "mode Armed"),
        ("start", "mode Running"),
        ("stop", "mode Hold"),
        (
            "zero\nreset",
            "reset refused: it does not apply in this mode",
        ),
    ] {
        board.process.say(command);
        board.cycles_until(&mut robot, says);
    }
    drop(sensor);
    let (path, _) = board.stop();
    let recording = Recording::open(&path).unwrap();
    let obeyed: Vec<Command> = recording
        .cycles
        .iter()
        .filter_map(|c| c.inputs.command)
        .collect();
    use Command::{Arm, Hold, Reset, Start, Stop, Zero};
    assert_eq!(obeyed, [Start, Hold, Arm, Start, Stop, Zero, Reset]);
    assert!(robot.pose[0] > 0, "the robot moved");
}

#[test]
fn a_fault_is_left_by_reset_and_the_board_runs_again() {
    let strict = BUSY_COMPUTER.replace("fault_after_cycles = 1000", "fault_after_cycles = 200");
    let strict = strict.replace("answer_timeout_s = 1.0", "answer_timeout_s = 0.02");
    let mut board = Board::start("reset", &strict, &["--start"]);
    let sensor = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    let mut robot = Robot::new(board.robot);
    board.cycles_until(&mut robot, "mode Running");
    sensor.be_silent(true);
    board.cycles_until(&mut robot, "mode Fault");
    sensor.be_silent(false);
    board.cycles_until(&mut robot, "sensor Running");
    board.process.say("reset");
    board.cycles_until(&mut robot, "mode Hold");
    // Nothing starts by itself after a fault.
    for (command, mode) in [("arm", "mode Armed"), ("start", "mode Running")] {
        board.process.say(command);
        board.cycles_until(&mut robot, mode);
    }
    board.stop();
}

#[test]
fn ctrl_c_leaves_a_whole_recording() {
    let mut board = Board::start("ctrl_c", BUSY_COMPUTER, &["--start"]);
    let _sensor = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    let mut robot = Robot::new(board.robot);
    for _ in 0..333 {
        robot.cycle();
    }
    let (path, _) = board.stop();
    let recording = Recording::open(&path).unwrap();
    assert_eq!((recording.cut, recording.cycles.len()), (None, 333));
    assert!(
        recording
            .cycles
            .iter()
            .any(|c| c.trace.mode == Mode::Running)
    );
}

#[test]
fn a_port_in_use_is_an_error() {
    let board = Board::start("port_first", BUSY_COMPUTER, &[]);
    let folder = scratch("port_second");
    std::fs::write(folder.join("board.toml"), BUSY_COMPUTER).unwrap();
    let (robot, can) = (board.robot.to_string(), board.can.to_string());
    for (robot, can, taken) in [
        (robot.as_str(), "127.0.0.1:0", &robot),
        ("127.0.0.1:0", can.as_str(), &can),
    ] {
        let second = softdock(
            &folder,
            &[
                "board",
                "--settings",
                "board.toml",
                "--robot",
                robot,
                "--can",
                can,
            ],
        );
        assert_eq!(second.code, Some(1), "{}", second.stderr);
        let expected = format!("on {taken}; is another board running");
        assert!(
            second.stderr.contains("cannot listen for the ") && second.stderr.contains(&expected),
            "{}",
            second.stderr
        );
    }
}

#[test]
fn a_wrong_key_in_the_settings_is_named_with_its_line() {
    let folder = scratch("wrong_key");
    let settings = "[can]\npoll_period_ms = 4.0\n";
    std::fs::write(folder.join("board.toml"), settings).unwrap();
    let any = "--robot 127.0.0.1:0 --can 127.0.0.1:0";
    let board = format!("board --settings board.toml {any} -o run.mcap");
    softdock(&folder, &words(&board)).refused(&[
        "board.toml:2: unknown key `poll_period_ms` in [can]; did you mean `poll_period_s`?",
    ]);
    assert!(
        !folder.join("run.mcap").exists(),
        "a refused start leaves no recording"
    );
}
