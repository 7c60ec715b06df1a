//! The jog of a board on this computer, over its service and its telemetry, as a user runs it.

use softdock_app::settings::BoardSettings;
use softdock_control::modes::Mode;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::Recording;
use softdock_tests::peers::{
    BUSY_COMPUTER, LockStepRig, Motion, RunningRobot, Sensor, Served, patient, serve,
};
use softdock_tests::process::{Finished, Running, softdock, softdock_binary, words};
use std::net::{SocketAddr, UdpSocket};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use toml_edit::ser::to_string_pretty;

/// What is to be found out.
const DELAY_S: f64 = 0.037;
const PAUSE_S: f64 = 0.012;

/// The spring-rod rig without its spring, late, and a board that has patience with a busy computer.
fn late_rig() -> (Scenario, BoardSettings) {
    let mut scenario = Scenario::spring_rod().unwrap();
    scenario.rig.mechanism.walls.clear();
    let actuator = &mut scenario.rig.robot.actuator;
    (actuator.delay_s, actuator.lag_s, actuator.pause_s) = (DELAY_S, 0.0, PAUSE_S);
    scenario.board = patient(&scenario.board);
    let settings = scenario.actual_board().unwrap();
    (scenario, settings)
}

/// A UDP port of this computer that nobody has.
fn free_address() -> SocketAddr {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.local_addr().unwrap()
}

/// The rig, running in a thread of its own.
struct RunningRig {
    stop: Arc<AtomicBool>,
    /// The robot was told to move.
    moved: Arc<AtomicBool>,
    thread: JoinHandle<Motion>,
}

impl RunningRig {
    fn start(scenario: Scenario, settings: BoardSettings, served: &mut Served) -> Self {
        let (robot, can) = (served.board.robot, served.board.can);
        let stop = Arc::new(AtomicBool::new(false));
        let moved = Arc::new(AtomicBool::new(false));
        let (raised, moves) = (stop.clone(), moved.clone());
        let thread = thread::spawn(move || {
            let mut rig = LockStepRig::connect(&scenario, &settings, robot, can);
            let mut motion = Motion::new();
            while !raised.load(Ordering::Relaxed)
                && let Some(correction) = rig.step()
            {
                moves.fetch_or(correction != [0; 6], Ordering::Relaxed);
                motion.push(correction);
            }
            motion
        });
        served.board.process.wait_for("sensor Running");
        Self {
            stop,
            moved,
            thread,
        }
    }

