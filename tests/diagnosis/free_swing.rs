//! What swings under no force: a pendulum of which nothing but the angle is known.

use super::joint::named;
use super::tables::{imported, started, table};
use softdock_analysis::compare::compare;
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_physics::model::{EffectModel, Model};
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

const SPRING: &str = r#"
    files = { train = "a.csv", test = "b.csv" }
    starter = { wrench = "free", gravity_m_s2 = [0.0, 0.0, 0.0] }
    time = { column = "t" }
    position = { x = "x" }
    executed_velocity = { derive = true }
    filter = { cutoff_hz = 2.0, order = 4, trim_s = 1.0 }
"#;

/// A table of 60 s at 20 Hz of a mass on a spring, by its mass 1/s², that swings about a place, m, from 0.4 mm on; it loses half of
/// that in 21 s.
fn on_a_spring(stiffness: f64, rests_at: f64, seed: u64) -> String {
    const DAMPING: f64 = 0.065;
    let rate = (stiffness - DAMPING * DAMPING / 4.0).sqrt();
    let mut random = RandomStream::new(seed, 0);
    let noise: Vec<f64> = (0..1200).map(|_| 2e-7 * random.normal()).collect();
    table("t,x", noise.len(), |n| {
        let t = 0.05 * n;
        let swing = 4e-4 * (-0.5 * DAMPING * t).exp() * (rate * t).cos();
        format!("{t},{}", rests_at + swing + noise[n as usize])
    })
}

/// A table of 8 s at 100 Hz that begins with this angle, rad, at rest; `off`: how much the encoder is off, rad.
fn swing(pendulum: [f64; 3], off: f64, first: f64, seed: u64) -> String {
    let mut random = RandomStream::new(seed, 0);
    let angles = angles(pendulum, first, 800).into_iter();
    let shown = angles.map(|q| q + off * (2.7 * q).sin() + 1e-5 * random.normal());
    let shown: Vec<f64> = shown.collect();
    table("t,angle", shown.len(), |n| {
        format!("{},{}", 0.01 * n, shown[n as usize])
    })
}

/// Angles of a pendulum at 100 Hz, from the first one at rest, rad.
fn angles([weight, viscous, dry]: [f64; 3], first: f64, rows: usize) -> Vec<f64> {
    const STEPS: usize = 200;
    let step_s = 0.01 / STEPS as f64;
    let [mut angle, mut rate] = [first, 0.0_f64];
    let mut angles = Vec::new();
    for _ in 0..rows {
        angles.push(angle);
        for _ in 0..STEPS {
            let acceleration = -weight * angle.sin() - viscous * rate - dry * (rate / 1e-3).tanh();
            rate += step_s * acceleration;
            angle += step_s * rate;
        }
    }
    angles
}

