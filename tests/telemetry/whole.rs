//! `softdock record` and `softdock board --telemetry` as two processes on one computer.

use serde_json::Value;
use softdock_io::recording::Recording;
use softdock_tests::peers::{BUSY_COMPUTER, Board, Robot, Sensor, text};
use softdock_tests::process::{self, Running, scratch, softdock, softdock_binary};
use std::net::{SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::process::{Command, ExitStatus};
use std::time::Duration;

/// Time between two cycles: fast, but no flood.
const PACE: Duration = Duration::from_millis(2);

/// A recorder process, and the folder of its files.
struct Recorder {
    process: Running,
    folder: PathBuf,
    address: SocketAddr,
}

impl Recorder {
    fn start(test: &str, arguments: &[&str]) -> Self {
        let folder = scratch(&format!("{test}_recorder"));
        let mut command = Command::new(softdock_binary());
        command.current_dir(&folder);
        command.args(["record", "--listen", "127.0.0.1:0", "-o", "rig.mcap"]);
        command.args(arguments);
        let mut process = Running::start("recorder", &mut command);
        let line = process.wait_for("listening on UDP ");
        let address = line.split(' ').find_map(|word| word.parse().ok());
        Self {
            process,
            folder,
            address: address.expect("the recorder's address"),
        }
    }

    fn board(&self, test: &str, settings: &str) -> Board {
        let address = self.address.to_string();
        let settings = format!("{BUSY_COMPUTER}\n{settings}");
        Board::start(test, &settings, &["--start", "--telemetry", &address])
    }

    /// Ends it with Ctrl-C: how it ended, its folder, and what it said.
    fn stop(self) -> (ExitStatus, PathBuf, String) {
        self.process.interrupt();
        let (status, log) = self.process.finish();
        (status, self.folder, log)
    }
}

/// The JSON document in what a process said.
fn json(log: &str) -> Value {
    let (from, to) = (log.find("{\n").unwrap(), log.rfind("\n}").unwrap());
    serde_json::from_str(&log[from..to + 2]).unwrap()
}

fn cycles(robot: &mut Robot, count: usize) {
    for _ in 0..count {
        robot.cycle();
        std::thread::sleep(PACE);
    }
}

/// The board's own recording of a test, which the telemetry must equal.
fn own(board: Board) -> Recording {
    Recording::open(&board.stop().0).unwrap()
}

#[test]
fn a_recording_through_the_network_is_the_boards_own_and_replays_bit_for_bit() {
    let recorder = Recorder::start("telemetry", &["--json"]);
    let settings = "[control.body_k]\nvelocity_m_s = [0.005, 0.0, 0.0]\n";
    let mut board = recorder.board("telemetry", settings);
    let sensor = Sensor::connect(board.can);
    board.process.wait_for("sensor Running");
    let mut robot = Robot::new(board.robot);
    cycles(&mut robot, 400);
    drop(sensor);
    assert!(robot.pose[0] > 0, "the loop is closed: the robot moved");

    let own = own(board);
    let (status, folder, log) = recorder.stop();
    assert!(status.success(), "{log}");
    let summary = json(&log);
    assert_eq!(summary["cycles"], 400, "{log}");
    assert_eq!(summary["recordings"][0]["lost_datagrams"], 0);
    let mut recorded = Recording::open(&folder.join("rig.mcap")).unwrap();
    // Each looked at the clock when its first cycle came.
    assert!(recorded.wall_clock.is_some() && own.wall_clock.is_some());
    recorded.wall_clock = own.wall_clock;
    assert_eq!(recorded, own);

    let verdict = process::json(&folder, &["replay", "rig.mcap"]);
    assert_eq!(
        (&verdict["identical"], &verdict["cycles"]),
        (&true.into(), &400.into())
    );
}

#[test]
fn a_recorder_that_comes_later_gets_the_settings_too() {
    let settings = "[control.body_k]\nmass_kg = 77.0\n";
    // The board is there before its recorder: the address is taken and given back.
    let address = UdpSocket::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let telemetry = address.to_string();
    let settings = format!("{BUSY_COMPUTER}\n{settings}\n[network]\nrecorder = \"{telemetry}\"\n");
    let board = Board::start("telemetry_later", &settings, &[]);
    let mut robot = Robot::new(board.robot);
    cycles(&mut robot, 50);

    let folder = scratch("telemetry_later_recorder");
    let mut command = Command::new(softdock_binary());
    command.current_dir(&folder);
    command.args(["record", "--listen", &telemetry, "-o", "rig.mcap"]);
    let mut process = Running::start("recorder", &mut command);
    process.wait_for("listening on UDP ");
    // The next announcement comes within a second of the board's time.
    while process.heard("recording into rig.mcap").is_none() {
        cycles(&mut robot, 10);
    }
    let own = own(board);
    process.interrupt();
    let (status, log) = process.finish();
    assert!(status.success(), "{log}");
    assert!(
        log.contains("to be replayed, a recording must begin before the robot does"),
        "{log}"
    );
    let recorded = Recording::open(&folder.join("rig.mcap")).unwrap();
    assert_eq!(recorded.header, own.header);
    let first = recorded.cycles[0].trace.cycle as usize;
    assert!(first >= 50);
    assert_eq!(recorded.cycles, own.cycles[first..]);
}

#[test]
fn a_board_that_is_started_again_gets_another_file() {
    let mut recorder = Recorder::start("telemetry_again", &[]);
    for (name, count) in [("rig.mcap", 120), ("rig-2.mcap", 60)] {
        let board = recorder.board("telemetry_again", "");
        let mut robot = Robot::new(board.robot);
        cycles(&mut robot, count);
        recorder.process.wait_for(&format!("recording into {name}"));
        board.stop();
    }
    let (first, second) = (
        "rig.mcap: 120 cycles, none lost",
        "rig-2.mcap: 60 cycles, none lost",
    );
    let folder = recorder.folder.clone();
    let (status, _, log) = recorder.stop();
    assert!(status.success(), "{log}");
    assert!(log.contains(first) && log.contains(second), "{log}");
    for name in ["rig.mcap", "rig-2.mcap"] {
        let replay = softdock(&folder, &["replay", name]);
        assert!(replay.success, "{name}: {}", replay.stderr);
    }
}

#[test]
fn datagrams_of_others_are_counted() {
    let recorder = Recorder::start("telemetry_strangers", &["--json"]);
    let board = recorder.board("telemetry_strangers", "");
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut robot = Robot::new(board.robot);
    for _ in 0..20 {
        cycles(&mut robot, 2);
        stranger
            .send_to(b"<Rob Type=\"KUKA\"/>", recorder.address)
            .unwrap();
        stranger.send_to(b"SDKT\x01", recorder.address).unwrap();
    }
    board.stop();
    let (status, _, log) = recorder.stop();
    assert!(status.success(), "{log}");
    let summary = json(&log);
    assert_eq!(summary["cycles"], 40, "{log}");
    let counted = (&summary["foreign_datagrams"], &summary["damaged_datagrams"]);
    assert_eq!(counted, (&20.into(), &20.into()), "{log}");
}

#[test]
fn ctrl_c_in_mid_run_leaves_a_whole_file() {
    let mut recorder = Recorder::start("telemetry_ctrl_c", &[]);
    let board = recorder.board("telemetry_ctrl_c", "");
    let mut robot = Robot::new(board.robot);
    cycles(&mut robot, 100);
    recorder.process.wait_for("recording into rig.mcap");
    recorder.process.interrupt();
    cycles(&mut robot, 100);
    let folder = recorder.folder.clone();
    let (status, log) = recorder.process.finish();
    assert!(status.success(), "{log}");
    // Nobody listens any more; the board goes on.
    cycles(&mut robot, 20);
    assert_eq!(own(board).cycles.len(), 220);
    let recorded = Recording::open(&folder.join("rig.mcap")).unwrap();
    assert_eq!(recorded.cut, None);
    assert!((100..=200).contains(&recorded.cycles.len()));
    let replay = softdock(&folder, &["replay", "rig.mcap"]);
    assert!(replay.success, "{}", replay.stderr);
}

#[test]
fn what_goes_wrong_is_said_with_what_to_do() {
    let folder = scratch("telemetry_errors");
    std::fs::write(folder.join("kept.mcap"), "precious").unwrap();
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap().to_string();
    let record = |listen: &str, more: &[&str], expected: &str| {
        let arguments = [&["record", "--listen", listen], more].concat();
        let run = softdock(&folder, &arguments);
        assert_eq!(
            (run.code, run.stdout.as_str()),
            (Some(1), ""),
            "{}",
            run.stderr
        );
        assert!(
            run.stderr.contains(expected),
            "expected `{expected}` in {}",
            run.stderr
        );
    };
    let any = "127.0.0.1:0";
    let nobody = "does it send here (`network.recorder` in its settings";
    record(any, &["-o", "run.mcap", "--timeout", "0.3"], nobody);
    record(&taken, &["-o", "run.mcap"], "is another recorder running");
    record(any, &["-o", "kept.mcap"], "kept.mcap exists already");
    record(any, &["-o", "none/run.mcap"], "none is not a folder");
    record(
        any,
        &["-o", "run.mcap", "--timeout", "0"],
        "--timeout is 0 s",
    );
    let kept = std::fs::read_to_string(folder.join("kept.mcap")).unwrap();
    assert_eq!(kept, "precious");
    assert!(!folder.join("run.mcap").exists());

    let settings = folder.join("board.toml");
    std::fs::write(&settings, "").unwrap();
    let board = [
        "board",
        "--settings",
        text(&settings),
        "--robot",
        any,
        "--can",
        any,
    ];
    let run = softdock(
        &folder,
        &[&board[..], &["--telemetry", "0.0.0.0:0"]].concat(),
    );
    assert_eq!(run.code, Some(1));
    assert!(
        run.stderr.contains("--telemetry is 0.0.0.0:0; expected"),
        "{}",
        run.stderr
    );
}

#[test]
fn ctrl_c_without_a_cycle_writes_nothing_and_says_so() {
    let recorder = Recorder::start("telemetry_nothing", &["--json"]);
    let (status, folder, log) = recorder.stop();
    assert_eq!(status.code(), Some(1));
    assert!(
        log.contains("nothing was written: no board was heard"),
        "{log}"
    );
    assert!(!folder.join("rig.mcap").exists());
}
