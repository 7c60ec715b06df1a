//! What swings under no force: a pendulum of which nothing but the angle is known.

use super::tables::{imported, table};
use softdock_analysis::compare::compare;
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_analysis::import::starter::starter;
use softdock_physics::model::Model;
use softdock_statistics::RandomStream;

/// Weight, viscous and dry friction by the moment of inertia: rad/s², 1/s, rad/s².
const PENDULUM: [f64; 3] = [40.0, 0.25, 0.3];
const MAPPING: &str = r#"
    files = { train = "a.csv", test = "b.csv" }
    starter = { wrench = "free" }
    time = { column = "t" }
    orientation = { rx = { column = "angle", unit = "rad" } }
    filter = { cutoff_hz = 8.0, order = 4, trim_s = 0.3 }
"#;

/// A table of 8 s at 100 Hz that begins with this angle, rad, at rest.
fn swing(first: f64, seed: u64) -> String {
    const STEPS: usize = 200;
    let step_s = 0.01 / STEPS as f64;
    let mut random = RandomStream::new(seed, 0);
    let [mut angle, mut rate] = [first, 0.0_f64];
    let [weight, viscous, dry] = PENDULUM;
    let mut angles = Vec::new();
    for _ in 0..800 {
        angles.push(angle + 1e-5 * random.normal());
        for _ in 0..STEPS {
            let acceleration = -weight * angle.sin() - viscous * rate - dry * (rate / 1e-3).tanh();
            rate += step_s * acceleration;
            angle += step_s * rate;
        }
    }
    table("t,angle", angles.len(), |n| {
        format!("{},{}", 0.01 * n, angles[n as usize])
    })
}

#[test]
fn the_angle_of_a_pendulum_says_what_it_has_by_its_inertia() {
    let files = [("a.csv", swing(1.3, 1)), ("b.csv", swing(-0.9, 2))];
    let logs = imported("free_swing", MAPPING, &files).unwrap();
    let text = starter(&logs.train, logs.filtered.as_ref(), &logs.told)
        .unwrap()
        .text;
    let model = Model::from_toml(&text, "model.toml").unwrap();
    let (train, test) = (&logs.train[0], &logs.test[0]);
    let found = diagnose(&model, &[train], &[test], &|_, _| {}).unwrap();
    let (found, after) = (found.diagnosis, found.after);
    let mut named = found.effects.clone();
    named.sort();
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    assert_eq!(
        named,
        ["bearing_gravity", "guide_coulomb", "guide_viscous"],
        "{}",
        found.sentence
    );
    for ((id, name), truth) in [
        ("bearing_gravity", "sine_n_m"),
        ("guide_viscous", "damping_n_m_s_per_rad"),
        ("guide_coulomb", "torque_n_m"),
    ]
    .into_iter()
    .zip(PENDULUM)
    {
        let value = &found.parameters[id][name];
        assert!(value.low <= truth && truth <= value.high, "{id}: {value:?}");
        assert!((value.value - truth).abs() < 0.1 * truth, "{id}: {value:?}");
    }
    let free = compare(&after, test).unwrap().free_simulation.unwrap();
    assert!(free.relative < 0.05, "{free:?}");
    let again = diagnose(&after, &[train], &[test], &|_, _| {}).unwrap();
    assert_eq!(
        again.diagnosis.verdict,
        Verdict::NothingMissing,
        "{}",
        again.diagnosis.sentence
    );
}

#[test]
fn what_swings_freely_has_no_force() {
    let mapping = format!("{MAPPING}\n    wrench = {{ tx = \"angle\" }}");
    let files = [("a.csv", swing(1.3, 1)), ("b.csv", swing(-0.9, 2))];
    let refused = imported("free_swing_driven", &mapping, &files).unwrap_err();
    assert!(refused.contains("expected no [wrench]"), "{refused}");
}
