//! Logs whose command a controller has made from the position, and what they must not be taken for.

use super::tables::{imported, started, table};
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_statistics::RandomStream;
use std::fmt::Write;

const MAPPING: &str = r#"
    files = { train = "a.csv", test = "b.csv" }
    starter = { wrench = "commanded" }
    time = { column = "t" }
    orientation = { rx = { column = "q", unit = "rad" } }
    executed_velocity = { derive = true }
    wrench = { frame = "sensor", tx = { column = "u", scale = -1.0 } }
    filter = { cutoff_hz = 15.0, order = 4, trim_s = 0.2 }
"#;

/// kg·m², N·m·s/rad, N·m.
const MOTOR: [f64; 3] = [0.05, 0.5, 0.1];

/// A table of 20 s at 200 Hz of a motor that cogs every 63 mrad, held at 0 by a proportional controller while a random binary torque
/// pushes it.
fn held_by_a_controller(seed: u64) -> String {
    const STEPS: usize = 20;
    const GAIN: f64 = 20.0;
    let step_s = 0.005 / STEPS as f64;
    let [inertia, damping, load] = MOTOR;
    let mut random = RandomStream::new(seed, 0);
    let [mut angle, mut rate, mut push] = [0.0_f64; 3];
    let mut text = "t,q,u\n".to_owned();
    for row in 0..4000 {
        if row % 40 == 0 {
            push = 0.5 * random.normal().signum();
        }
        let torque = push - GAIN * angle;
        let shown = angle + 1e-6 * random.normal();
        writeln!(text, "{},{shown},{torque}", 0.005 * f64::from(row)).unwrap();
        for _ in 0..STEPS {
            let cogs = 0.3 * (100.0 * angle).sin();
            let rest = torque - damping * rate - load - cogs - 0.05 * (rate / 1e-3).tanh();
            rate += step_s * rest / inertia;
            angle += step_s * rate;
        }
    }
    text
}

/// The torque answers to the cogging, which no law describes: in part it follows the angle, as the weight of an inverted pendulum
/// would, with which the motor would run away.
#[test]
fn the_command_of_a_controller_is_no_weight_above_the_axis() {
    let files = [
        ("a.csv", held_by_a_controller(1)),
        ("b.csv", held_by_a_controller(2)),
    ];
    let logs = imported("held_by_a_controller", MAPPING, &files).unwrap();
    let model = started(&logs);
    let found = diagnose(&model, &[&logs.train[0]], &[&logs.test[0]], &|_, _| {});
    let found = found.unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let expected = ["bearing_inertia", "guide_viscous", "guide_offset"];
    assert_eq!(found.effects, expected, "{}", found.sentence);
    let inertia = &found.parameters["bearing_inertia"]["inertia_error_kg_m2"];
    assert!(
        (inertia.value / MOTOR[0] - 1.0).abs() < 0.05,
        "{inertia:?}: with the weight it is a fifth too small"
    );
    let is_said = |note: &String| note.contains("A controller that makes the command");
    assert!(found.notes.iter().any(is_said), "{:?}", found.notes);
}

/// A table of 20 s at 50 Hz of a cart of half a kilogramme that a force swings to and fro by centimetres, measured to 2 mm.
fn measured_to_two_millimetres(seed: u64) -> String {
    let mut random = RandomStream::new(seed, 0);
    let noise: Vec<f64> = (0..1000).map(|_| 2e-3 * random.normal()).collect();
    let turn = if seed > 1 { 0.8 } else { 0.0 };
    table("t,x,f", noise.len(), |n| {
        let t = 0.02 * n;
        let wave = |size: f64, hz: f64| {
            let rate = std::f64::consts::TAU * hz;
            let place = size * (rate * t + turn).sin();
            [place, -place * rate * rate]
        };
        let [slow, fast] = [wave(0.03, 0.3), wave(0.01, 0.5)];
        let shown = slow[0] + fast[0] + noise[n as usize];
        format!("{t},{shown},{}", 0.5 * (slow[1] + fast[1]))
    })
}

/// The mass that moves along the guide is half of what the model says. Behind a filter of 4 Hz three quarters of the acceleration are
/// noise, and a regression on it finds a ninth; behind 2.5 Hz it finds a quarter too little, which the interval knows.
#[test]
fn noise_of_the_acceleration_takes_no_mass_away() {
    const MAPPING: &str = r#"
        files = { train = "a.csv", test = "b.csv" }
        starter = { wrench = "commanded", gravity_m_s2 = [0.0, 0.0, 0.0], mass_kg = 1.0 }
        time = { column = "t" }
        position = { x = "x" }
        executed_velocity = { derive = true }
        wrench = { fx = { column = "f", scale = -1.0 } }
        filter = { cutoff_hz = 4.0, order = 4, trim_s = 0.2 }
    "#;
    let diagnosed = |folder: &str, mapping: &str| {
        let files = [
            ("a.csv", measured_to_two_millimetres(1)),
            ("b.csv", measured_to_two_millimetres(2)),
        ];
        let logs = imported(folder, mapping, &files).unwrap();
        let model = started(&logs);
        let found = diagnose(&model, &[&logs.train[0]], &[&logs.test[0]], &|_, _| {});
        found.unwrap().diagnosis
    };
    let noisy = diagnosed("two_millimetres", MAPPING);
    assert_eq!(noisy.effects, [""; 0], "{}", noisy.sentence);
    let is_said = |note: &String| note.contains("look smaller than it is");
    assert!(noisy.notes.iter().any(is_said), "{:?}", noisy.notes);
    let quieter = diagnosed(
        "two_millimetres_quieter",
        &MAPPING.replace("4.0, order", "2.5, order"),
    );
    let correction = &quieter.parameters["tool_mass_error"]["mass_error_kg"];
    assert!(
        correction.value < -0.55 && (correction.low..correction.high).contains(&-0.5),
        "{correction:?}"
    );
}
