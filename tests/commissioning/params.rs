//! `softdock params` with a board on this computer, as a user runs them.

use softdock_io::recording::Recording;
use softdock_tests::peers::{BUSY_COMPUTER, RunningRobot, Sensor, Served, serve};
use softdock_tests::process::scratch;

const MASS: &str = "control.sensor.tool_mass_kg";

fn mass(served: &Served) -> f64 {
    served.json(&["get", MASS])["value"].as_f64().unwrap()
}

#[test]
fn settings_are_listed_read_and_changed_for_good() {
    let served = serve(
        "params_set",
        "[control.sensor]\ntool_mass_kg = 0.5\n",
        &["--flash", "flash.bin"],
    );
    let got = served.json(&["get", MASS]);
    let expected = serde_json::json!({ "name": MASS, "value": 0.5, "unit": "kg" });
    assert_eq!(got, expected);
    let list = served.json(&["list"]);
    let list = list["settings"].as_array().unwrap();
    assert!(list.len() > 90, "{}", list.len());
    let setting = list.iter().find(|setting| setting["name"] == MASS).unwrap();
    assert_eq!(setting["range"], serde_json::json!([0.0, 2000.0]));
    assert_eq!(setting["help"], "Mass of everything beyond the sensor, kg.");
    assert!(served.done(&["list"]).contains(MASS));

    let changed = served.json(&["set", MASS, "1.25"]);
    assert_eq!(
        (&changed["sequence"], &changed["changed"][0]["board"]),
        (&2.into(), &0.5.into())
    );
    assert_eq!(mass(&served), 1.25);
    served.done(&["set", "control.sensor.bias", "[1, 2, 3, -4, 5, 6.5]"]);
    served.done(&["set", "can.sensor", "sri"]);
    served.done(&["set", "rsi.robot_ip", "192.168.1.10"]);
    let bias = served.json(&["get", "control.sensor.bias"]);
    assert_eq!(
        bias["value"],
        serde_json::json!([1.0, 2.0, 3.0, -4.0, 5.0, 6.5])
    );

    // Back by one, with the same flash in another process.
    let back = served.json(&["rollback"]);
    assert_eq!(back["changed"][0]["name"], "rsi.robot_ip");
    let folder = served.board.folder.clone();
    let (_, log) = served.board.stop();
    assert!(log.contains("starts over"), "{log}");
    let flash = folder.join("flash.bin");
    let again = serve("params_again", "", &["--flash", flash.to_str().unwrap()]);
    assert_eq!(mass(&again), 1.25);
    let ip = again.json(&["get", "rsi.robot_ip"]);
    assert_eq!(ip["value"], "");
    again.board.stop();
}

#[test]
fn what_a_board_does_not_have_or_allow_is_named() {
    let served = serve("params_wrong", "", &[]);
    for (arguments, says) in [
        (
            &["get", "control.sensor.tool_mas_kg"][..],
            "did you mean `control.sensor.tool_mass_kg`?",
        ),
        (
            &["get", "tool_mass_kg"],
            "did you mean `control.sensor.tool_mass_kg`?",
        ),
        (
            &["set", MASS, "heavy"],
            "takes a number, 0 to 2000; found \"heavy\"",
        ),
        (
            &["set", MASS, "-1"],
            "`sensor.tool_mass_kg` is -1; allowed is 0 to 2000",
        ),
        (
            &["set", "can.sensor", "atj"],
            "does not know `atj`; did you mean `ati`?",
        ),
        (
            &["set", "control.sensor.fault_after_cycles", "1"],
            "`sensor.fault_after_cycles` is 1; allowed is 2 to 1000",
        ),
        (
            &["set", "can.base_id", "300"],
            "outside of what the setting can hold",
        ),
        (&["mode", "holt"], "did you mean `hold`?"),
        (&["mode", "arm"], "`rsi.robot_ip` is empty"),
        (&["rollback"], "no settings before the present ones"),
        (&["watch", "--json"], "--samples"),
    ] {
        let said = served.refused(arguments);
        assert!(said.contains(says), "{arguments:?}: {said}");
    }
    let status = served.json(&["status"]);
    assert_eq!(status["status"]["origin"]["Flash"]["sequence"], 1);
    assert_eq!(status["status"]["mode"], "Idle");
    let watched = served.json(&["watch", "--samples", "2", "--period", "0.05"]);
    assert_eq!(watched["samples"].as_array().unwrap().len(), 2);
    served.board.stop();
}

