//! From a board that knows nothing to a docking test, with the commands of docs/commissioning.md, "From a
//! box to the first docking test". The rig is simulated, in virtual time; tool, zero and delay are
//! known to its file alone, never to the board's.

use serde_json::Value;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::Recording;
use softdock_tests::peers::{LockStepRig, Motion, PATIENCE, QemuBoard, params, serve};
use softdock_tests::process::{done, json, scratch, words};
use std::path::{Path, PathBuf};

/// The laboratory, with everything that is to be found out: a tool of 3.4 kg, zeros, 37 ms.
const RIG: &str = r#"
title = "A laboratory"
duration_s = 3.0
seed = 7
start_position_m = [1.2, 0.1, 0.9]

[rig.robot.actuator]
delay_s = 0.037
pause_s = 0.012

[rig.robot.correction_limit]
lower_m = [-0.3, -0.3, -0.3]
upper_m = [0.3, 0.3, 0.3]
max_rotation_rad = 0.4

[rig.robot.correction_monitor]
max_translation_m = 0.6
max_rotation_rad = 0.5

[rig.sensor]
tool_mass_kg = 3.4
tool_com_m = [-0.004, 0.007, 0.083]
bias_n = [-6.2, 4.1, 11.5]
bias_nm = [0.31, -0.22, 0.14]
noise_force_n = 0.1
noise_torque_nm = 0.004

[[rig.mechanism.walls]]
point_m = [1.2045, 0.1, 0.9]
normal = [-1.0, 0.0, 0.0]
stiffness_n_per_m = 220500.0
"#;

/// What a person types in: the spacecraft, the delay law. Tool, zero and robot are left to be found.
const TYPED_IN: &str = r#"# The laboratory's board
[control.body_k]                  # 500 kg against a fixed stop
mass_kg = 500.0
inertia_kg_m2 = [[180.0, 0.0, 0.0], [0.0, 220.0, 0.0], [0.0, 0.0, 210.0]]
velocity_m_s = [0.005, 0.0, 0.0]

[control.body_q]
fixed = true

[control.delay]
law = "predictor"
"#;

/// Poses in which nothing was calibrated, A, B, C in degrees.
const OTHER_POSES: [&str; 4] = ["0,0,0", "20,-35,50", "-70,15,-25", "110,40,120"];

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number, not {value}"))
}

/// A folder with the laboratory and the settings that were typed in.
fn laboratory(test: &str) -> PathBuf {
    let folder = scratch(test);
    std::fs::write(folder.join("rig.toml"), RIG).unwrap();
    std::fs::write(folder.join("board.toml"), TYPED_IN).unwrap();
    folder
}

/// A second at rest in a pose, recorded with these settings; each pose has noise of its own.
fn rest(folder: &Path, settings: &str, abc_deg: &str, seed: usize, output: &str) {
    let seed = seed.to_string();
    let arguments = [
        "run",
        "rig.toml",
        "--settings",
        settings,
        "--hold",
        "--duration-s",
        "1.5",
        "--abc-deg",
        abc_deg,
        "--seed",
        &seed,
        "-o",
        output,
    ];
    let run = json(folder, &arguments);
    assert_eq!(run["final_mode"], "Hold");
    assert_eq!(run["fault"], Value::Null);
}

/// Steps 3 and 4 of the chapter: what is found stands in `board.toml`.
fn commission(folder: &Path) {
    let plan = json(
        folder,
        &words("calibrate sensor --plan --settings board.toml --from-abc-deg 0,0,180"),
    );
    let poses = plan["poses"].as_array().unwrap();
    let files: Vec<String> = (1..=poses.len())
        .map(|n| format!("pose-{n}.mcap"))
        .collect();
    for (n, (pose, file)) in poses.iter().zip(&files).enumerate() {
        let abc: Vec<String> = (0..3).map(|k| pose["abc_deg"][k].to_string()).collect();
        rest(folder, "board.toml", &abc.join(","), n, file);
    }
    let mut calibrate = vec!["calibrate", "sensor", "--into", "board.toml", "--recording"];
    calibrate.extend(files.iter().map(String::as_str));
    let found = json(folder, &calibrate);
    let found = |name: &str| &found[name];
    let near = |value: &Value, truth: f64, tolerance: f64| {
        let error = number(value) - truth;
        assert!(error.abs() < tolerance, "{value} instead of {truth}");
    };
    near(found("mass_kg"), 3.4, 0.01);
    for (axis, truth) in [-0.004, 0.007, 0.083].into_iter().enumerate() {
        near(&found("com_m")[axis], truth, 1e-3);
    }
    for (axis, truth) in [-6.2, 4.1, 11.5].into_iter().enumerate() {
        near(&found("bias")[axis], truth, 0.1);
    }

    let jog = ["identify", "actuator", "--rehearse", "rig.toml"];
    done(folder, &[&jog[..], &["--keep", "jog.mcap"]].concat());
    let found = json(
        folder,
        &words("identify actuator --recording jog.mcap --into board.toml"),
    );
    near(&found["delay_s"]["value"], 0.037, 2e-3);
    near(&found["mean_delay_s"]["value"], 0.037, 2e-3);
    near(&found["pause_s"]["value"], 0.012, 3e-3);
}

