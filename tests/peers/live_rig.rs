//! `softdock rig` in real time against `softdock board`, as a user starts them in two terminals. The computer may be as
//! busy as it likes: nothing here depends on how many answers come in time.

use serde_json::Value;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::{Recording, WALL_CLOCK};
use softdock_tests::peers::{Served, patient, serve};
use softdock_tests::process::{Running, done, json, scratch, softdock, softdock_binary, words};
use std::collections::BTreeMap;
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::Command;
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use toml_edit::ser::to_string_pretty;

const ANY: &str = "127.0.0.1:0";
/// A port on which nobody listens: of a service that no computer has.
const NOBODY: &str = "127.0.0.1:1";

/// The spring-rod test with a robot and a board that forgive late answers.
fn spring_rod() -> Scenario {
    let mut scenario = Scenario::spring_rod().unwrap();
    scenario.board = patient(&scenario.board);
    scenario.rig.robot.timeout_cycles = 1_000_000;
    scenario
}

/// A board with the scenario's settings, its scenario beside it.
fn board(test: &str, scenario: &Scenario, arguments: &[&str]) -> Served {
    let served = serve(test, &to_string_pretty(&scenario.board).unwrap(), arguments);
    let text = scenario.to_toml().unwrap();
    std::fs::write(served.board.folder.join("rig.toml"), text).unwrap();
    served
}

fn rig(folder: &Path, arguments: &[&str]) -> Running {
    let mut command = Command::new(softdock_binary());
    command
        .current_dir(folder)
        .args(["rig", "rig.toml", "--json"])
        .args(arguments);
    Running::start("rig", &mut command)
}

/// The rig of a board, on CAN.
fn rig_of(served: &Served, arguments: &[&str]) -> Running {
    let (robot, can) = (served.board.robot.to_string(), served.board.can.to_string());
    let addresses = ["--robot", &robot, "--can", &can];
    rig(&served.board.folder, &[&addresses[..], arguments].concat())
}

/// Ends it with Ctrl-C: its summary.
fn end(rig: Running) -> Value {
    rig.interrupt();
    let (status, log) = rig.finish();
    assert!(status.success(), "{log}");
    let json = &log[log.find("{\n").unwrap()..=log.rfind('}').unwrap()];
    serde_json::from_str(json).unwrap()
}

/// Cycles since the board's boot.
fn cycles(served: &Served) -> u64 {
    served.json(&["status"])["counters"]["cycles"]
        .as_u64()
        .unwrap()
}

fn docks(mut rig: Running) -> Value {
    rig.wait_for("answers: RSI runs");
    rig.wait_for("the spacecraft touch");
    rig.wait_for("the spacecraft have parted");
    let summary = end(rig);
    assert!(summary["in_time"].as_u64() > Some(0), "{summary}");
    assert!(summary["contacts"].as_u64() > Some(0), "{summary}");
    assert!(
        summary["greatest_force_n"].as_f64() > Some(10.0),
        "{summary}"
    );
    summary
}

/// The sensor runs, the board arms and starts, the spacecraft touches and flies back.
#[test]
fn it_docks_over_can() {
    let mut served = board("live_can", &spring_rod(), &["--start"]);
    let rig = rig_of(&served, &[]);
    served.board.process.wait_for("sensor Running");
    docks(rig);
    let (recording, log) = served.board.stop();
    assert!(log.contains("mode Running"), "{log}");
    let cycles = Recording::open(&recording).unwrap().cycles;
    let velocity = |speed: f64| (speed * 1e3).round();
    let speeds = cycles.iter().map(|c| velocity(c.trace.body_k.velocity[0]));
    let speeds: Vec<f64> = speeds.collect();
    assert!(speeds.contains(&5.0), "it flew towards the stop");
    assert!(speeds.iter().any(|speed| *speed <= -5.0), "it came back");

    // The recording knows what time it was.
    let clock = wall_clock(&recording);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    let unix_s: f64 = clock["unix_s"].parse().unwrap();
    assert!(unix_s > 1.7e9 && unix_s < now.as_secs_f64(), "{clock:?}");
    let at_time_s: f64 = clock["at_time_s"].parse().unwrap();
    assert_eq!(at_time_s, cycles[0].trace.time_s);
    let bytes = std::fs::read(&recording).unwrap();
    let first = mcap::MessageStream::new(&bytes).unwrap().next().unwrap();
    let logged_ns = first.unwrap().log_time;
    // Both are whole microseconds, one rounded and one cut off; seconds since 1970 have steps of a quarter of one.
    assert!(
        logged_ns.abs_diff((unix_s * 1e9) as u64) < 2000,
        "{logged_ns} {clock:?}"
    );
}

