//! Copies for viewers: what they show is what was recorded, and programs for ROS 2 read all of it.

use super::sample::{Source, exact};
use proptest::prelude::*;
use serde_json::Value;
use softdock_app::record::CycleRecord;
use softdock_io::recording::{Recording, WallClock};
use softdock_tests::peers::python;
use softdock_tests::process::{done, scratch, words};
use std::fs;
use std::path::{Path, PathBuf};

const SCENARIO: &str = include_str!("../../host-tools/scenarios/spring-rod.toml");
const MODEL: &str = include_str!("../../host-tools/scenarios/spring-rod.model.toml");

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    /// Any numbers, NaN among them; the copy is a recording too.
    #[test]
    fn the_copy_holds_the_recording(seed: u64, cycles in 1..40_usize, truth: bool, table: bool) {
        let mut recording = Source(seed).recording(cycles, truth && !table);
        if table {
            recording.header.settings_toml.clear();
        }
        let path = scratch("ros2_any").join("copy.mcap");
        recording.write_ros2(None, &path).unwrap();
        prop_assert_eq!(exact(&Recording::open(&path).unwrap()), exact(&recording));
    }
}

/// What mcap_ros2 and rosbags find in a file, and in it what layouts name.
fn read(file: &Path, layouts: &[PathBuf]) -> Value {
    let folder = file.parent().unwrap();
    let mut reader = python::peer("read_ros2.py", folder);
    let found = reader.arg(file).args(layouts).output().unwrap();
    let said = String::from_utf8_lossy(&found.stderr);
    assert!(found.status.success(), "{said}");
    serde_json::from_slice(&found.stdout).unwrap()
}

fn layouts() -> Vec<PathBuf> {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let layouts = ["foxglove/docking.json", "plotjuggler/docking.xml"];
    layouts.map(|name| examples.join(name)).into()
}

/// A run, as it was recorded and with what the model predicts beside it.
#[test]
fn programs_for_ros_2_read_every_message() {
    let folder = scratch("ros2_run");
    fs::write(folder.join("scenario.toml"), SCENARIO).unwrap();
    fs::write(folder.join("model.toml"), MODEL).unwrap();
    done(&folder, &words("run scenario.toml -o run.mcap"));
    done(
        &folder,
        &words("compare model.toml run.mcap --series series.mcap"),
    );
    done(&folder, &words("export run.mcap -o view.mcap"));

    let recording = Recording::open(&folder.join("run.mcap")).unwrap();
    let cycles = recording.cycles.len();
    let recorded = read(&folder.join("run.mcap"), &[]);
    assert_eq!(recorded["counts"]["/motion"], cycles);
    let position = &recorded["first"]["/motion"]["position_m"];
    assert_eq!(position["z"], recording.cycles[0].trace.pose[2]);

    // Everything that the layouts draw is there.
    let compared = read(&folder.join("series.mcap"), &layouts());
    assert_eq!(compared["missing"], Value::Array(Vec::new()));
    assert!(
        compared["followed"].as_u64() > Some(30),
        "{}",
        compared["followed"]
    );
    assert_eq!(compared["counts"]["/compare"], cycles);
    let viewed = read(&folder.join("view.mcap"), &[]);
    assert_eq!(viewed["counts"]["/compare"], Value::Null);

    let message = |topic: &str| &compared["first"][topic];
    assert_eq!(message("/rig/wrench")["header"]["frame_id"], "M");
    assert_eq!(message("/rig/sensor_wrench")["header"]["frame_id"], "S");
    let pose = message("/rig/pose");
    assert_eq!(pose["header"]["frame_id"], "C");
    assert_eq!(pose["pose"]["position"]["x"], position["x"]);
    assert_eq!(pose["pose"]["orientation"]["w"], 1.0);
    let tree: Vec<(String, String)> = ["/tf", "/tf_static"]
        .into_iter()
        .flat_map(|topic| message(topic)["transforms"].as_array().unwrap())
        .map(|t| (text(&t["header"]["frame_id"]), text(&t["child_frame_id"])))
        .collect();
    let tree: Vec<String> = tree
        .iter()
        .map(|(of, frame)| format!("{of}{frame}"))
        .collect();
    assert_eq!(tree, ["CM", "QK", "CQ", "MS", "QP", "KJ"]);
    let drawn = message("/scene")["markers"].as_array().unwrap().iter();
    let drawn: Vec<String> = drawn.map(|marker| text(&marker["ns"])).collect();
    for name in ["flange", "sensor", "spacecraft K", "spacecraft Q"] {
        assert!(drawn.iter().any(|drawn| drawn == name), "{name}: {drawn:?}");
    }
}

fn text(value: &Value) -> String {
    value.as_str().unwrap().to_owned()
}

/// Where the recorder knew the time, messages carry it; the angular part of a velocity is in the message's frame.
#[test]
fn stamps_are_of_the_wall_clock_and_velocities_of_one_frame() {
    let mut cycle = CycleRecord::default();
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    // M is turned by 90° about z and spins about its own x, which is C's y.
    cycle.trace.time_s = 0.012;
    cycle.trace.pose = [1.0, 2.0, 3.0, quarter, 0.0, 0.0, quarter];
    cycle.trace.executed_velocity = [0.1, 0.0, 0.0, 0.5, 0.0, 0.0];
    let mut recording = Source(1).recording(1, false);
    recording.cycles = vec![cycle];
    recording.wall_clock = Some(WallClock {
        unix_s: 1_700_000_000.25,
        at_time_s: 0.004,
    });
    let file = scratch("ros2_clock").join("view.mcap");
    recording.write_ros2(None, &file).unwrap();
    let found = read(&file, &[]);

    assert_eq!(found["stamps"]["/rig/pose"], 1_700_000_000_258_000_000_u64);
    let velocity = &found["first"]["/rig/executed_velocity"];
    assert_eq!(velocity["header"]["stamp"]["sec"], 1_700_000_000);
    assert_eq!(velocity["header"]["stamp"]["nanosec"], 258_000_000);
    assert_eq!(velocity["twist"]["linear"]["x"], 0.1);
    let [x, y] = ["x", "y"].map(|axis| velocity["twist"]["angular"][axis].as_f64().unwrap());
    assert!(x.abs() < 1e-12 && (y - 0.5).abs() < 1e-12, "{velocity}");
}

/// A log of another program is told as what it has: no model, no bodies, no zeros in place of what is unknown.
#[test]
fn a_foreign_log_shows_what_it_has() {
    let mut recording = Source(2).recording(3, false);
    recording.header.settings_toml.clear();
    for (n, cycle) in recording.cycles.iter_mut().enumerate() {
        *cycle = CycleRecord::default();
        cycle.trace.cycle = n as u64;
        cycle.trace.time_s = n as f64 * 0.004;
        cycle.trace.pose = [n as f64, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        cycle.inputs.sensor.wrench[0] = 5.0 + n as f64;
    }
    let file = scratch("ros2_foreign").join("view.mcap");
    recording.write_ros2(None, &file).unwrap();
    let found = read(&file, &[]);
    let topics: Vec<&String> = found["counts"].as_object().unwrap().keys().collect();
    let expected = [
        "/contact",
        "/log",
        "/rig/pose",
        "/rig/sensor_wrench",
        "/scene",
        "/tf",
        "/tf_static",
    ];
    assert_eq!(topics, expected);
}
