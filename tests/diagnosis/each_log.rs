//! What differs from log to log, and what only all of them together show.

use super::joint::{FRICTION, MODEL, diagnosed, gear, log};
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_tests::one_axis::OneAxis;

/// A joint that turns at one speed in each log, beside a ripple: within a log friction is a constant, and only all together show
/// what it is.
#[test]
fn logs_at_constant_speeds_are_explained_together() {
    let noise = |text: &str| text.replace("torque_n_m = 0.05", "torque_n_m = 0.02");
    let model = Model::from_toml(&noise(MODEL), "model.toml").unwrap();
    let at = |speed: f64, seed: u64| -> Recording {
        const SLOWLY: f64 = 1e-4;
        let rig = OneAxis {
            cycle_s: 0.01,
            turns: true,
            swings: [(speed / SLOWLY, SLOWLY), (0.0, 0.0), (0.0, 0.0)],
            noise: (1e-7, 0.02),
            late_s: 0.0,
        };
        let ripple = |q: f64| 0.04 * (40.0 * q).sin();
        rig.record(4.0, 0.0, seed, |[q, v, _]| {
            FRICTION.0 * v.signum() + FRICTION.1 * v + ripple(q)
        })
    };
    let train: Vec<Recording> = (0..)
        .zip([0.1, 0.5, 0.9, 1.5])
        .map(|(n, v)| at(v, n))
        .collect();
    let test: Vec<Recording> = (10..).zip([0.3, 0.7, 1.3]).map(|(n, v)| at(v, n)).collect();
    let (train, test): (Vec<&Recording>, Vec<&Recording>) =
        (train.iter().collect(), test.iter().collect());
    let found = diagnose(&model, &train, &test, &|_, _| {})
        .unwrap()
        .diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let viscous = &found.parameters["guide_viscous"]["damping_n_m_s_per_rad"];
    assert!(
        (viscous.low..viscous.high).contains(&FRICTION.1),
        "{viscous:?}"
    );
    // All turn one way.
    let dry = ["guide_coulomb", "guide_offset"];
    assert!(
        found.effects.iter().any(|id| dry.contains(&id.as_str())),
        "{}",
        found.sentence
    );
}

/// A brake that was on in one log, beside a gear that no law describes and that each log alone leaves, too.
#[test]
fn a_brake_in_one_log_is_a_disagreement_beside_what_no_law_describes() {
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let ripple = |q: f64, v: f64| 0.8 * gear(q, v);
    let brake = |q: f64, v: f64| ripple(q, v) + 2.5 * FRICTION.1 * v;
    let (free, braked) = (log(8.0, 0.0, 3, ripple), log(6.0, 1.0, 5, brake));
    let test = log(8.0, 2.0, 4, ripple);
    let found = diagnose(&model, &[&free, &braked], &[&test], &|_, _| {});
    let found = found.unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::LogsDisagree, "{}", found.sentence);
    let viscous = found.disagreeing.iter().any(|id| id == "guide_viscous");
    assert!(viscous, "{}", found.sentence);
}

/// A constant of 20 N·m, of 21 in the unseen log: too little for logs that disagree, and nearly all of what is left.
#[test]
fn a_constant_that_differs_a_little_is_said_to() {
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let train = log(12.0, 0.0, 3, |_, _| 20.0);
    let (same, other) = (log(8.0, 2.0, 4, |_, _| 20.0), log(8.0, 2.0, 4, |_, _| 21.0));
    let said = |test: &Recording| {
        let found = diagnosed(&model, &train, test);
        assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
        let mut notes = found.notes.into_iter();
        notes.find(|note| note.contains("differed from log to log"))
    };
    assert_eq!(said(&same), None);
    let note = said(&other).expect("a note");
    let expected = "guide_offset differed from log to log: with torque_n_m = -21";
    assert!(note.contains(expected), "{note}");
}

/// The zero of a torque sensor that is set anew before each log: no log has a drift, and what all have in common of it is next to
/// nothing.
#[test]
fn logs_with_zeros_of_their_own_disagree_about_the_zero() {
    let text = MODEL.replace("commanded", "measured");
    let model = Model::from_toml(&text, "model.toml").unwrap();
    let with = |seed: u64, zero: f64| log(10.0, 0.5 * seed as f64, seed, move |_, _| zero);
    for [first, second, third] in [[-0.5, -4.4, 5.1], [3.0, 5.5, 9.0]] {
        let (train, second, third) = (with(3, first), with(4, second), with(5, third));
        let found = diagnose(&model, &[&train], &[&second, &third], &|_, _| {})
            .unwrap()
            .diagnosis;
        assert_eq!(found.verdict, Verdict::LogsDisagree, "{}", found.sentence);
        assert_eq!(found.disagreeing.len(), 1, "{}", found.sentence);
        let zeros = ["guide_offset", "ft_bias"];
        assert!(
            zeros.contains(&found.disagreeing[0].as_str()),
            "{}",
            found.sentence
        );
    }
}
