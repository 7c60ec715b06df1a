//! A hydraulic cylinder on a proportional valve: the valve's overlap, and two areas of the piston.

use super::tables::imported;
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_physics::model::Model;
use softdock_statistics::RandomStream;

/// Seconds from a row to the next.
const STEP_S: f64 = 0.01;
/// Openings of the valve at which the cylinder begins to move, back and forth; full opening is 1.
const OVERLAP: [f64; 2] = [-0.15, 0.25];
/// m/s per opening beyond these.
const SPEED: [f64; 2] = [0.06, 0.09];
/// Rows that a motion comes late.
const LATE: usize = 8;

/// What a cylinder does with a slow opening of several frequencies, beside a flow of its own, m/s at a time, as a table.
fn log(rows: usize, phase: f64, seed: u64, own: fn(f64) -> f64) -> String {
    let opening = |n: f64| {
        let t = STEP_S * n;
        0.5 * (1.1 * t + phase).sin() + 0.3 * (2.9 * t + 2.0 * phase).sin()
    };
    let mut random = RandomStream::new(seed, 0);
    let (mut position, mut text) = (0.0, String::from("t,u,x\n"));
    for n in 0..rows {
        let noise = 2e-5 * random.normal();
        let now = n as f64;
        text += &format!(
            "{:.2},{:.5},{:.7}\n",
            STEP_S * now,
            opening(now),
            position + noise
        );
        let late = if n >= LATE {
            opening(now - LATE as f64)
        } else {
            0.0
        };
        let [back, forth] = [late - OVERLAP[0], late - OVERLAP[1]];
        let flow = SPEED[0] * back.min(0.0) + SPEED[1] * forth.max(0.0);
        position += STEP_S * (flow + own(STEP_S * now));
    }
    text
}

/// Of the mapping, m/s: who maps the opening guesses one, here the slope through zero, half of the true one.
const SCALE: f64 = 0.04;

const MAPPING: &str = r#"
[files]
train = "train.csv"
test = "test.csv"
[time]
column = "t"
[position]
x = "x"
[executed_velocity]
derive = true
[sent_velocity]
x = { column = "u", unit = "m/s", scale = 0.04 }
"#;

const MODEL: &str = r#"
[rig]
active_axes = ["x"]
[noise]
position_m = 2e-5
"#;

#[test]
fn a_valves_overlap_is_found_with_the_gains_beyond_it() {
    let files = [
        ("train.csv", log(4000, 0.0, 1, |_| 0.0)),
        ("test.csv", log(2500, 1.0, 2, |_| 0.0)),
    ];
    let logs = imported("valve_overlap", MAPPING, &files).unwrap();
    let (train, test) = (&logs.train[0], &logs.test[0]);
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let found = diagnose(&model, &[train], &[test], &|_, _| {})
        .unwrap()
        .diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let mut named = found.effects.clone();
    named.sort();
    let expected = [
        "actuation_delay",
        "command_deadzone",
        "gain_by_direction",
        "velocity_gain",
    ];
    assert_eq!(named, expected, "{}", found.sentence);
    for (effect, parameter, truth) in truths() {
        let said = &found.parameters[effect][parameter];
        assert!(
            said.low <= truth && truth <= said.high && (said.value - truth).abs() < 0.02 * truth,
            "{parameter}: {said:?}, true {truth}"
        );
    }
}

/// A flow that no command makes goes on for many rows, which are not as many measurements.
#[test]
fn what_goes_on_for_long_widens_the_intervals() {
    let own = |t: f64| 4e-3 * ((0.97 * t).sin() + (2.7 * t + 1.0).sin() + (3.3 * t + 2.0).sin());
    let files = [
        ("train.csv", log(4000, 0.0, 1, own)),
        ("test.csv", log(2500, 1.0, 2, own)),
    ];
    let logs = imported("valve_wanders", MAPPING, &files).unwrap();
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let (train, test) = (&logs.train[0], &logs.test[0]);
    let found = diagnose(&model, &[train], &[test], &|_, _| {})
        .unwrap()
        .diagnosis;
    for (effect, parameter, truth) in truths() {
        let said = &found.parameters[effect][parameter];
        assert!(
            said.low <= truth && truth <= said.high,
            "{parameter}: {said:?}, true {truth}"
        );
    }
}

/// Effects and amounts, in the units of the mapping's scale.
fn truths() -> [(&'static str, &'static str, f64); 5] {
    let (mean, half) = (0.5 * (SPEED[0] + SPEED[1]), 0.5 * (SPEED[1] - SPEED[0]));
    let (width, centre) = (OVERLAP[1] - OVERLAP[0], 0.5 * (OVERLAP[0] + OVERLAP[1]));
    [
        ("actuation_delay", "extra_delay_s", LATE as f64 * STEP_S),
        ("command_deadzone", "width_m_s", SCALE * width),
        ("command_deadzone", "centre_m_s", SCALE * centre),
        ("velocity_gain", "gain_error", mean / SCALE - 1.0),
        ("gain_by_direction", "asymmetry", half / mean),
    ]
}