/// Largest component of the mean contact force that is left at rest, N.
fn gravity_residual(recording: &Path) -> f64 {
    let cycles = Recording::open(recording).unwrap().cycles;
    let settled = &cycles[cycles.len() / 4..];
    let mean = |axis: usize| {
        let sum: f64 = settled.iter().map(|c| c.trace.wrench_at_m[axis]).sum();
        sum / settled.len() as f64
    };
    (0..3).map(|axis| mean(axis).abs()).fold(0.0, f64::max)
}

#[test]
fn a_fresh_board_comes_to_an_elastic_bounce() {
    let folder = laboratory("commissioning");
    // Before anything is known, the board sees a load and stays where it is.
    let before = json(
        &folder,
        &words("run rig.toml --settings board.toml -o before.mcap"),
    );
    assert!(before["impacts"].as_array().unwrap().is_empty(), "{before}");
    assert!(gravity_residual(&folder.join("before.mcap")) > 10.0);
    commission(&folder);

    // The board begins with defaults, gets the file, and has it after a reset.
    let file = folder.join("board.toml");
    let file = file.to_str().unwrap();
    let fresh = serve("commissioning_board", "", &["--flash", "flash.bin"]);
    let mass = ["get", "control.sensor.tool_mass_kg"];
    assert_eq!(number(&fresh.json(&mass)["value"]), 0.0);
    fresh.done(&["upload", file, "--yes"]);
    assert_eq!(fresh.done(&["diff", file]), "");
    let flash = fresh.board.folder.join("flash.bin");
    fresh.board.stop();
    let flash = flash.to_str().unwrap();
    let again = serve("commissioning_reset", "", &["--flash", flash]);
    assert_eq!(again.done(&["diff", file]), "");
    let dumped = folder.join("dumped.toml");
    again.done(&["dump", "-o", dumped.to_str().unwrap()]);
    again.board.stop();

    // With what the board says that it has: the weight is gone, and the bounce is elastic.
    for (n, abc_deg) in OTHER_POSES.iter().enumerate() {
        let output = format!("other-{n}.mcap");
        rest(&folder, "dumped.toml", abc_deg, 100 + n, &output);
        let left = gravity_residual(&folder.join(output));
        eprintln!("pose {abc_deg}: {left:.3} N");
        assert!(left < 1.0, "{left} N are left in {abc_deg}");
    }
    let docking = [
        "run",
        "rig.toml",
        "--settings",
        "dumped.toml",
        "-o",
        "docking.mcap",
    ];
    let run = json(&folder, &docking);
    eprintln!("{run}");
    assert_eq!(run["fault"], Value::Null);
    let impacts = run["impacts"].as_array().unwrap();
    assert_eq!(impacts.len(), 1, "{run}");
    let restitution = number(&impacts[0]["restitution"]);
    assert!((restitution - 1.0).abs() < 0.01, "{restitution}");
}

/// Speed along x after the bounce over that before it, of corrections that were sent.
fn restitution(motion: &Motion) -> f64 {
    /// Cycles of a mean: 0.2 s.
    const LONG: usize = 50;
    let sums: Vec<i64> = motion
        .windows(LONG)
        .map(|cycles| cycles.iter().map(|c| c[0]).sum())
        .collect();
    // The spacecraft flies at its speed until it leads into the contact, and at the end again.
    let before = sums[sums.len() / 5];
    -(sums[sums.len() - 1] as f64) / before as f64
}

/// The upload, the reset and the docking test once more with the microcontroller's firmware.
#[test]
#[ignore = "long: a board in QEMU that is commissioned, reset and docks"]
fn the_firmware_keeps_what_was_found_and_docks_with_it() {
    let folder = laboratory("commissioning_files");
    let file = folder.join("board.toml");
    std::fs::write(&file, format!("{TYPED_IN}{PATIENCE}")).unwrap();
    commission(&folder);
    let path = file.to_str().unwrap();
    let flash = folder.join("flash.bin");
    let flash = ["--flash", flash.to_str().unwrap()];
    let said = |board: &QemuBoard, arguments: &[&str]| {
        let run = params(&folder, &format!("tcp:{}", board.service), arguments);
        assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.stderr);
        run.stdout
    };
    let fresh = QemuBoard::start("commissioning_qemu", "", &flash);
    // What the file leaves out stays: the board's address is that of QEMU's network.
    assert_ne!(said(&fresh, &["diff", path, "--keep"]), "");
    said(&fresh, &["upload", path, "--keep", "--yes"]);
    fresh.end();

    let arguments = [&flash[..], &["--start"]].concat();
    let mut again = QemuBoard::start("commissioning_qemu_reset", "", &arguments);
    assert_eq!(said(&again, &["diff", path, "--keep"]), "");
    let mut scenario = Scenario::load(&folder.join("rig.toml")).unwrap();
    scenario.board = toml_edit::de::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    let settings = scenario.actual_board().unwrap();
    let mut rig = LockStepRig::connect(&scenario, &settings, again.robot, again.can);
    again.process().wait_for("sensor Running");
    let motion = rig.run(scenario.cycles());
    drop(rig);
    again.end();
    let restitution = restitution(&motion);
    eprintln!("restitution {restitution}");
    assert!((restitution - 1.0).abs() < 0.01, "{restitution}");
}