/// What a recording says about the instant of its first cycle.
fn wall_clock(recording: &Path) -> BTreeMap<String, String> {
    let bytes = std::fs::read(recording).unwrap();
    let records = mcap::read::LinearReader::new(&bytes).unwrap();
    let mut clocks = records.filter_map(|record| match record.unwrap() {
        mcap::records::Record::Metadata(found) if found.name == WALL_CLOCK => Some(found.metadata),
        _ => None,
    });
    clocks.next().expect("a record of the wall clock")
}

#[test]
fn it_docks_over_ethercat() {
    let mut scenario = spring_rod();
    scenario.board.ethercat.enabled = true;
    let served = board("live_ethercat", &scenario, &["--start", "--ethercat", ANY]);
    let robot = served.board.robot.to_string();
    let segment = served.board.ethercat.unwrap().to_string();
    let addresses = ["--robot", &robot, "--ethercat", &segment];
    docks(rig(&served.board.folder, &addresses));
    served.board.stop();
}

/// The force that a hidden effect adds is what the board measures, of the size that --reveal tells.
#[test]
fn what_is_hidden_is_in_the_recording() {
    let served = board("live_hidden", &spring_rod(), &[]);
    let hide = ["--hide", "ft_bias", "--seed", "3"];
    let reveal = [&["rig", "rig.toml", "--reveal"], &hide[..]].concat();
    let told = json(&served.board.folder, &reveal);
    let told = told[0]["parameters"].as_object().unwrap();
    let mut rig = rig_of(&served, &hide);
    rig.wait_for("answers: RSI runs");
    served.done(&["mode", "hold"]);
    while cycles(&served) < 100 {}
    end(rig);
    let cycles = Recording::open(&served.board.stop().0).unwrap().cycles;
    let held = cycles.iter().skip(20);
    for (axis, name) in ["fx_n", "fy_n", "fz_n"].into_iter().enumerate() {
        let hidden = told.get(name).map_or(0.0, |v| v.as_f64().unwrap());
        let (count, sum) = held.clone().fold((0.0, 0.0), |(count, sum), cycle| {
            (count + 1.0, sum + cycle.trace.wrench_at_m[axis])
        });
        let mean: f64 = sum / count;
        assert!((mean - hidden).abs() < 0.05, "{name}: {mean}, {told:?}");
    }
}

/// The robot of the scenario is late by 18 ms, and jogged it shows that.
#[test]
#[ignore = "long: a jog in real time"]
fn the_jog_of_a_live_rig_is_identified() {
    let telemetry = UdpSocket::bind(ANY).unwrap();
    let address = telemetry.local_addr().unwrap().to_string();
    drop(telemetry);
    let scenario = scratch("live_jog_files");
    done(&scenario, &["init", "."]);
    let mut scenario = Scenario::load(&scenario.join("scenario.toml")).unwrap();
    scenario.rig.mechanism.walls.clear();
    scenario.board = patient(&scenario.board);
    scenario.board.network.recorder = address.as_str().try_into().unwrap();
    let mut served = board("live_jog", &scenario, &[]);
    let rig = rig_of(&served, &["--patient"]);
    served.board.process.wait_for("sensor Running");
    served.done(&["mode", "hold"]);
    let folder = served.board.folder.clone();
    let identify = ["identify", "actuator", "--port", &served.port, "--yes"];
    let found = json(&folder, &identify);
    let late_s = found["mean_delay_s"]["value"].as_f64().unwrap();
    assert!((late_s - 0.018).abs() < 0.0005, "{late_s}");
    end(rig);
    served.board.stop();
}

