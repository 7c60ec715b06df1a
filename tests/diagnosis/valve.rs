//! A hydraulic cylinder on a proportional valve: the valve's overlap, and two areas of the piston.

use super::tables::imported;
use softdock_analysis::diagnose::{Diagnosis, Verdict, diagnose};
use softdock_physics::model::Model;
use softdock_statistics::RandomStream;

/// Seconds from a row to the next.
const STEP_S: f64 = 0.01;
/// Openings of the valve at which the cylinder begins to move, back and forth; full opening is 1.
const OVERLAP: [f64; 2] = [-0.15, 0.25];
/// m/s per opening beyond these.
const SPEED: [f64; 2] = [0.06, 0.09];
/// Rows that a motion comes late.
const LATE: u16 = 8;

/// A slow opening of two frequencies at a time, s.
fn opening(t: f64, phase: f64) -> f64 {
    0.5 * (1.1 * t + phase).sin() + 0.3 * (2.9 * t + 2.0 * phase).sin()
}

/// The same in steps of a quarter.
fn switched(t: f64, phase: f64) -> f64 {
    0.25 * (4.0 * opening(t, phase)).round()
}

/// What a cylinder does with an opening, beside a flow of its own, m/s at a time, as two tables of 40 and 25 s.
fn logs(opening: fn(f64, f64) -> f64, own: fn(f64) -> f64) -> [(&'static str, String); 2] {
    let log = |rows: u16, phase: f64, seed: u64| {
        let mut random = RandomStream::new(seed, 0);
        let (mut position, mut text) = (0.0, String::from("t,u,x\n"));
        for n in 0..rows {
            let (t, seen) = (STEP_S * f64::from(n), position + 2e-5 * random.normal());
            text += &format!("{t:.2},{:.5},{seen:.7}\n", opening(t, phase));
            let late = match n.checked_sub(LATE) {
                Some(n) => opening(STEP_S * f64::from(n), phase),
                None => 0.0,
            };
            let [back, forth] = OVERLAP.map(|edge| late - edge);
            let flow = SPEED[0] * back.min(0.0) + SPEED[1] * forth.max(0.0);
            position += STEP_S * (flow + own(t));
        }
        text
    };
    [
        ("train.csv", log(4000, 0.0, 1)),
        ("test.csv", log(2500, 1.0, 2)),
    ]
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
    let found = diagnosed("valve_overlap", "", &logs(opening, |_| 0.0));
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
    within(&found, 0.02);
}

/// Positions that are differentiated behind a low-pass: what was sent keeps its jumps.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_valve_that_is_switched_is_found_behind_a_filter() {
    let filter = "[filter]\ncutoff_hz = 4.0\ntrim_s = 0.5\n";
    let found = diagnosed("valve_filtered", filter, &logs(switched, |_| 0.0));
    within(&found, 0.03);
}

/// What a model has is not named once more beside the zone.
#[test]
fn a_gain_that_is_known_stays_alone() {
    let known = SPEED.iter().sum::<f64>() / (2.0 * SCALE) - 1.0;
    let gain = format!("[[effect]]\nid = \"velocity_gain\"\nparameters.gain_error = {known}\n");
    let model = Model::from_toml(&format!("{MODEL}{gain}"), "model.toml").unwrap();
    let logs = imported("valve_known_gain", MAPPING, &logs(opening, |_| 0.0)).unwrap();
    let (train, test) = (&logs.train[0], &logs.test[0]);
    let found = diagnose(&model, &[train], &[test], &|_, _| {}).unwrap();
    let mut named = found.diagnosis.effects;
    named.sort();
    let expected = ["actuation_delay", "command_deadzone", "gain_by_direction"];
    assert_eq!(named, expected, "{}", found.diagnosis.sentence);
}

/// A pump that is told one direction shows where its motion begins, and nothing of the other edge.
#[test]
fn a_pump_that_is_told_one_direction_begins_at_its_edge() {
    let pump = |t, phase| opening(t, phase).abs();
    let found = diagnosed("valve_one_way", "", &logs(pump, |_| 0.0));
    let zone = &found.parameters["command_deadzone"];
    let [width, centre] = ["width_m_s", "centre_m_s"].map(|name| zone[name].value);
    let edge = (centre + 0.5 * width) / SCALE;
    assert!((edge - OVERLAP[1]).abs() < 0.01, "{edge}: {zone:?}");
    let gain = SCALE * (1.0 + found.parameters["velocity_gain"]["gain_error"].value);
    assert!((gain - SPEED[1]).abs() < 0.02 * SPEED[1], "{gain} m/s");
}

/// A flow that no command makes goes on for many rows, which are not as many measurements.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn what_goes_on_for_long_widens_the_intervals() {
    let own = |t: f64| 4e-3 * ((0.97 * t).sin() + (2.7 * t + 1.0).sin() + (3.3 * t + 2.0).sin());
    within(&diagnosed("valve_wanders", "", &logs(opening, own)), 0.2);
}

fn diagnosed(test: &str, filter: &str, files: &[(&str, String)]) -> Diagnosis {
    let logs = imported(test, &format!("{MAPPING}{filter}"), files).unwrap();
    let mut model = Model::from_toml(MODEL, "model.toml").unwrap();
    model.sensor.filter = logs.filtered.map(|filtered| filtered.filter);
    let (train, test) = (&logs.train[0], &logs.test[0]);
    let found = diagnose(&model, &[train], &[test], &|_, _| {});
    found.unwrap().diagnosis
}

/// Each interval holds the truth, and each amount is off by no more than a share of it.
fn within(found: &Diagnosis, share: f64) {
    for (effect, parameter, truth) in truths() {
        // What comes late as a whole is a delay of the drive, or the clock of what was measured.
        let [effect, parameter] = match effect {
            "actuation_delay" if found.parameters.contains_key("clock_offset") => {
                ["clock_offset", "offset_s"]
            }
            _ => [effect, parameter],
        };
        let said = &found.parameters[effect][parameter];
        assert!(
            said.low <= truth && truth <= said.high && (said.value - truth).abs() < share * truth,
            "{parameter}: {said:?}, true {truth}"
        );
    }
}

/// Effects and amounts, in the units of the mapping's scale.
fn truths() -> [(&'static str, &'static str, f64); 5] {
    let (mean, half) = (0.5 * (SPEED[0] + SPEED[1]), 0.5 * (SPEED[1] - SPEED[0]));
    let (width, centre) = (OVERLAP[1] - OVERLAP[0], 0.5 * (OVERLAP[0] + OVERLAP[1]));
    [
        ("actuation_delay", "extra_delay_s", f64::from(LATE) * STEP_S),
        ("command_deadzone", "width_m_s", SCALE * width),
        ("command_deadzone", "centre_m_s", SCALE * centre),
        ("velocity_gain", "gain_error", mean / SCALE - 1.0),
        ("gain_by_direction", "asymmetry", half / mean),
    ]
}
