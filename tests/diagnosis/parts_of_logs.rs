//! A right model is right for any part of a log, for a log at rest, and whatever the law lets the spacecraft feel.

use softdock_analysis::compare::{Failure, compare};
use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_control::delay::LawName;
use softdock_experiments::diagnosis::{Part, model, scenario};
use softdock_experiments::run::record;
use softdock_experiments::scenario::Scenario;
use softdock_io::recording::Recording;
use softdock_physics::model::Channel;

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
