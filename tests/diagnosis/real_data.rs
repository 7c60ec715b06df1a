//! Diagnoses of public recordings of real machines, with the mappings and models in `examples/`.
//!
//! The recordings are not part of the project: `SOFTDOCK_DATA` names the folder that holds them.

use softdock_analysis::diagnose::{Report, Verdict, diagnose};
use softdock_analysis::import::mapping::import;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::{Prediction, predict};
use softdock_physics::model::{Axis, Channel};
use softdock_tests::process::recorded_data;
use std::path::Path;
use std::sync::LazyLock;

/// Diagnosis of an example, the log that it was fitted on, and the unseen one.
struct Diagnosed {
    report: Report,
    train: Recording,
    test: Option<Recording>,
}

/// The axis, diagnosed once for all tests.
static EMPS: LazyLock<Option<Diagnosed>> = LazyLock::new(|| diagnosed("emps", "emps"));

fn diagnosed(data_name: &str, example: &str) -> Option<Diagnosed> {
    let data = recorded_data(data_name)?;
    let mapping = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mapping = mapping.join(example).join("mapping.toml");
    let mut logs = import(&data, &mapping).unwrap();
    let (model, _) = logs.model.unwrap();
    let quiet = |_: f64, _: &str| {};
    let test: Vec<&Recording> = logs.test.iter().collect();
    let report = diagnose(&model, &[&logs.train[0]], &test, &quiet).unwrap();
    Some(Diagnosed {
        report,
        train: logs.train.remove(0),
        test: logs.test.pop(),
    })
}

/// Root mean square of what a prediction leaves of one reading of the sensor, and of the reading.
fn left_of(prediction: &Prediction, axis: Axis) -> (f64, f64) {
    let wrench = prediction.channel(Channel::Wrench);
    let residuals = (0..prediction.time_s.len()).filter_map(|n| {
        let residual = wrench.residual(n, axis)?;
        Some((residual, wrench.measured[n][axis.index()]))
    });
    let (count, left, all) = residuals.fold((0.0, 0.0, 0.0), |(count, left, all), (r, m)| {
        (count + 1.0, left + r * r, all + m * m)
    });
    assert!(count > 0.0);
    (f64::sqrt(left / count), f64::sqrt(all / count))
}

/// Root mean square of what a prediction leaves of a force, in percent of the force.
fn percent_left(prediction: &Prediction) -> f64 {
    let (left, all) = left_of(prediction, Axis::X);
    100.0 * left / all
}

/// Dry friction, viscous friction that differs by direction, and a delay of the command, together
/// with an offset, leave less than 2.8 % of the force that they were fitted on and 3.4 % of the
/// unseen one (the published model: 4.08 and 5.98 %, with another low-pass). Every term helps on
/// unseen data; a Stribeck curve that would fit best with a friction that grows with the speed is
/// refused. What is left of the training log stands at the reversals.
#[test]
fn the_friction_of_a_real_axis_is_named() {
    let Some(Diagnosed { report, train, .. }) = &*EMPS else {
        return;
    };
    let found = &report.diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    for expected in ["guide_coulomb", "guide_viscous", "guide_asymmetry"] {
        assert!(
            found.effects.iter().any(|e| e == expected),
            "{:?}",
            found.effects
        );
    }
    let errors = (
        percent_left(&predict(&report.after, train).unwrap()),
        percent_left(&report.after_prediction),
    );
    assert!(errors.0 < 2.8 && errors.1 < 3.4, "{errors:?} %");
    for pair in found.steps.windows(2) {
        assert!(pair[1].test_error < pair[0].test_error, "{pair:?}");
    }
    let damping = found.parameters["guide_viscous"]["damping_n_s_per_m"].value;
    assert!((damping / 203.5 - 1.0).abs() < 0.05, "{damping} N·s/m");
    let stribeck = |ids: &[String]| ids == ["guide_stribeck"];
    let refused = found.ranked.iter().find(|r| stribeck(&r.effects)).unwrap();
    let reason = refused.refused.as_ref().unwrap();
    assert!(reason.contains("excess_n = -"), "{reason}");
    let rest = |note: &&String| note.starts_with("What is left on the log of the fit");
    let rest = found.notes.iter().find(rest).unwrap();
    let stands = rest.split_once("stands in ").map(|(_, phases)| phases);
    assert!(
        stands.is_some_and(|phases| phases.contains("zero crossing")),
        "{rest}"
    );
}

/// What was added is not found again, nor anything in its place.
#[test]
#[ignore = "long: a second diagnosis of a real axis"]
fn nothing_is_missing_after_what_was_named_is_in_the_model() {
    let Some(Diagnosed {
        report,
        train,
        test,
    }) = &*EMPS
    else {
        return;
    };
    let test: Vec<&Recording> = test.iter().collect();
    let again = diagnose(&report.after, &[train], &test, &|_, _| {}).unwrap();
    let found = &again.diagnosis;
    assert_eq!(found.verdict, Verdict::NothingMissing, "{}", found.sentence);
}

/// Half a millisecond of delay in a motion below 40 Hz looks like half a millisecond of lag: one of
/// them is named, and the other one is as good.
#[test]
fn the_delay_of_a_real_axis_is_not_told_from_a_lag() {
    let Some(Diagnosed { report, .. }) = &*EMPS else {
        return;
    };
    let found = &report.diagnosis.parameters;
    let delay = found
        .get("actuation_delay")
        .and_then(|p| p.get("extra_delay_s"));
    let lag = found
        .get("actuation_lag")
        .and_then(|p| p.get("extra_lag_s"));
    let late = delay.or(lag).unwrap();
    assert!(late.low < late.value && late.value < late.high, "{late:?}");
    assert!(3e-4 < late.low && late.high < 1.5e-3, "{late:?}");
    let rival = report.diagnosis.runner_up.as_ref().unwrap();
    let mut both = [rival.of.as_str(), rival.effect.as_str()];
    both.sort_unstable();
    assert_eq!(both, ["actuation_delay", "actuation_lag"]);
    assert!(!rival.told_apart, "{rival:?}");
}

/// Weight and zero are what a fit by hand finds: 12.15 N and -3.46, -4.70, -16.68 N, which leave
/// 0.285 N per axis of the poses that were kept back.
#[test]
fn weight_and_zero_of_a_sensor_are_found() {
    let Some(Diagnosed { report, .. }) = diagnosed("ft_gravity_ati", "ati-gravity") else {
        return;
    };
    let found = &report.diagnosis;
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
    let mass_kg = found.parameters["tool_mass_error"]["mass_error_kg"].value;
    assert!((mass_kg * 9.81 - 12.15).abs() < 0.05, "{mass_kg} kg");
    for (name, expected) in [("fx_n", -3.46), ("fy_n", -4.70), ("fz_n", -16.68)] {
        let zero = found.parameters["ft_bias"][name].value;
        assert!((zero - expected).abs() < 0.05, "{name} = {zero} N");
    }
    let forces = [Axis::X, Axis::Y, Axis::Z].map(|a| left_of(&report.after_prediction, a).0);
    let left = (forces.iter().map(|f| f * f).sum::<f64>() / 3.0).sqrt();
    assert!(left <= 0.285, "{left} N");
}
