//! `softdock params` with the firmware in QEMU, over its serial line.

use softdock_tests::peers::{
    BUSY_COMPUTER, QemuBoard, RunningRobot, Sensor, Served, serve_emulated,
};
use softdock_tests::process::softdock;
use std::time::Duration;

const MASS: &str = "control.sensor.tool_mass_kg";

/// What a new board is asked to do, on the one that there is: its clock is QEMU's.
#[test]
fn a_board_shows_what_it_can_do() {
    let served = serve_emulated("qemu_self_test", "", &[]);
    let port = ["doctor", "--port", &served.port, "--json"];
    let arguments = [&port[..], &["--self-test", "--hang"]].concat();
    let run = softdock(&served.folder, &arguments);
    let found = run.json();
    let state = |name: &str| {
        let checks = found["checks"].as_array().unwrap();
        let check = checks.iter().find(|check| check["name"] == name);
        check.unwrap_or_else(|| panic!("no {name}: {found}"))["state"].clone()
    };
    assert_eq!(state("flash and reset"), "good", "{found}");
    assert_eq!(state("stack"), "good", "{found}");
    // The emulator has no register that tells, and its network does not answer ping from here.
    assert_eq!(state("reason of the reset"), "warning", "{found}");
    // It has neither CAN nor LEDs; and it came back from its hang.
    for name in ["ping", "LEDs", "CAN controller", "watchdog"] {
        assert_eq!(state(name), "warning", "{found}");
    }
    state("clock");
    let log = served.board.end();
    assert_eq!(
        log.lines().filter(|line| line.ends_with(" ready")).count(),
        3,
        "first start, settings, hang\n{log}"
    );
}

/// Whether a word leads to a mode. A robot in real time on a busy computer may be silent for as long as makes the
/// board refuse, rightly, and stop it, so that its motion has to fade out again.
fn goes(served: &Served<QemuBoard>, word: &str, mode: &str) -> bool {
    let run = served.params(&["mode", word, "--json"]);
    let late = ["the robot sends no telegrams", "has not faded out"];
    if late.iter().any(|why| run.stderr.contains(why)) {
        return false;
    }
    assert_eq!(run.succeeded().json()["mode"], mode, "{word}");
    true
}

/// From hold to a running loop, where a change of the tool is refused, and back; false if the robot was silent in
/// between.
fn runs_and_stops(served: &Served<QemuBoard>) -> bool {
    let words = [("hold", "Hold"), ("arm", "Armed"), ("start", "Running")];
    if !words.iter().all(|(word, mode)| goes(served, word, mode)) {
        return false;
    }
    let refused = served.params(&["set", MASS, "3.0"]);
    if refused.code == Some(0) || !goes(served, "stop", "Hold") {
        return false;
    }
    let said = &refused.stderr;
    assert_eq!(refused.code, Some(1), "{said}");
    assert!(said.contains("robot moves or is armed"), "{said}");
    true
}

/// Who changes settings starts by hand.
#[test]
#[ignore = "long: one more launch in QEMU"]
fn with_start_it_starts_once() {
    let mut served = serve_emulated("qemu_start_once", BUSY_COMPUTER, &["--start"]);
    let sensor = Sensor::connect(served.board.can);
    let robot = RunningRobot::start(served.board.robot);
    served.board.process().wait_for("mode Running");
    assert!((0..10).any(|_| goes(&served, "stop", "Hold")), "no robot");
    served.json(&["set", MASS, "1.25"]);
    served.board.process().wait_for("on trial for 60 s");
    // The firmware that has started over waits for somebody to open its channel.
    drop(sensor);
    let sensor = Sensor::connect(served.board.can);
    served.board.process().wait_for("sensor Running");
    // By now it would have started ten times over.
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(served.json(&["status"])["status"]["mode"], "Idle");
    robot.stop();
    drop(sensor);
    served.board.end();
}

/// Settings are listed, changed, tried behind a reset, confirmed, and are there in the next launch
/// with the same flash.
#[test]
fn settings_survive_resets_and_launches() {
    let flash = std::env::temp_dir().join(format!("softdock-test-{}.bin", std::process::id()));
    let arguments = ["--flash", flash.to_str().unwrap()];
    let mut served = serve_emulated(
        "qemu_params",
        "[control.sensor]\ntool_mass_kg = 0.5\n",
        &arguments,
    );
    let list = served.json(&["list"]);
    let list = list["settings"].as_array().unwrap();
    assert!(list.len() > 90, "{}", list.len());
    assert_eq!(served.json(&["get", MASS])["value"], 0.5);
    let changed = served.json(&["set", MASS, "1.25"]);
    assert_eq!(changed["sequence"], 2);
    assert_eq!(served.json(&["get", MASS])["value"], 1.25);
    served.board.process().wait_for("on trial for 60 s");
    // A loss of contact: nobody confirms, and the board goes back by itself.
    let dumped = served.json(&["dump"]);
    assert_eq!(dumped["settings"].as_array().unwrap().len(), list.len());
    served.board.end();

    let again = serve_emulated("qemu_params_again", "", &arguments);
    assert_eq!(again.json(&["get", MASS])["value"], 1.25);
    let back = again.json(&["rollback"]);
    assert_eq!(back["changed"][0]["wanted"], 0.5);
    again.board.end();
    std::fs::remove_file(&flash).unwrap();
}

/// From idle to a running loop by the service alone, on both chips.
#[test]
fn an_operator_arms_and_starts_over_serial() {
    for (test, chip) in [("qemu_mode_an500", "an500"), ("qemu_mode_an385", "an385")] {
        let mut served = serve_emulated(test, BUSY_COMPUTER, &["--chip", chip]);
        let sensor = Sensor::connect(served.board.can);
        served.board.process().wait_for("sensor Running");
        let robot = RunningRobot::start(served.board.robot);
        served.board.process().wait_for("robot connected");
        let ran = (0..10).any(|_| runs_and_stops(&served));
        assert!(ran, "no robot for long enough");
        robot.stop();
        drop(sensor);
        served.board.stop();
    }
}
