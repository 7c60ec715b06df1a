//! `softdock calibrate sensor --port` with a board on this computer, as a user runs it.

use serde_json::Value;
use softdock_experiments::scenario::Scenario;
use softdock_tests::peers::{LockStepRig, patient, serve};
use softdock_tests::process::{json, softdock, words};
use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use toml_edit::ser::to_string_pretty;

/// What is to be found out: kg, m, N.
const MASS_KG: f64 = 3.4;
const COM_M: [f64; 3] = [-0.004, 0.007, 0.083];
const BIAS_N: [f64; 3] = [-6.2, 4.1, 11.5];
/// Cycles in each pose: 1.2 s.
const REST: usize = 300;

/// A robot with a tool that the board does not know; nothing touches it.
fn heavy_tool() -> Scenario {
    let mut scenario = Scenario::spring_rod().unwrap();
    scenario.rig.mechanism.walls.clear();
    let sensor = &mut scenario.rig.sensor;
    (sensor.tool_mass_kg, sensor.tool_com_m, sensor.bias_n) = (MASS_KG, COM_M, BIAS_N);
    scenario.board = patient(&scenario.board);
    scenario
}

/// The robot goes from pose to pose of the plan; the command takes what it needs and ends by itself.
#[test]
fn a_tool_is_found_pose_by_pose_and_uploaded() {
    let scenario = heavy_tool();
    let mut settings = scenario.board.clone();
    // Until the command listens, nobody does.
    let address = UdpSocket::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    settings.network.recorder = address.to_string().as_str().try_into().unwrap();
    let toml = to_string_pretty(&settings).unwrap();
    let mut served = serve("calibrate_live", &toml, &[]);
    let folder = served.board.folder.clone();
    let plan = "calibrate sensor --plan --settings board.toml --from-abc-deg 0,0,180";
    let plan = json(&folder, &words(plan));
    let poses: Vec<[f64; 3]> = plan["poses"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pose| serde_json::from_value(pose["abc_deg"].clone()).unwrap())
        .collect();

    let stop = Arc::new(AtomicBool::new(false));
    let (raised, robot, can) = (stop.clone(), served.board.robot, served.board.can);
    let rig = thread::spawn(move || {
        let mut rig = LockStepRig::connect(&scenario, &settings, robot, can);
        for (n, abc_deg) in poses.iter().cycle().enumerate() {
            let mut there = scenario.clone();
            there.start_abc_rad = abc_deg.map(f64::to_radians);
            there.seed = n as u64;
            rig.stand_at(&there);
            if !rig.run_until(&raised, REST) {
                return;
            }
        }
    });
    served.board.process.wait_for("sensor Running");
    let port = ["calibrate", "sensor", "--port", &served.port];
    let run = softdock(
        &folder,
        &[&port[..], &["--json", "--upload", "--keep", "poses.mcap"]].concat(),
    );
    let run = run.succeeded();
    eprintln!("{}", run.stderr);
    stop.store(true, Ordering::Relaxed);
    for says in [
        "pose 1 taken: A ",
        "Next: A ",
        "pose 6 taken: A ",
        "that is enough",
    ] {
        assert!(run.stderr.contains(says), "`{says}`: {}", run.stderr);
    }
    let found = run.json();
    let near = |value: &Value, truth: f64, tolerance: f64| {
        let value = value.as_f64().unwrap();
        assert!(
            (value - truth).abs() < tolerance,
            "{value} instead of {truth}"
        );
    };
    near(&found["mass_kg"], MASS_KG, 0.01);
    for axis in 0..3 {
        near(&found["com_m"][axis], COM_M[axis], 1e-3);
        near(&found["bias"][axis], BIAS_N[axis], 0.1);
    }
    let mass = served.json(&["get", "control.sensor.tool_mass_kg"]);
    near(&mass["value"], MASS_KG, 0.01);
    rig.join().expect("a rig that was answered");

    // The same recording gives the same answer.
    let again = ["calibrate", "sensor", "--recording", "poses.mcap"];
    let again = json(&folder, &again);
    assert_eq!(again["mass_kg"], found["mass_kg"]);
    served.board.stop();
}
