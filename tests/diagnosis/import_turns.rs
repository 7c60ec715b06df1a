//! Whole turns of an axis, which a pose does not hold, come from the column of its angle.

use super::tables::{imported, table};
use softdock_analysis::compare::compare;
use softdock_analysis::import::mapping::MappedLogs;
use softdock_analysis::import::summary::Summary;
use softdock_analysis::levels::ChannelLevels;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::predict;
use softdock_physics::model::{Channel, Model};
use std::f64::consts::{PI, TAU};

/// Of a spring that rests at 0 rad.
const STIFFNESS: f64 = 2.0;

const MODEL: &str = r#"
[rig]
active_axes = ["rx"]
[sensor]
gravity_m_s2 = [0.0, 0.0, 0.0]
[noise]
torque_n_m = 0.05
angle_rad = 1e-7
[[effect]]
id = "cable_stiffness"
parameters = { stiffness_n_m_per_rad = 2.0 }
"#;

const MAPPING: &str = r#"
[time]
column = "t"
[orientation]
rx = { column = "q", unit = "rad" }
[wrench]
tx = { column = "u", unit = "N·m" }
"#;

/// A swing about an angle, of which a column shows what `shown` makes.
fn swing(about: f64, shown: impl Fn(f64) -> f64) -> String {
    table("t,q,u", 1000, |n| {
        let q = about + 0.6 * (0.01 * n).sin();
        format!("{},{},{}", 0.004 * n, shown(q), -STIFFNESS * q)
    })
}

/// As an encoder shows it that starts again after each turn.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

fn logs(test: &str, files: &str, tables: &[(&str, String)]) -> MappedLogs {
    imported(test, &(MAPPING.to_owned() + files), tables).unwrap()
}

/// Whether the spring explains the torque, of which a turn more or less would be 12 N·m.
fn is_explained(recording: &Recording) -> bool {
    let model = Model::from_toml(MODEL, "the test's model").unwrap();
    let prediction = predict(&model, recording).unwrap();
    ChannelLevels::of(&[prediction]).wrench < 0.1
}

#[test]
fn a_column_beyond_half_a_turn_keeps_its_turns_in_each_part_of_a_log() {
    for about in [3.0, -3.3, 4.0 * PI] {
        let split = "[split]\ntrain_share = 0.4\n[filter]\ncutoff_hz = 40.0\ntrim_s = 0.1\n[files]\ntrain = \"a.csv\"\n";
        let of_both = logs("whole_turns", split, &[("a.csv", swing(about, |q| q))]);
        for part in [&of_both.train[0], &of_both.test[0]] {
            assert!(is_explained(part), "{about} {}", part.header.whole_turns);
            let mut other = part.clone();
            other.header.whole_turns += 1;
            assert!(!is_explained(&other), "{about}");
        }
    }
}

#[test]
fn logs_of_a_column_that_starts_again_after_each_turn_are_a_turn_apart_at_most_once() {
    let tables = [
        ("a.csv", swing(3.0, wrapped)),
        ("b.csv", swing(3.4, wrapped)),
    ];
    let files = "[files]\ntrain = \"a.csv\"\ntest = \"b.csv\"\n";
    let both = logs("wrapped_turns", files, &tables);
    let turns = [&both.train[0], &both.test[0]].map(|part| part.header.whole_turns);
    assert_eq!(turns, [0, 1]);
    assert!(is_explained(&both.train[0]) && is_explained(&both.test[0]));
}

/// Nothing says where the first turn of a quaternion is, but that logs of one axis are near each other.
#[test]
fn logs_with_quaternions_are_on_the_same_turn() {
    let mapping = MAPPING.replace(
        "rx = { column = \"q\", unit = \"rad\" }",
        "quaternion = [\"w\", \"x\", \"y\", \"z\"]",
    );
    let swing = |about: f64| {
        table("t,w,x,y,z,u", 1000, |n| {
            let q = about + 0.3 * (0.01 * n).sin();
            let (s, c) = (0.5 * q).sin_cos();
            format!("{},{c},{s},0,0,{}", 0.004 * n, -STIFFNESS * q)
        })
    };
    let files = "[files]\ntrain = \"a.csv\"\ntest = \"b.csv\"\n";
    let tables = [("a.csv", swing(2.7)), ("b.csv", swing(3.6))];
    let both = imported("turns_of_quaternions", &(mapping + files), &tables).unwrap();
    assert!(is_explained(&both.train[0]) && is_explained(&both.test[0]));
}