/// A coarse encoder hides a small dry friction at each instant, but the swing ends sooner for it: it is named with its amount, and
/// nowhere else.
#[test]
fn a_friction_below_the_noise_of_an_instant_is_found_by_the_swing() {
    const STEP: f64 = 5e-3;
    let filter = "filter = { cutoff_hz = 2.2, order = 4, decimate = 7, trim_s = 0.5 }";
    let (before, _) = MAPPING.split_once("filter").unwrap();
    for (viscous, dry) in [(0.02, 0.045), (0.05, 0.0)] {
        let by_encoder = |first: f64| {
            let angles = angles([37.2, viscous, dry], first, 10_000);
            table("t,angle", angles.len(), |n| {
                let steps = (angles[n as usize] / STEP).round();
                format!("{},{}", 0.01 * n, STEP * steps)
            })
        };
        let files = [("a.csv", by_encoder(1.6)), ("b.csv", by_encoder(1.45))];
        let logs = imported("coarse_swing", &format!("{before}{filter}"), &files).unwrap();
        let (train, test) = (&logs.train[0], &logs.test[0]);
        let found = diagnose(&started(&logs), &[train], &[test], &|_, _| {}).unwrap();
        let found = found.diagnosis;
        let mut expected = vec!["bearing_gravity", "guide_viscous"];
        if dry > 0.0 {
            expected.insert(1, "guide_coulomb");
        }
        assert_eq!(named(&found), expected, "{}", found.sentence);
        let of = |id: &str, amount: &str| found.parameters.get(id).map(|all| all[amount].clone());
        let damping = of("guide_viscous", "damping_n_m_s_per_rad").unwrap();
        assert!(
            (damping.low..damping.high).contains(&viscous),
            "{damping:?}"
        );
        if let Some(friction) = of("guide_coulomb", "torque_n_m") {
            assert!((friction.low..friction.high).contains(&dry), "{friction:?}");
            let says = "guide_coulomb was found by the swing of the unseen data";
            assert!(found.notes.iter().any(|note| note.starts_with(says)));
        }
    }
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
    // The encoder's error, of which no interval knows, moves it by a twentieth.
    let off = (damping.value - LIGHTLY_DAMPED[1]).abs();
    assert!(
        0.0 < damping.low && off < 0.1 * LIGHTLY_DAMPED[1],
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

/// A dry friction that builds up over half a millimetre, as one may, would be a spring to a swing that is no longer.
#[test]
fn a_short_swing_has_its_spring() {
    let files = [
        ("a.csv", on_a_spring(4.9, 0.0088, 1)),
        ("b.csv", on_a_spring(4.9, 0.0088, 2)),
    ];
    let logs = imported("short_swing", SPRING, &files).unwrap();
    let model = started(&logs);
    let found = diagnose(&model, &[&logs.train[0]], &[&logs.test[0]], &|_, _| {}).unwrap();
    let found = found.diagnosis;
    assert!(
        found.effects.contains(&"cable_stiffness".to_owned()),
        "{}",
        found.sentence
    );
    let stiffness = &found.parameters["cable_stiffness"]["stiffness_n_per_m"];
    assert!((stiffness.value / 4.9 - 1.0).abs() < 0.03, "{stiffness:?}");
}

/// Two springs, each of which rests elsewhere: what is common to both logs is neither.
#[test]
fn logs_of_two_springs_disagree_about_the_spring() {
    let files = [
        ("a.csv", on_a_spring(4.9, 0.0088, 1)),
        ("b.csv", on_a_spring(9.8, 0.0021, 2)),
    ];
    let logs = imported("two_springs", SPRING, &files).unwrap();
    let model = started(&logs);
    let found = diagnose(&model, &[&logs.train[0]], &[&logs.test[0]], &|_, _| {}).unwrap();
    let found = found.diagnosis;
    assert_eq!(found.verdict, Verdict::LogsDisagree, "{}", found.sentence);
    assert!(
        found.sentence.contains("Restoring spring"),
        "{}",
        found.sentence
    );
    let amounts = found
        .notes
        .iter()
        .find(|note| note.contains("each log alone"));
    let amounts = amounts.expect("the amounts of each log");
    assert!(
        amounts.contains("the fit 4.9") && amounts.contains("--test 9."),
        "{amounts}"
    );
}

/// An empty model of a slow swing: in an instant its force is less than what the noise of the position makes.
#[test]
fn what_is_at_the_noise_of_an_instant_may_foretell_no_motion() {
    let files = [
        ("a.csv", on_a_spring(4.9, 0.0, 1)),
        ("b.csv", on_a_spring(4.9, 0.0, 2)),
    ];
    let logs = imported("slow_swing", SPRING, &files).unwrap();
    let mut model = started(&logs);
    model.noise.position_m = 1e-3;
    let said = |model: &Model| compare(model, &logs.test[0]).unwrap().sentence;
    let at_each_instant = "Instant by instant every error is at the noise";
    assert!(
        said(&model).starts_with(at_each_instant),
        "{}",
        said(&model)
    );
    // With half of the damping the swing is off by less than itself, and with all of it at the noise.
    for (damping, agrees) in [(0.0325, false), (0.065, true)] {
        model.effects = vec![
            effect("cable_stiffness", "stiffness_n_per_m", 4.9),
            effect("guide_viscous", "damping_n_s_per_m", damping),
        ];
        let said = said(&model);
        let begins = if agrees {
            "The model agrees"
        } else {
            at_each_instant
        };
        assert!(said.starts_with(begins), "{damping}: {said}");
    }
}

/// An effect with one amount.
fn effect(id: &str, amount: &str, value: f64) -> EffectModel {
    EffectModel {
        id: id.to_owned(),
        parameters: [(amount.to_owned(), value)].into(),
        ..EffectModel::default()
    }
}
