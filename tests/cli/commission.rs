//! `softdock calibrate sensor` and `softdock identify actuator` from outside.
//!
//! The recordings of real machines are not part of the project: `SOFTDOCK_DATA` names the folder
//! that holds them.

use serde_json::Value;
use softdock_tests::process::{json, recorded_data, scratch, softdock, words};
use std::path::Path;

fn repository(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.join(path).display().to_string()
}

/// 100 poses of a real sensor: what is left of poses that were kept back is less than 0.285 N, and
/// that the zero drifted is said.
#[test]
fn a_real_sensor_is_calibrated_into_the_settings() {
    let Some(data) = recorded_data("ft_gravity_ati") else {
        return;
    };
    let folder = scratch("calibrate_ati");
    let settings = folder.join("board.toml");
    let own =
        "# mine\n[control.sensor]\nbias = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0] # from the lab book\n";
    std::fs::write(&settings, own).unwrap();
    let found = json(
        &folder,
        &[
            "calibrate",
            "sensor",
            "--recording",
            data.to_str().unwrap(),
            "--mapping",
            &repository("examples/ati-gravity/mapping.toml"),
            "--into",
            "board.toml",
            "-o",
            "sensor.toml",
            "--report",
            "sensor.html",
        ],
    );
    assert!(
        found["residual_rms_n"].as_f64().unwrap() <= 0.285,
        "{found}"
    );
    let weight = found["mass_kg"].as_f64().unwrap() * 9.81;
    assert!((weight - 12.15).abs() < 0.05, "{weight} N");
    for (axis, expected) in [-3.46, -4.70, -16.68].into_iter().enumerate() {
        let zero = found["bias"][axis].as_f64().unwrap();
        assert!((zero - expected).abs() < 0.05, "{axis}: {zero} N");
    }
    assert_eq!(found["com_m"].as_array().unwrap().len(), 3);
    assert!(found["condition"].as_f64().unwrap() < 10.0);
    let drift = |n: &Value| n.as_str().unwrap().contains("drift");
    assert!(
        found["notes"].as_array().unwrap().iter().any(drift),
        "{found}"
    );
    let changed = std::fs::read_to_string(&settings).unwrap();
    assert!(changed.starts_with("# mine\n"), "{changed}");
    assert!(changed.contains("# from the lab book"), "{changed}");
    assert!(changed.contains("tool_mass_kg = 1.23"), "{changed}");
    let page = std::fs::read_to_string(folder.join("sensor.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("centre of mass"));
}

#[test]
fn a_plan_is_printed_without_any_recording() {
    let folder = scratch("calibrate_plan");
    let plan = json(&folder, &["calibrate", "sensor", "--plan"]);
    let poses = plan["poses"].as_array().unwrap();
    assert!(poses.len() >= 6);
    assert!(poses.last().unwrap()["condition"].as_f64().unwrap() < 5.0);
}

/// The simulated robot of the paper: 32 ms late, with a pause of 16 ms.
#[test]
fn the_rehearsed_robot_is_identified_into_the_settings() {
    let folder = scratch("identify_rehearsal");
    std::fs::write(folder.join("board.toml"), "[can]\nbase_id = 3\n").unwrap();
    let found = json(
        &folder,
        &[
            "identify",
            "actuator",
            "--rehearse",
            &repository("host-tools/scenarios/spring-rod.toml"),
            "--axis",
            "y",
            "--keep",
            "jog.mcap",
            "--into",
            "board.toml",
            "--report",
            "robot.html",
        ],
    );
    let close = |name: &str, expected: f64, tolerance: f64| {
        let estimate = &found[name];
        let value = estimate["value"].as_f64().unwrap();
        assert!((value - expected).abs() < tolerance, "{name}: {estimate}");
        assert!(estimate["low"].as_f64().unwrap() <= value);
        assert!(estimate["high"].as_f64().unwrap() >= value);
    };
    close("delay_s", 0.032, 1e-3);
    close("lag_s", 0.0, 1e-3);
    close("pause_s", 0.016, 2e-3);
    close("mean_delay_s", 0.032, 1e-3);
    let changed = std::fs::read_to_string(folder.join("board.toml")).unwrap();
    assert!(changed.contains("[control.delay.actuator]"), "{changed}");
    // The recording alone says the same.
    let again = json(&folder, &words("identify actuator --recording jog.mcap"));
    assert_eq!(again["delay_s"], found["delay_s"]);
}

/// A real robot joint: the velocity follows two or three samples of 8 ms after the flag along a ramp,
/// overshoots, and catches up with the place, so that it ends 20.9 ms behind the command (row 300).
/// No structure has all of that, and the tool says so.
#[test]
fn a_real_joint_is_identified() {
    let Some(data) = recorded_data("ur_delay") else {
        return;
    };
    let folder = scratch("identify_ur5");
    let found = json(
        &folder,
        &[
            "identify",
            "actuator",
            "--recording",
            data.to_str().unwrap(),
            "--mapping",
            &repository("examples/ur5-delay/mapping.toml"),
        ],
    );
    let mean = found["mean_delay_s"]["value"].as_f64().unwrap();
    assert!((mean - 0.0209).abs() < 1e-3, "{mean}");
    let said = |n: &Value| n.as_str().unwrap().contains("No structure explains");
    assert!(
        found["notes"].as_array().unwrap().iter().any(said),
        "{found}"
    );
    assert!(
        found["pause_s"].is_null(),
        "nothing reverses in this recording"
    );
}

#[test]
fn what_is_not_enough_is_an_error_that_helps() {
    let folder = scratch("commission_errors");
    let keep = [
        "--rehearse",
        &repository("host-tools/scenarios/spring-rod.toml"),
        "--keep",
        "jog.mcap",
    ];
    json(&folder, &[&["identify", "actuator"][..], &keep].concat());
    // The jog never rests for long.
    let run = softdock(&folder, &["calibrate", "sensor", "--recording", "jog.mcap"]);
    assert_eq!(run.code, Some(1));
    assert!(
        run.stdout.is_empty() && run.stderr.contains("never rests"),
        "{}",
        run.stderr
    );
    let run = softdock(
        &folder,
        &words("calibrate sensor --recording jog.mcap --gravity 0,0,-1e9"),
    );
    assert!(run.stderr.contains("expected about 9.81"), "{}", run.stderr);
}
