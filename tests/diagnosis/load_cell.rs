//! A sensor of fewer than six axes.

use super::tables::{imported, table};
use softdock_analysis::diagnose::{Diagnosis, Verdict, diagnose};
use softdock_analysis::import::starter::{Told, starter};
use softdock_physics::model::Model;
use softdock_statistics::RandomStream;
use std::f64::consts::TAU;

/// Mass of the tool, kg, and zero of the cell, N.
const MASS_KG: f64 = 0.002;
const ZERO_N: f64 = 0.014;

/// Of a cell of one axis that is tilted by hand, and reads so late, s.
fn diagnosed(test: &str, late_s: f64) -> Diagnosis {
    let log = |begin: f64| {
        let mut noise = RandomStream::new(11, begin.to_bits());
        let noise: Vec<f64> = (0..600).map(|_| 1e-4 * noise.normal()).collect();
        let tilt = |t: f64| ((0.9 * t + begin).sin(), 0.6 * (0.4 * t).sin());
        table("t,roll,pitch,f", 600, |n| {
            let t = 0.02 * n;
            let ((roll, pitch), (roll_then, pitch_then)) = (tilt(t), tilt(t - late_s));
            // Gravity along the sensor's y.
            let weight = -MASS_KG * 9.80665 * roll_then.sin() * pitch_then.cos();
            format!("{t},{roll},{pitch},{}", ZERO_N + weight + noise[n as usize])
        })
    };
    let mapping = r#"
        files = { train = "a.csv", test = "b.csv" }
        time = { column = "t" }
        wrench = { fy = "f" }
        [orientation]
        euler = "zyx"
        rx = { column = "roll", unit = "rad" }
        ry = { column = "pitch", unit = "rad" }
    "#;
    let files = [("a.csv", log(0.0)), ("b.csv", log(1.0))];
    let logs = imported(test, mapping, &files).unwrap();
    let text = starter(&logs.train, None, &Told::default()).unwrap().text;
    let model = Model::from_toml(&text, "model.toml").unwrap();
    let found = diagnose(&model, &[&logs.train[0]], &[&logs.test[0]], &|_, _| {});
    found.unwrap().diagnosis
}

/// The weight of 2 g is named, to 0.2 mN, and the zero beside it, as what loads the other axes is not read.
#[test]
fn a_load_cell_of_one_axis_weighs_its_tool() {
    let found = diagnosed("load_cell", 0.0);
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let mut effects = found.effects.clone();
    effects.sort_unstable();
    assert_eq!(effects, ["ft_bias", "tool_mass_error"]);
    for (effect, parameter, expected) in [
        ("tool_mass_error", "mass_error_kg", MASS_KG),
        ("ft_bias", "fy_n", ZERO_N),
    ] {
        let value = found.parameters[effect][parameter].value;
        assert!((value / expected - 1.0).abs() < 0.01, "{effect}: {value}");
    }
    let wrench = found.residual_rms_sigma.after.wrench;
    assert!((0.9..1.1).contains(&wrench), "{wrench}");
}

/// Ten cycles of 20 ms are looked for: 130 ms are found, and 260 ms are not.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_reading_is_late_by_ten_cycles_at_the_most() {
    let found = diagnosed("late_load_cell", 0.13);
    let late = found.parameters["ft_latency"]["latency_s"].value;
    assert!((late - 0.13).abs() < 0.005, "{late} s");
    let found = diagnosed("later_load_cell", 0.26);
    let ends = |note: &&String| note.contains("the end of what the search tries, 0.200 s");
    let note = found.notes.iter().find(ends);
    assert!(note.is_some(), "{}: {:?}", found.sentence, found.notes);
}

/// Amounts of a damper: dry friction, N, which turns round over a speed, m/s, viscous friction, N·s/m, and an offset, N.
const DAMPER: (f64, f64, f64, f64) = (240.0, 0.0105, 780.0, 56.0);

/// A damper on a machine that moves it in a sine, whose force comes 28 ms late through a low-pass, beside errors of form that no law
/// describes. A spring, in quadrature with the velocity, imitates the delay; which foretells better tells the two apart.
#[test]
#[ignore = "long: one more machine to diagnose"]
fn a_late_force_beside_a_round_reversal_is_no_spring() {
    const LATE_S: f64 = 0.028;
    let mut noise = RandomStream::new(12, 0);
    let mut next = || noise.normal();
    let noises: Vec<[f64; 2]> = (0..2100).map(|_| [next(), next()]).collect();
    let log = table("t,x,f", 2100, |n| {
        let [of_force, of_place] = noises[n as usize];
        let t = n / 300.0;
        let (swing, frequency) = (0.0185, TAU * 1.05);
        let then = frequency * (t - LATE_S);
        let (x, v) = (swing * then.sin(), swing * frequency * then.cos());
        let (dry, over, viscous, offset) = DAMPER;
        let friction = dry * (v / over).tanh() + viscous * v + offset;
        let of_form = 14.0 * (TAU * x / 0.006).sin() + 8.0 * (TAU * 3.1 * (t - LATE_S)).sin();
        let place = 1e3 * swing * (frequency * t).sin() + 2e-3 * of_place;
        format!("{t},{place},{}", friction + of_form + of_force)
    });
    let mapping = r#"
        files = { train = "a.csv" }
        time = { column = "t" }
        position = { x = { column = "x", unit = "mm" } }
        executed_velocity = { derive = true }
        wrench = { fx = { column = "f", unit = "N", scale = -1.0 } }
        filter = { cutoff_hz = 20.0, order = 4, trim_s = 0.2 }
        split = { train_share = 0.6 }
        starter = { gravity_m_s2 = [0.0, 0.0, 0.0] }
    "#;
    let logs = imported("damper", mapping, &[("a.csv", log)]).unwrap();
    let starter = starter(&logs.train, logs.filtered.as_ref(), &logs.told).unwrap();
    let model = Model::from_toml(&starter.text, "model.toml").unwrap();
    let found = diagnose(&model, &[&logs.train[0]], &[&logs.test[0]], &|_, _| {});
    let found = found.unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let mut effects = found.effects.clone();
    effects.sort_unstable();
    let expected = [
        "ft_latency",
        "guide_coulomb",
        "guide_offset",
        "guide_viscous",
    ];
    assert_eq!(effects, expected, "{}", found.sentence);
    let late = found.parameters["ft_latency"]["latency_s"].value;
    assert!((late - LATE_S).abs() < 0.001, "{late} s");
    let dry = found.parameters["guide_coulomb"]["force_n"].value;
    assert!((dry / DAMPER.0 - 1.0).abs() < 0.06, "{dry} N");
}
