//! The regime that `softdock compare` names for recorded errors whose cause is known.
//!
//! The data is not part of the project: `SOFTDOCK_DATA` names the folder that holds it.

use softdock_analysis::compare::{Comparison, NoiseVerdict, Quantity, compare};
use softdock_analysis::import::docking_rig_log;
use softdock_physics::model::{Axis, Channel};
use softdock_tests::process::recorded_data;

/// Comparisons of both logs of a case.
fn both_logs(case: &str) -> Option<[Comparison; 2]> {
    let folder = recorded_data("hidden-effects-dev")?.join(case);
    let logs = docking_rig_log::read(&folder).unwrap();
    Some([
        compare(&logs.model, &logs.train).unwrap(),
        compare(&logs.model, &logs.test).unwrap(),
    ])
}

#[test]
fn clean_logs_have_no_structure() {
    for case in ["d03", "d04", "d06"] {
        let Some(logs) = both_logs(case) else { return };
        for comparison in logs {
            assert!(comparison.at_noise, "{case}: {}", comparison.sentence);
            assert!(comparison.sentence.contains("every error is at the noise"));
            assert!(comparison.regimes.is_empty(), "{case}");
            assert!(
                comparison.notes.is_empty(),
                "{case}: {:?}",
                comparison.notes
            );
            for test in &comparison.tests {
                assert!(test.whiteness.white, "{case}: {test:?}");
                assert!(
                    test.independence.iter().all(|i| i.independent),
                    "{case}: {test:?}"
                );
            }
            for level in &comparison.noise {
                assert_eq!(
                    level.verdict,
                    NoiseVerdict::AsDataSheet,
                    "{case}: {level:?}"
                );
            }
        }
    }
}

/// What explains the error of an axis: the quantity, its axis, and whether it does so in contact.
type Expected = (Channel, Axis, Quantity, Option<Axis>, bool);

/// Errors and their regimes, per case.
const EXPECTED: [(&str, Expected); 11] = {
    use Axis::{Rz, X, Y};
    use Channel::{ExecutedVelocity, ModelVelocity, Wrench};
    use Quantity::{Acceleration, Force, Frequency, Position, TimeInRun, Velocity};
    [
        // Cross-talk, resistance of the manipulator, delay, cable, friction, contact damping.
        ("d01", (Wrench, Y, Force, Some(X), false)),
        ("d05", (ModelVelocity, X, Velocity, Some(X), false)),
        ("d07", (ExecutedVelocity, X, Acceleration, Some(X), false)),
        ("d10", (Wrench, Rz, Position, Some(Y), false)),
        ("d12", (Wrench, X, Velocity, Some(X), false)),
        ("d13", (Wrench, X, Velocity, Some(X), false)),
        ("d14", (Wrench, X, Velocity, Some(X), true)),
        // Drift, resonance, damping that grows with the penetration, rate limit.
        ("d17", (Wrench, X, TimeInRun, None, false)),
        ("d20", (ExecutedVelocity, X, Frequency, None, false)),
        ("d21", (Wrench, X, Velocity, Some(X), true)),
        ("d24", (ExecutedVelocity, X, Acceleration, Some(X), false)),
    ]
};

#[test]
fn the_regime_is_the_one_of_the_cause() {
    for (case, (channel, axis, quantity, along, in_contact)) in EXPECTED {
        let Some(logs) = both_logs(case) else { return };
        for (comparison, log) in logs.iter().zip(["train", "test"]) {
            let mut failures = comparison.failures.iter();
            let failure = failures.find(|f| f.channel == channel && f.axis == axis);
            // A small error can stay below the noise in one of the two logs.
            let Some(failure) = failure else {
                assert_eq!((case, log), ("d13", "test"), "{}", comparison.sentence);
                continue;
            };
            let regime = failure.regime.as_ref();
            let found = regime.map(|r| (r.variable, r.along, r.in_contact));
            assert_eq!(
                found,
                Some((quantity, along, in_contact)),
                "{case} {log}: {}",
                comparison.sentence
            );
        }
    }
}

#[test]
fn sizes_are_said_as_an_engineer_would_write_them() {
    let Some([train, _]) = both_logs("d20") else {
        return;
    };
    assert!(
        train.sentence.contains("swings at 14."),
        "{}",
        train.sentence
    );
    let Some([train, _]) = both_logs("d12") else {
        return;
    };
    assert!(
        train.sentence.contains("while moving in -x"),
        "{}",
        train.sentence
    );
    assert!(
        train.sentence.contains("larger below"),
        "{}",
        train.sentence
    );
    let Some([train, _]) = both_logs("d16") else {
        return;
    };
    assert!(
        train.sentence.contains("the velocity along x is between -"),
        "{}",
        train.sentence
    );
    // A mass error while the tool hardly turns is an offset, not an orientation.
    let Some([train, _]) = both_logs("d15") else {
        return;
    };
    assert!(
        train.sentence.contains("the torque is shifted by 0.169"),
        "{}",
        train.sentence
    );
    let Some([train, _]) = both_logs("d19") else {
        return;
    };
    assert!(
        train.sentence.contains("in steps of 3.10 N"),
        "{}",
        train.sentence
    );
}