    /// Waits until the robot is told to move.
    fn wait_for_motion(&self) {
        while !self.moved.load(Ordering::Relaxed) {
            assert!(!self.thread.is_finished(), "the rig has ended");
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// What the robot was told.
    fn stop(self) -> Motion {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().expect("a rig that was answered")
    }
}

fn identify(served: &Served, arguments: &[&str]) -> Finished {
    let common = ["identify", "actuator", "--port", &served.port];
    softdock(&served.board.folder, &[&common[..], arguments].concat())
}

/// The board jogs, its telemetry is recorded, the delay is found, and the board has it afterwards.
#[test]
#[ignore = "long: a jog in real time"]
fn the_delay_of_a_live_rig_is_found_and_uploaded() {
    let (scenario, mut settings) = late_rig();
    let address = free_address();
    settings.network.recorder = address.to_string().as_str().try_into().unwrap();
    let toml = to_string_pretty(&settings).unwrap();
    let mut served = serve("jog_live", &toml, &[]);
    let rig = RunningRig::start(scenario, settings, &mut served);

    // Nobody says yes.
    let run = identify(&served, &["--axis", "y"]);
    assert_eq!(run.code, Some(1), "{}", run.stdout);
    for says in [
        "jog y: up to 50.000 mm",
        "32.000 mm/s",
        "Is its way free?",
        "nothing moved",
    ] {
        assert!(run.stderr.contains(says), "`{says}`: {}", run.stderr);
    }
    let run = identify(&served, &["--json"]);
    assert!(run.stderr.contains("say --yes"), "{}", run.stderr);

    std::fs::copy(
        served.board.folder.join("board.toml"),
        served.board.folder.join("new.toml"),
    )
    .unwrap();
    let run = identify(
        &served,
        &words("--axis y,-z --yes --json --upload --into new.toml --keep jog.mcap"),
    );
    let run = run.succeeded();
    eprintln!("{}", run.stderr);
    let found = run.json();
    let near = |name: &str, truth: f64, tolerance: f64| {
        let value = found[name]["value"].as_f64().unwrap();
        eprintln!("{name}: {value}");
        assert!((value - truth).abs() < tolerance, "{name}: {value}");
    };
    near("delay_s", DELAY_S, 2e-3);
    near("mean_delay_s", DELAY_S, 2e-3);
    near("pause_s", PAUSE_S, 3e-3);
    assert_eq!(found["axes"].as_array().unwrap().len(), 2);

    // The recording shows what moved, and that it came back.
    let folder = &served.board.folder;
    let cycles = Recording::open(&folder.join("jog.mcap")).unwrap().cycles;
    let jogging = cycles.iter().filter(|c| c.trace.mode == Mode::Jogging);
    assert_eq!(jogging.count(), 2 * 1096);
    for cycle in &cycles {
        let [x, y, z, a, b, c] = cycle.trace.sent_velocity;
        assert_eq!([x, a, b, c], [0.0; 4]);
        assert!(y == 0.0 || z == 0.0);
    }
    let place = |n: usize| cycles[n].inputs.robot.pose.unwrap();
    let (first, last) = (place(0), place(cycles.len() - 1));
    for (first, last) in first.iter().zip(last) {
        assert!((first - last).abs() < 2e-4, "{first} to {last}");
    }
    // The board has it, and the file too.
    let delay = served.json(&["get", "control.delay.actuator.delay_s"]);
    let delay = delay["value"].as_f64().unwrap();
    assert!((delay - DELAY_S).abs() < 2e-3, "{delay}");
    assert_eq!(served.done(&["diff", "new.toml"]), "");
    rig.stop();
    served.board.stop();
}

/// Ctrl-C while the robot jogs: it stands still, the board holds, and what was recorded is whole.
#[test]
fn ctrl_c_ends_a_jog() {
    let (scenario, mut settings) = late_rig();
    let address = free_address();
    settings.network.recorder = address.to_string().as_str().try_into().unwrap();
    let toml = to_string_pretty(&settings).unwrap();
    let mut served = serve("jog_interrupted", &toml, &[]);
    let rig = RunningRig::start(scenario, settings, &mut served);
    let mut command = Command::new(softdock_binary());
    command
        .current_dir(&served.board.folder)
        .args(["identify", "actuator", "--port", &served.port])
        .args(["--axis", "y,z", "--yes", "--json", "--upload"])
        .args(["--keep", "jog.mcap", "--into", "board.toml"]);
    let mut jog = Running::start("jog", &mut command);
    jog.wait_for("The robot will move");
    served.board.process.wait_for("mode Jogging");
    rig.wait_for_motion();
    jog.interrupt();
    let (status, log) = jog.finish();
    assert_eq!(status.code(), Some(1), "{log}");
    for says in [
        "stopped: the robot stands still, and nothing was identified",
        "kept so far: jog.mcap: ",
    ] {
        assert!(log.contains(says), "`{says}`: {log}");
    }
    served.board.process.wait_for("mode Hold");
    let status = served.json(&["status"]);
    assert_eq!(status["status"]["mode"], "Hold");
    assert_eq!(status["status"]["moves"], false);
    let motion = rig.stop();
    assert_eq!(motion.last(), Some(&[0; 6]));
    assert!(motion.iter().all(|c| c[2] == 0), "the next jog began");

    // The file is whole, and shows the motion and its end.
    let folder = &served.board.folder;
    let recording = Recording::open(&folder.join("jog.mcap")).unwrap();
    assert_eq!(recording.cut, None);
    let moved = recording
        .cycles
        .iter()
        .filter(|c| c.trace.sent_velocity[1] != 0.0);
    assert!(moved.count() > 0);
    let last = recording.cycles.last().unwrap();
    assert_eq!(
        (last.trace.mode, last.trace.sent_velocity),
        (Mode::Hold, [0.0; 6])
    );
    // Nothing else was written.
    assert_eq!(served.done(&["diff", "board.toml"]), "");
    served.board.stop();
}

/// While a jog runs nothing changes, a stop ends it, and without room it does not begin.
#[test]
fn a_jog_is_an_operators_command() {
    let mut served = serve("jog_operator", BUSY_COMPUTER, &[]);
    let run = identify(&served, &["--yes"]);
    assert!(
        run.stderr.contains("params set network.recorder"),
        "{}",
        run.stderr
    );
    let run = identify(&served, &["--yes", "--listen", "127.0.0.1:0"]);
    assert!(run.stderr.contains("start RSI first"), "{}", run.stderr);
    let run = identify(&served, &["--yes", "--axis", "w"]);
    assert!(
        run.stderr.contains("--axis w: expected x, y"),
        "{}",
        run.stderr
    );

    let sensor = Sensor::connect(served.board.can);
    served.board.process.wait_for("sensor Running");
    let robot = RunningRobot::start(served.board.robot);
    // On a busy computer the robot may be late, and its loss is told first.
    let refused = |_| {
        served.hears_its_robot();
        served.refused(&["mode", "jog", "x"])
    };
    let mut tries = (0..20).map(refused);
    let says = "jog x refused in mode Idle: it does not apply in this mode";
    assert!(tries.any(|said| said.contains(says)));
    served.done(&["mode", "hold"]);
    let answer = served.json(&["mode", "jog -x"]);
    assert_eq!(answer["mode"], "Jogging");
    served.board.process.wait_for("mode Jogging");
    let said = served.refused(&["set", "control.jog.reach_m", "0.04"]);
    assert!(said.contains("robot moves or is armed"), "{said}");
    let said = served.refused(&["mode", "jog -y"]);
    assert!(said.contains("jog -y refused in mode Jogging"), "{said}");
    assert_eq!(served.json(&["mode", "stop"])["mode"], "Hold");
    served.board.process.wait_for("mode Hold");
    while served.json(&["status"])["status"]["moves"] == true {}
    // What the limits do not allow is no setting.
    let said = served.refused(&["set", "control.jog.reach_m", "0.3"]);
    assert!(said.contains("allowed is 0.016 to 0.25"), "{said}");
    // Typed on the board's own terminal.
    served.board.process.say("jog x");
    served.board.process.wait_for("mode Jogging");
    served.board.process.wait_for("mode Hold");
    assert!(robot.stop() > 0, "the robot moved");
    drop(sensor);
    served.board.stop();
}

/// A board that sends its cycles to nobody who listens: the robot does not move.
#[test]
fn nothing_moves_where_nothing_is_heard() {
    let mut served = serve("jog_unheard", BUSY_COMPUTER, &[]);
    let sensor = Sensor::connect(served.board.can);
    served.board.process.wait_for("sensor Running");
    let robot = RunningRobot::start(served.board.robot);
    served.hears_its_robot();
    let run = identify(&served, &["--yes", "--listen", "127.0.0.1:0"]);
    assert_eq!(run.code, Some(1));
    assert!(
        run.stderr
            .contains("no cycle of the board came to UDP 127.0.0.1:"),
        "{}",
        run.stderr
    );
    assert_eq!(robot.stop(), 0);
    drop(sensor);
    served.board.stop();
}