/// The laboratory exercise of docs/live-rig.md: the secret is named, on a computer as busy as it is.
#[test]
#[ignore = "long: four docking tests of ten seconds in real time, and two diagnoses"]
fn what_a_live_rig_hides_is_named() {
    for seed in ["4", "7"] {
        let folder = scratch(&format!("live_exercise_{seed}"));
        done(&folder, &["init", "."]);
        let board = std::fs::read_to_string(folder.join("board.toml")).unwrap();
        let there = "velocity_m_s = [0.040, 0.003, -0.002]";
        let back = board.replace(there, "velocity_m_s = [-0.047, 0.003, -0.002]");
        assert_ne!(board, back);
        let hide = ["--hide", "any", "--seed", seed];
        for (name, settings) in [("train", board), ("test", back)] {
            let served = serve(
                &format!("live_exercise_{seed}_{name}"),
                &settings,
                &["--start"],
            );
            let scenario = folder.join("scenario.toml");
            std::fs::copy(scenario, served.board.folder.join("rig.toml")).unwrap();
            let mut rig = rig_of(&served, &[&hide[..], &["--patient"]].concat());
            rig.wait_for("answers: RSI runs");
            while cycles(&served) < 2500 {
                thread::sleep(Duration::from_millis(500));
            }
            end(rig);
            let (recording, _) = served.board.stop();
            std::fs::copy(recording, folder.join(format!("{name}.mcap"))).unwrap();
        }
        let rig = ["rig", "scenario.toml", "--reveal"];
        let secret = json(&folder, &[&rig[..], &hide].concat());
        let diagnose = "diagnose model.toml train.mcap --test test.mcap";
        let diagnosis = json(&folder, &words(diagnose));
        let named = diagnosis["effects"].as_array().unwrap();
        assert!(named.contains(&secret[0]["id"]), "{diagnosis}");
    }
}

#[test]
fn any_effect_is_one_that_the_rig_can_hide() {
    let folder = scratch("live_any");
    std::fs::write(folder.join("rig.toml"), spring_rod().to_toml().unwrap()).unwrap();
    let reveal = |arguments: &[&str]| {
        let all = [&["rig", "rig.toml", "--reveal"], arguments].concat();
        softdock(&folder, &all)
    };
    let drawn = |seed: &str| reveal(&["--hide", "any", "--seed", seed]).stdout;
    assert!(!drawn("7").is_empty());
    assert_eq!(drawn("7"), drawn("7"));
    assert_ne!(drawn("7"), drawn("8"));
    // A secret without a seed is a new one each time: nobody can tell which is meant.
    let which = reveal(&["--hide", "any"]);
    assert_eq!(which.code, Some(1));
    assert!(
        which.stderr.contains("--seed with the number"),
        "{}",
        which.stderr
    );
    let refused = reveal(&["--hide", "sc_mass_error"]);
    assert_eq!(refused.code, Some(1));
    assert!(
        refused.stderr.contains("control.body_k"),
        "{}",
        refused.stderr
    );
}

#[test]
fn a_board_that_is_not_there_is_said_to_be_missing() {
    let folder = scratch("live_nobody");
    std::fs::write(folder.join("rig.toml"), spring_rod().to_toml().unwrap()).unwrap();
    let mut alone = rig(&folder, &["--robot", NOBODY, "--can", NOBODY]);
    alone.wait_for("nobody takes the sensor on TCP 127.0.0.1:1");
    alone.wait_for("no board answers on UDP 127.0.0.1:1");
    alone.interrupt();
    let (status, log) = alone.finish();
    assert_eq!(status.code(), Some(1));
    assert!(log.contains("error: no board answered on UDP"), "{log}");

    // Somebody listens, and is no board.
    let (mute, line) = (
        UdpSocket::bind(ANY).unwrap(),
        TcpListener::bind(ANY).unwrap(),
    );
    let mute = mute.local_addr().unwrap().to_string();
    let line = line.local_addr().unwrap().to_string();
    let mut wrong = rig(&folder, &["--robot", &mute, "--can", &line]);
    wrong.wait_for("nobody asks the sensor for readings on TCP");
    let (status, _) = {
        wrong.interrupt();
        wrong.finish()
    };
    assert_eq!(status.code(), Some(1));
    let bounded = rig(
        &folder,
        &["--robot", &mute, "--can", &line, "--seconds", "0.1"],
    );
    assert_eq!(bounded.finish().0.code(), Some(1));
}

