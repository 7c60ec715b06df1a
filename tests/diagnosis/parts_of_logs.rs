//! A right model is right for any part of a log, for a log at rest or under one load, and whatever the law lets the spacecraft feel.

use super::joint::{JOINT, MODEL};
use super::tables::{imported, table};
use softdock_analysis::compare::{Failure, compare};
use softdock_analysis::diagnose::{Verdict, diagnose, fit_effects};
use softdock_analysis::levels::ChannelLevels;
use softdock_control::delay::LawName;
use softdock_experiments::diagnosis::{Part, model, scenario};
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::predict;
use softdock_physics::model::{Channel, Model};
use softdock_tests::process::scratch;

fn without_secrets(seed: u64) -> Scenario {
    scenario(Part::Train, &[], seed).unwrap()
}

fn recorded(scenario: &Scenario) -> Recording {
    record(scenario).unwrap().0
}

#[test]
fn a_log_that_begins_in_motion_is_compared_as_any_other() {
    let whole = recorded(&without_secrets(5));
    for first in [617, 900, 1500, 1803] {
        let part = Recording {
            header: whole.header.clone(),
            cycles: whole.cycles[first..].to_vec(),
            ..Recording::default()
        };
        let compared = compare(&model().unwrap(), &part).unwrap();
        assert!(
            compared.at_noise,
            "from cycle {first}: {}",
            compared.sentence
        );
    }
}

/// Without a second log its end is held back, which begins in motion.
#[test]
fn the_end_of_a_log_is_judged_as_a_second_one() {
    let log = recorded(&without_secrets(11));
    let found = diagnose(&model().unwrap(), &[&log], &[], &|_, _| {})
        .unwrap()
        .diagnosis;
    assert_eq!(found.verdict, Verdict::NothingMissing, "{}", found.sentence);
    let left = found.residual_rms_sigma.after.rms();
    assert!((left - 1.0).abs() < 0.04, "{left}");
}

/// An axis on a spring that rests where the log began, under a sensor whose zero has drifted since.
const DRIFTS: &str = r#"
[rig]
active_axes = ["x"]
[sensor]
gravity_m_s2 = [0.0, 0.0, 0.0]
[noise]
force_n = 0.02
[[effect]]
id = "cable_stiffness"
parameters = { stiffness_n_per_m = 200.0, about_start = 1 }
[[effect]]
id = "ft_bias_drift"
parameters = { fx_n = 2.0, time_constant_s = 8.0 }
"#;

/// Twenty seconds of its motion, from 10 s before a trigger.
fn drifting() -> String {
    table("t,x,f", 4000, |n| {
        let since = 0.005 * n;
        let x = 0.03 + 0.02 * (2.0 * since).cos();
        let f = -200.0 * (x - 0.05) + 2.0 * (1.0 - (-since / 8.0).exp());
        format!("{},{x},{f}", since - 10.0)
    })
}

#[test]
fn parts_of_a_log_count_from_its_beginning() {
    let model = Model::from_toml(DRIFTS, "the test's model").unwrap();
    let is_explained = |part: &Recording| {
        let prediction = predict(&model, part).unwrap();
        ChannelLevels::of(&[prediction]).wrench < 0.1
    };
    let mapping = "[time]\ncolumn = \"t\"\n[position]\nx = \"x\"\n[executed_velocity]\nderive = true\n\
                   [wrench]\nfx = \"f\"\n[files]\ntrain = \"a.csv\"\n";
    for parts in [
        "[split]\ntrain_share = 0.6\n",
        "[rows.train]\nlast = 2000\n[rows.test]\nfirst = 2501\n",
        "[rows.train]\nto_s = 2\n[rows.test]\nfrom_s = 2.5\n",
    ] {
        let tables = [("a.csv", drifting())];
        let logs = imported("parts_begin", &(mapping.to_owned() + parts), &tables).unwrap();
        let (train, test) = (&logs.train[0], &logs.test[0]);
        assert!(is_explained(train) && is_explained(test), "{parts}");
        let file = scratch("parts_begin_file").join("test.mcap");
        test.write(&file).unwrap();
        assert!(is_explained(&Recording::open(&file).unwrap()), "{parts}");
        let mut whole = test.clone();
        whole.header.began = None;
        assert!(!is_explained(&whole), "{parts}");
    }
    // What is held back for a judgement, and the longest stretch without a gap.
    let tables = [("a.csv", drifting())];
    let log = imported("parts_begin_whole", mapping, &tables).unwrap();
    let mut log = log.train[0].clone();
    log.cycles.drain(1000..1100);
    let compared = diagnose(&model, &[&log], &[], &|_, _| {}).unwrap();
    let left = compared.diagnosis.residual_rms_sigma.after.rms();
    assert!(left < 0.1, "{left}: {}", compared.diagnosis.sentence);
}

#[test]
fn a_log_at_rest_says_nothing() {
    for seed in 1..4 {
        let log = recorded(&Scenario {
            hold: true,
            duration_s: 4.0,
            ..without_secrets(seed)
        });
        let found = diagnose(&model().unwrap(), &[&log], &[], &|_, _| {})
            .unwrap()
            .diagnosis;
        assert_eq!(found.verdict, Verdict::NotTestable, "{}", found.sentence);
        assert!(
            found.effects.is_empty() && found.sentence.contains("stands still"),
            "{}",
            found.sentence
        );
    }
}

/// A constant is predicted best by what is too small. Of the same two runs under two constants it is asked what is missing, and of one what a
/// user knows to be there.
#[test]
fn a_load_that_never_changes_says_nothing() {
    let run = |load: f64, seed: u64| {
        let mut log = JOINT.record(10.0, 0.0, seed, |_| load);
        let cycles = log.cycles.iter_mut();
        cycles.for_each(|c| c.inputs.sensor.wrench[3] = load);
        log
    };
    let model = Model::from_toml(MODEL, "model.toml").unwrap();
    let [one, same, other] = [(-0.2, 1), (-0.2, 2), (0.3, 3)].map(|(load, seed)| run(load, seed));
    let verdict = |test: &Recording| {
        let found = diagnose(&model, &[&one], &[test], &|_, _| {}).unwrap();
        found.diagnosis
    };
    let found = verdict(&same);
    assert_eq!(found.verdict, Verdict::NotTestable, "{}", found.sentence);
    assert!(
        found
            .sentence
            .contains("the load of what moves is the same"),
        "{}",
        found.sentence
    );
    assert_ne!(verdict(&other).verdict, Verdict::NotTestable);
    let asked = ["guide_offset".to_owned()];
    let asked = fit_effects(&model, &asked, &[&one], &[&same], true).unwrap();
    assert_eq!(asked.diagnosis.effects, ["guide_offset"]);
}

/// Laws that let the spacecraft feel more or less than the sensor say so in the recording (`unaccounted_impulse`).
#[test]
fn the_spacecraft_are_predicted_under_every_law() {
    for law in LawName::ALL {
        let log = recorded(&without_secrets(7).with_law(law));
        let compared = compare(&model().unwrap(), &log).unwrap();
        let spacecraft = |failure: &&Failure| failure.channel == Channel::ModelVelocity;
        let wrong = compared.failures.iter().find(spacecraft);
        assert!(wrong.is_none(), "{law:?}: {wrong:?}");
    }
}
