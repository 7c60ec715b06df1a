//! `softdock doctor` with a board on this computer, as a user runs it.

use serde_json::Value;
use softdock_tests::peers::{BUSY_COMPUTER, RunningRobot, Sensor, serve};
use softdock_tests::process::{scratch, softdock};
use std::net::{TcpListener, UdpSocket};
use std::path::Path;

/// Exit code, and the checks of its one JSON document.
fn doctor(folder: &Path, arguments: &[&str]) -> (Option<i32>, Vec<Value>) {
    let run = softdock(folder, &[&["doctor", "--json"], arguments].concat());
    (run.code, run.json()["checks"].as_array().unwrap().clone())
}

fn find<'a>(checks: &'a [Value], name: &str) -> &'a Value {
    let check = checks.iter().find(|check| check["name"] == name);
    check.unwrap_or_else(|| panic!("no {name}: {checks:#?}"))
}

fn is(checks: &[Value], name: &str, state: &str, says: &str) {
    let check = find(checks, name);
    assert_eq!(check["state"], state, "{check}");
    let message = check["message"].as_str().unwrap();
    assert!(message.contains(says), "expected `{says}` in {check}");
}

/// Robot, sensor and recorder are there, the board holds: nothing is bad.
#[test]
fn a_board_that_is_ready_is_said_to_be() {
    let recorder = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = recorder.local_addr().unwrap();
    let settings = format!("{BUSY_COMPUTER}\n[network]\nrecorder = \"{address}\"\n");
    let mut served = serve("doctor_ready", &settings, &[]);
    let sensor = Sensor::connect(served.board.can);
    served.board.process.wait_for("sensor Running");
    let robot = RunningRobot::start(served.board.robot);
    served.hears_its_robot();
    served.done(&["mode", "hold"]);
    let port = ["--port", &served.port];
    let folder = &served.board.folder;
    let (code, checks) = doctor(folder, &[&port[..], &["--settings", "board.toml"]].concat());
    for (name, says) in [
        ("board", &*served.port),
        ("protocol", "version 2"),
        ("origin of settings", "set 1, in memory"),
        ("settings", "complete"),
        ("mode", "Hold"),
        ("faults", "none"),
        ("robot link", "connected"),
        ("robot pose", "in the last telegram"),
        ("POSCORR", "does not clamp"),
        ("late answers", "none"),
        ("sensor", "Running"),
        ("sensor status", "no error bit"),
        ("flash", "`softdock board --flash FILE` keeps them"),
        ("recorder", "listens on"),
        ("running settings", "the settings of the file"),
    ] {
        is(&checks, name, "good", says);
    }
    assert_eq!(code, Some(0), "{checks:#?}");
    // Its own sources may be changed while this test runs.
    let firmware = find(&checks, "firmware")["message"].as_str().unwrap();
    assert!(firmware.contains("board of this computer"), "{firmware}");

    // A change that is refused leaves nothing behind, and what is advised is accepted.
    let set = |value| {
        softdock(
            folder,
            &[
                "params",
                "set",
                "control.robot.cycle_s",
                value,
                "--port",
                &served.port,
            ],
        )
    };
    assert_ne!(set("5").code, Some(0));
    let (_, checks) = doctor(folder, &port);
    is(&checks, "mode", "good", "Hold");
    served.done(&["mode", "zero"]);

    // The recorder ends; the file is another one.
    drop(recorder);
    std::fs::write(folder.join("other.toml"), "[can]\nbase_id = 9\n").unwrap();
    let (code, checks) = doctor(folder, &[&port[..], &["--settings", "other.toml"]].concat());
    is(&checks, "recorder", "warning", "softdock record --listen");
    is(&checks, "running settings", "warning", "params diff");
    assert_eq!(code, Some(0), "{checks:#?}");
    assert_eq!(robot.stop(), 0, "the doctor moved the robot");
    drop(sensor);
    served.board.stop();
}

#[test]
fn a_board_alone_is_not_ready() {
    let served = serve("doctor_alone", "", &[]);
    let (code, checks) = doctor(&served.board.folder, &["--port", &served.port]);
    is(&checks, "robot link", "warning", "start RSI");
    is(&checks, "sensor rate", "bad", "no sample came");
    is(&checks, "recorder", "warning", "`network.recorder`");
    assert_ne!(find(&checks, "sensor")["state"], "good");
    assert_eq!(code, Some(1));
    // The table says the same, and only the error goes to standard error.
    let run = softdock(&served.board.folder, &["doctor", "--port", &served.port]);
    assert_eq!(run.code, Some(1));
    assert!(run.stdout.contains("start RSI"), "{}", run.stdout);
    assert!(
        run.stderr.contains("of the checks are bad"),
        "{}",
        run.stderr
    );
    served.board.stop();
}

/// Its settings name nobody, and its command line does.
#[test]
fn a_recorder_on_the_command_line_is_looked_at() {
    let recorder = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = recorder.local_addr().unwrap().to_string();
    let served = serve("doctor_telemetry", "", &["--telemetry", &address]);
    let (_, checks) = doctor(&served.board.folder, &["--port", &served.port]);
    let says = format!("a program of this computer listens on {address}");
    is(&checks, "recorder", "good", &says);
    served.board.stop();
}

#[test]
fn a_damaged_flash_is_bad() {
    let folder = scratch("doctor_damaged_flash");
    let flash = folder.join("flash.bin");
    let flash = flash.to_str().unwrap();
    serve("doctor_flash_first", "", &["--flash", flash])
        .board
        .stop();
    let mut bytes = std::fs::read(flash).unwrap();
    bytes[100] ^= 1;
    std::fs::write(flash, bytes).unwrap();
    let served = serve("doctor_flash_damaged", "", &["--flash", flash]);
    let (code, checks) = doctor(&folder, &["--port", &served.port]);
    is(&checks, "origin of settings", "bad", "params upload");
    is(
        &checks,
        "flash",
        "warning",
        "slot A cannot be used: settings are damaged",
    );
    is(&checks, "log", "warning", "DEFAULT SETTINGS");
    assert_eq!(code, Some(1));
    served.board.stop();
}

/// No hang, one line that says what to look at.
#[test]
fn nothing_that_answers_is_bad() {
    let folder = scratch("doctor_nobody");
    // It takes connections and says nothing.
    let mute = TcpListener::bind("127.0.0.1:0").unwrap();
    let mute = format!("tcp:{}", mute.local_addr().unwrap());
    for (port, says) in [
        ("/dev/no-such-port", "there is no such port"),
        ("tcp:127.0.0.1:1", "does the board run with --service"),
        (&mute, "is it powered, is the baud rate right"),
    ] {
        let (code, checks) = doctor(&folder, &["--port", port]);
        assert_eq!((code, checks.len()), (Some(1), 1), "{checks:#?}");
        is(
            &checks,
            "board",
            "bad",
            &format!("no board answers on {port}"),
        );
        is(&checks, "board", "bad", says);
    }
}