/// The board ends and another one begins in its place: the rig comes back by itself.
#[test]
fn a_board_that_starts_over_is_found_again() {
    let scenario = spring_rod();
    let first = board("live_again_1", &scenario, &[]);
    let (robot, can) = (first.board.robot.to_string(), first.board.can.to_string());
    let mut rig = rig_of(&first, &[]);
    rig.wait_for("answers: RSI runs");
    first.board.stop();
    rig.wait_for("the board has let go of the sensor");
    let mut command = Command::new(softdock_binary());
    let folder = scratch("live_again_2");
    std::fs::write(
        folder.join("board.toml"),
        to_string_pretty(&scenario.board).unwrap(),
    )
    .unwrap();
    command
        .current_dir(&folder)
        .args(["board", "--settings", "board.toml", "--start"])
        .args(["--robot", &robot, "--can", &can]);
    let mut second = Running::start("board", &mut command);
    second.wait_for("mode Running");
    rig.wait_for("the sensor is connected");
    second.interrupt();
    second.finish();
    end(rig);
}

/// The commands for a board that is there, on one whose rig is played.
#[test]
fn the_commands_for_a_live_board_work_on_it() {
    let recorder = UdpSocket::bind(ANY).unwrap();
    let address = recorder.local_addr().unwrap().to_string();
    drop(recorder);
    let mut scenario = spring_rod();
    scenario.rig.mechanism.walls.clear();
    scenario.rig.sensor.tool_mass_kg = 3.4;
    scenario.board.network.recorder = address.as_str().try_into().unwrap();
    let mut served = board("live_commands", &scenario, &[]);
    let mut rig = rig_of(&served, &["--abc-deg", "0,0,180"]);
    served.board.process.wait_for("sensor Running");
    let folder = served.board.folder.clone();
    served.done(&["mode", "hold"]);

    let run = softdock(&folder, &["doctor", "--json", "--port", &served.port]);
    let checks = run.json();
    for name in ["board", "robot link", "sensor", "sensor status"] {
        let checks = checks["checks"].as_array().unwrap();
        let check = checks.iter().find(|check| check["name"] == name).unwrap();
        assert_eq!(check["state"], "good", "{check}");
    }

    // Poses are typed as the command asks for them.
    let mut command = Command::new(softdock_binary());
    command
        .current_dir(&folder)
        .args(["calibrate", "sensor", "--port", &served.port, "--json"]);
    let mut calibrate = Running::start("calibrate", &mut command);
    while let Some(line) = calibrate.heard_or_ended(" taken: A ") {
        let Some((_, next)) = line.split_once("Next: A ") else {
            continue;
        };
        let numbers = next
            .split([',', '°', ' '])
            .filter_map(|word| word.parse::<f64>().ok());
        let abc: Vec<String> = numbers.take(3).map(|degrees| degrees.to_string()).collect();
        rig.say(&abc.join(","));
    }
    let (status, log) = calibrate.finish();
    assert!(status.success(), "{log}");
    let json = &log[log.find("{\n").unwrap()..=log.rfind('}').unwrap()];
    let found: Value = serde_json::from_str(json).unwrap();
    let mass_kg = found["mass_kg"].as_f64().unwrap();
    assert!((mass_kg - 3.4).abs() < 0.05, "{mass_kg}");

    let mut command = Command::new(softdock_binary());
    command
        .current_dir(&folder)
        .args(["record", "--listen", &address, "-o", "live.mcap"]);
    let mut record = Running::start("record", &mut command);
    record.wait_for("listening");
    let before = cycles(&served);
    while cycles(&served) < before + 500 {}
    record.interrupt();
    let (status, log) = record.finish();
    assert!(status.success(), "{log}");
    assert!(
        Recording::open(&folder.join("live.mcap"))
            .unwrap()
            .cycles
            .len()
            > 100
    );
    end(rig);
    served.board.stop();
}