/// The same about z of a flange that hangs down, whose orientation turns about no axis of C.
#[test]
fn parts_and_logs_of_a_flange_that_hangs_down_are_on_the_same_turn() {
    let mapping = MAPPING
        .replace(
            "rx = { column = \"q\", unit = \"rad\" }",
            "quaternion = [\"w\", \"x\", \"y\", \"z\"]",
        )
        .replace("tx =", "tz =");
    let swing = |about: f64, on: f64| {
        table("t,w,x,y,z,u", 1000, |n| {
            let q = about + 0.3 * (0.01 * n).sin() + on * n.min(500.0) / 500.0;
            let (s, c) = (0.5 * q).sin_cos();
            // Half a turn about x, then q about z of M.
            format!("{},0,{c},{},0,{}", 0.004 * n, -s, -STIFFNESS * q)
        })
    };
    let turned = |logs: &MappedLogs| {
        let parts = [&logs.train[0], &logs.test[0]];
        parts.map(|log| log.header.whole_turns)
    };
    let tables = [("a.csv", swing(2.7, 0.0)), ("b.csv", swing(3.6, 0.0))];
    let files = "[files]\ntrain = \"a.csv\"\ntest = \"b.csv\"\n";
    let both = imported("turns_hanging", &(mapping.clone() + files), &tables).unwrap();
    assert_eq!(turned(&both), [0, 1]);
    let tables = [("a.csv", swing(0.2, 4.0))];
    let split = "[files]\ntrain = \"a.csv\"\n[split]\ntrain_share = 0.6\n";
    let both = imported("turns_hanging_split", &(mapping + split), &tables).unwrap();
    assert_eq!(turned(&both), [0, 1]);
}

/// A motor of 0.002 kg·m² and 0.01 N·m·s/rad, of which a log holds its speed alone: up to 5 rad from row to row, which it counts. Simulated
/// forward, its speed is compared, as nobody measured an angle.
#[test]
fn a_fast_shaft_of_which_the_speed_is_known_is_followed() {
    let row = |n: f64| {
        let (sine, cosine) = (0.03 * n).sin_cos();
        let speed = 300.0 + 200.0 * sine;
        let torque = 0.002 * 600.0 * cosine + 0.01 * speed;
        format!("{},{speed},{torque}", 0.01 * n)
    };
    let mapping = "files = { train = \"log.csv\" }\ntime = { column = \"t\" }\n\
                   wrench = { tx = { column = \"u\", unit = \"N·m\", scale = -1.0 } }\n\
                   executed_velocity = { rx = { column = \"w\", unit = \"rad/s\" } }";
    let files = [("log.csv", table("t,w,u", 1200, row))];
    let logs = imported("fast_shaft", mapping, &files).unwrap();
    let turned = &Summary::of("log", &logs.train[0], &[]).channels[0];
    let integral = 300.0 * 11.99 + 200.0 / 3.0 * (1.0 - (0.03_f64 * 1199.0).cos());
    assert!(
        (turned.high - integral).abs() < 1.0,
        "{} {integral}",
        turned.high
    );

    let model = |damping: f64| {
        let text = format!(
            "rig = {{ active_axes = [\"rx\"] }}\nsensor = {{ wrench = \"commanded\", gravity_m_s2 = [0.0, 0.0, 0.0] }}\n\
             [[effect]]\nid = \"bearing_inertia\"\nparameters = {{ inertia_error_kg_m2 = 0.002 }}\n\
             [[effect]]\nid = \"guide_viscous\"\nparameters = {{ damping_n_m_s_per_rad = {damping} }}\n"
        );
        Model::from_toml(&text, "model.toml").unwrap()
    };
    let simulated = |damping: f64| {
        let comparison = compare(&model(damping), &logs.train[0]).unwrap();
        let pose = comparison.channels.iter().find(|c| c.name == Channel::Pose);
        assert!(pose.is_none_or(|pose| pose.rms < 1e-6), "{pose:?}");
        comparison.free_simulation.unwrap()
    };
    let right = simulated(0.01);
    assert!(right.of_velocity && right.relative < 0.01, "{right:?}");
    assert!(right.words().contains("the velocity of rx is off by"));
    assert!(simulated(0.011).relative > 0.1);
}
