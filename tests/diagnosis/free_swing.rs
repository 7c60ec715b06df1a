//! What swings under no force: a pendulum of which nothing but the angle is known.

use super::joint::named;
use super::tables::{imported, started, table};
use softdock_analysis::compare::compare;
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_statistics::RandomStream;

/// Weight, viscous and dry friction by the moment of inertia: rad/s², 1/s, rad/s².
const PENDULUM: [f64; 3] = [40.0, 0.25, 0.3];
/// One that swings for minutes.
const LIGHTLY_DAMPED: [f64; 3] = [40.0, 0.03, 0.0];
const MAPPING: &str = r#"
    files = { train = "a.csv", test = "b.csv" }
    starter = { wrench = "free" }
    time = { column = "t" }
    orientation = { rx = { column = "angle", unit = "rad" } }
    filter = { cutoff_hz = 8.0, order = 4, trim_s = 0.3 }
"#;

/// A table of 8 s at 100 Hz that begins with this angle, rad, at rest; `off`: how much the encoder is off, rad.
fn swing([weight, viscous, dry]: [f64; 3], off: f64, first: f64, seed: u64) -> String {
    const STEPS: usize = 200;
    let step_s = 0.01 / STEPS as f64;
    let mut random = RandomStream::new(seed, 0);
    let [mut angle, mut rate] = [first, 0.0_f64];
    let mut angles = Vec::new();
    for _ in 0..800 {
        let shown = angle + off * (2.7 * angle).sin();
        angles.push(shown + 1e-5 * random.normal());
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
    let files = [
        ("a.csv", swing(PENDULUM, 0.0, 1.3, 1)),
        ("b.csv", swing(PENDULUM, 0.0, -0.9, 2)),
    ];
    let logs = imported("free_swing", MAPPING, &files).unwrap();
    let model = started(&logs);
    let (train, test) = (&logs.train[0], &logs.test[0]);
    let found = diagnose(&model, &[train], &[test], &|_, _| {}).unwrap();
    let (found, after) = (found.diagnosis, found.after);
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    assert_eq!(
        named(&found),
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

/// Its damping is a thousandth of its weight, and no error of the form of that law: what stores energy takes none away.
#[test]
fn a_damping_that_is_small_beside_the_weight_is_named() {
    let files = [
        ("a.csv", swing(LIGHTLY_DAMPED, 3e-3, 1.3, 1)),
        ("b.csv", swing(LIGHTLY_DAMPED, 3e-3, -0.9, 2)),
    ];
    let logs = imported("lightly_damped", MAPPING, &files).unwrap();
    let model = started(&logs);
    let found = diagnose(&model, &[&logs.train[0]], &[&logs.test[0]], &|_, _| {})
        .unwrap()
        .diagnosis;
    assert_eq!(
        named(&found),
        ["bearing_gravity", "guide_viscous"],
        "{}",
        found.sentence
    );
    let damping = &found.parameters["guide_viscous"]["damping_n_m_s_per_rad"];
    let [low, high] = [damping.low, damping.high];
    assert!(
        0.0 < low && (low..high).contains(&LIGHTLY_DAMPED[1]),
        "{damping:?}"
    );
}

/// The noise that a model to start from has is a guess by the largest load, which a gap makes no larger.
#[test]
fn a_gap_of_a_swing_is_no_acceleration() {
    let noise = |skipped: std::ops::Range<usize>| {
        let whole = swing(PENDULUM, 0.0, 1.3, 1);
        let rows = whole.lines().enumerate();
        let rows = rows.filter(|(n, _)| !skipped.contains(n));
        let text = rows.map(|(_, row)| format!("{row}\n")).collect();
        let files = [("a.csv", text), ("b.csv", swing(PENDULUM, 0.0, -0.9, 2))];
        let logs = imported("free_swing_gap", MAPPING, &files).unwrap();
        started(&logs).noise.torque_n_m
    };
    let [whole, with_gap] = [noise(0..0), noise(300..354)];
    assert!((with_gap / whole - 1.0).abs() < 0.1, "{whole} {with_gap}");
}

#[test]
fn what_swings_freely_has_no_force() {
    let mapping = format!("{MAPPING}\n    wrench = {{ tx = \"angle\" }}");
    let files = [
        ("a.csv", swing(PENDULUM, 0.0, 1.3, 1)),
        ("b.csv", swing(PENDULUM, 0.0, -0.9, 2)),
    ];
    let refused = imported("free_swing_driven", &mapping, &files).unwrap_err();
    assert!(refused.contains("expected no [wrench]"), "{refused}");
}