#[test]
fn a_file_is_dumped_changed_compared_and_uploaded() {
    let served = serve(
        "params_upload",
        "[control.sensor]\ntool_mass_kg = 0.5\n",
        &[],
    );
    let file = served.board.folder.join("dump.toml");
    served.done(&["dump", "-o", "dump.toml"]);
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(
        text.contains("# unit kg; 0 to 2000; default 0.0\ntool_mass_kg = 0.5\n"),
        "{text}"
    );
    assert_eq!(served.done(&["diff", "dump.toml"]), "");

    let other = text.replace("tool_mass_kg = 0.5", "tool_mass_kg = 0.75");
    std::fs::write(&file, other.replace("base_id = 32", "base_id = 33")).unwrap();
    let found = served.json(&["diff", "dump.toml"]);
    assert_eq!(found["differences"].as_array().unwrap().len(), 2);
    // Nobody says yes.
    let said = served.refused(&["upload", "dump.toml"]);
    assert!(
        said.contains("[y/N]") && said.contains("as they were"),
        "{said}"
    );
    assert_eq!(mass(&served), 0.5);
    let shown = served.done(&["upload", "dump.toml", "--yes"]);
    assert!(
        shown.contains("can.base_id") && shown.contains("33"),
        "{shown}"
    );
    assert_eq!(mass(&served), 0.75);
    assert_eq!(served.done(&["diff", "dump.toml"]), "");

    // What a file leaves out has its default, or stays.
    std::fs::write(&file, "[can]\nbase_id = 34\n").unwrap();
    served.done(&["upload", "dump.toml", "--yes", "--keep"]);
    assert_eq!(mass(&served), 0.75);
    served.done(&["upload", "dump.toml", "--yes"]);
    assert_eq!(mass(&served), 0.0);
    // A word that is wrong anywhere: nothing is written.
    std::fs::write(&file, "[can]\nbase_id = 35\nsensr = \"sri\"\n").unwrap();
    let said = served.refused(&["upload", "dump.toml", "--yes"]);
    assert!(
        said.contains("dump.toml:3") && said.contains("`can.sensor`"),
        "{said}"
    );
    assert_eq!(served.json(&["get", "can.base_id"])["value"], 34);
    served.board.stop();
}

/// From hold to a running loop and back by the service alone; nothing changes while it moves; and the
/// recording goes on in a file with the new settings.
#[test]
fn an_operator_works_by_the_service_alone() {
    let settings = format!("{BUSY_COMPUTER}\n[control.body_k]\nvelocity_m_s = [0.005, 0.0, 0.0]\n");
    let mut served = serve("params_mode", &settings, &[]);
    let sensor = Sensor::connect(served.board.can);
    served.board.process.wait_for("sensor Running");
    let robot = RunningRobot::start(served.board.robot);
    served.hears_its_robot();
    for (command, mode) in [("hold", "Hold"), ("arm", "Armed"), ("start", "Running")] {
        let answer = served.json(&["mode", command]);
        assert_eq!(answer["mode"], mode);
    }
    let said = served.refused(&["set", MASS, "3.0"]);
    assert!(said.contains("robot moves or is armed"), "{said}");
    let said = served.refused(&["mode", "arm"]);
    assert!(
        said.contains("arm refused in mode Running: it does not apply in this mode"),
        "{said}"
    );
    served.done(&["mode", "stop"]);
    assert_eq!(mass(&served), 0.0);
    // The stop fades out.
    while served.json(&["status"])["status"]["moves"] == true {}
    // The zero is that of 64 samples after it.
    while served.params(&["mode", "zero"]).code != Some(0) {}
    served.done(&["set", MASS, "3.0"]);
    assert_eq!(mass(&served), 3.0);
    assert_eq!(served.json(&["status"])["status"]["mode"], "Idle");
    assert!(robot.stop() > 0, "the robot moved");
    drop(sensor);
    let folder = served.board.folder.clone();
    let (first, _) = served.board.stop();
    assert!(Recording::open(&first).unwrap().cycles.len() > 10);
    let second = Recording::open(&folder.join("run-2.mcap")).unwrap();
    assert!(second.header.settings_toml.contains("tool_mass_kg = 3.0"));
}

/// A flash with anything in it but settings: the board says so, and is not armed until it has some.
#[test]
fn a_damaged_flash_gives_defaults_and_says_so() {
    let folder = scratch("params_damaged_flash");
    let flash = folder.join("flash.bin");
    let first = serve(
        "params_flash_first",
        "",
        &["--flash", flash.to_str().unwrap()],
    );
    first.board.stop();
    let mut bytes = std::fs::read(&flash).unwrap();
    bytes[100] ^= 1;
    std::fs::write(&flash, bytes).unwrap();
    let served = serve(
        "params_flash_damaged",
        "[can]\nbase_id = 9\n",
        &["--flash", flash.to_str().unwrap(), "--start"],
    );
    let status = served.done(&["status"]);
    assert!(
        status.contains("DEFAULTS, not to be armed: settings are damaged"),
        "{status}"
    );
    let said = served.refused(&["mode", "arm"]);
    assert!(said.contains("no usable settings"), "{said}");
    served.done(&["set", MASS, "1.0"]);
    let status = served.json(&["status"]);
    assert_eq!(status["status"]["origin"]["Flash"]["sequence"], 1);
    let (_, log) = served.board.stop();
    assert!(log.contains("DEFAULT SETTINGS"), "{log}");
}
