//! The generated logs: reproducible, of the right kind, and with the effect where it belongs.

#![allow(
    clippy::expect_used,
    reason = "a fixture that cannot be built is a failed test"
)]

use std::collections::BTreeSet;

use softdock_hidden_effects::{
    Case, CaseSpec, HEADER, IDS, Level, OUTSIDE_IDS, Verdict, normalised, size_sweep, suite,
};

/// Channels of the z arrays.
const A: usize = 0;
const B: usize = 1;
const C: usize = 2;
const K: usize = 3;

fn specs_of(level: Level) -> Vec<CaseSpec> {
    let all = suite(7).into_iter();
    all.filter(|spec| spec.level() == level).collect()
}

/// First single-effect case of an id.
fn single(id: &str) -> Case {
    let spec = specs_of(Level::Single)
        .into_iter()
        .find(|spec| spec.effects() == [id])
        .expect("every id occurs");
    spec.generate()
}

/// Column of a log.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let index = HEADER.split(',').position(|c| c == name).expect("a column");
    let cell = |line: &str| line.split(',').nth(index).and_then(|c| c.parse().ok());
    csv.lines()
        .skip(1)
        .map(|l| cell(l).expect("a number"))
        .collect()
}

#[test]
fn suite_mixes_all_levels_and_names_every_case_once() {
    let specs = suite(3);
    assert!(specs.len() >= 200, "{}", specs.len());
    let names: BTreeSet<&str> = specs.iter().map(CaseSpec::name).collect();
    assert_eq!(names.len(), specs.len());
    let used: BTreeSet<&str> = specs.iter().flat_map(|s| s.effects().to_vec()).collect();
    assert!(IDS.iter().chain(&OUTSIDE_IDS).all(|id| used.contains(id)));
    let first: BTreeSet<String> = specs
        .iter()
        .take(40)
        .map(|s| format!("{:?}", s.level()))
        .collect();
    assert!(first.len() >= 5, "levels are shuffled: {first:?}");
    assert_eq!(size_sweep(3).len(), 13 * 4);
}

#[test]
fn same_seed_gives_the_same_text_and_another_seed_another() {
    let (one, again, other) = (&suite(5)[0], &suite(5)[0], &suite(6)[0]);
    assert_eq!(one.generate().train_csv, again.generate().train_csv);
    assert_eq!(one.generate().truth, again.generate().truth);
    assert_ne!(one.generate().train_csv, other.generate().train_csv);
}

#[test]
fn text_has_the_columns_and_digits_of_the_format() {
    let case = single("guide_coulomb");
    let mut lines = case.train_csv.lines();
    assert_eq!(lines.next(), Some(HEADER));
    let digits: Vec<usize> = lines
        .next()
        .expect("a row")
        .split(',')
        .map(|cell| cell.split_once('.').map_or(0, |(_, d)| d.len()))
        .collect();
    let mut expected = vec![3, 0, 4, 4, 4, 5, 5, 5];
    expected.extend([7; 15]);
    expected.extend([8; 4]);
    expected.extend([7; 6]);
    assert_eq!(digits, expected);
    let rows = case.train_csv.lines().count() - 1;
    assert!(rows == 2500 || rows == 3750, "{rows}");
    let modes = column(&case.train_csv, "mode");
    assert_eq!(modes.iter().filter(|m| **m == 0.0).count(), 1000);
}

#[test]
fn nulls_leave_noise_only() {
    for spec in specs_of(Level::Null).iter().take(8) {
        let case = spec.generate();
        let z = case.truth.z_nominal_test;
        assert_eq!(z, case.truth.z_oracle_test);
        // The real noise may be 1.3 times the data sheet.
        for channel in [A, K] {
            assert!((0.93..1.4).contains(&z[channel]), "{}: {z:?}", case.name);
        }
        // Differentiated velocity noise times the mass of the tool adds to B, most of all at 2 ms.
        assert!((0.97..2.7).contains(&z[B]), "{}: {z:?}", case.name);
        assert!(z[C] < 0.05, "{}: {z:?}", case.name);
    }
}

#[test]
fn text_alone_gives_the_z_of_the_truth() {
    for spec in suite(9).iter().take(6) {
        let case = spec.generate();
        let z = normalised(&case.meta_json, &case.test_csv).expect("own text");
        let truth = case.truth.z_nominal_test;
        for channel in [A, B, K] {
            assert!(
                (z[channel] - truth[channel]).abs() < 1e-3,
                "{z:?} {truth:?}"
            );
        }
        // The velocity has seven decimals, whose rounding is a floor.
        assert!(z[C] < 0.3 + truth[C], "{z:?} {truth:?}");
    }
}

#[test]
fn broken_text_is_refused_with_its_line() {
    let case = single("guide_viscous");
    let bad = case.test_csv.replacen("0.004,0,", "0.004,zero,", 1);
    let error = normalised(&case.meta_json, &bad).expect_err("not a number");
    assert!(
        error.contains("line 3") && error.contains("zero"),
        "{error}"
    );
    assert!(normalised("{}", &case.test_csv).is_err());
}

#[test]
fn each_effect_raises_its_own_channel() {
    for id in IDS {
        let case = single(id);
        let (with, without) = (case.truth.z_nominal_test, case.truth.z_oracle_test);
        let own = match id {
            "actuation_delay"
            | "actuation_lag"
            | "zero_cross_pause"
            | "rate_limit"
            | "velocity_saturation"
            | "structural_resonance"
            | "clock_jitter" => A,
            "manipulator_resistance" | "sc_mass_error" => C,
            _ => B,
        };
        assert!(
            with[own] > without[own] + 0.005,
            "{id}: {with:?} {without:?}"
        );
        for other in [A, B, C]
            .into_iter()
            .filter(|c| *c != own && id != "clock_jitter")
        {
            let change = (with[other] - without[other]).abs();
            assert!(change < 0.05, "{id}: {with:?} {without:?}");
        }
        assert_eq!(case.truth.expected, Verdict::Named);
        assert_eq!(case.truth.parameters.keys().collect::<Vec<_>>(), [id]);
    }
}

#[test]
fn smaller_steps_of_the_sweep_leave_less() {
    for steps in size_sweep(2).chunks(4) {
        // The steps of the held command excite a fast structural mode.
        if steps[0].effects() == ["structural_resonance"] {
            continue;
        }
        let excess = |spec: &CaseSpec| {
            let truth = spec.generate().truth;
            let power = |z: [f64; 4]| z.iter().map(|v| v * v).sum::<f64>();
            power(truth.z_nominal_test) - power(truth.z_oracle_test)
        };
        let (large, small) = (excess(&steps[0]), excess(&steps[3]));
        assert!(
            large > 10.0 * small.abs() && large > 0.3,
            "{}: {large} {small}",
            steps[0].name()
        );
    }
}

#[test]
fn motion_stays_that_of_a_docking_test() {
    for spec in suite(4).iter().step_by(8) {
        let case = spec.generate();
        for csv in [&case.train_csv, &case.test_csv] {
            let peak = |name| {
                column(csv, name)
                    .iter()
                    .fold(0.0_f64, |m, v| m.max(v.abs()))
            };
            assert!(peak("vex") < 0.25, "{}: {}", case.name, peak("vex"));
            assert!(peak("px") < 0.07, "{}: {}", case.name, peak("px"));
            assert!(peak("fx") < 1500.0, "{}: {}", case.name, peak("fx"));
        }
    }
}

#[test]
fn tolerances_are_declared_where_the_plant_is_off() {
    for (level, declared) in [(Level::Null, false), (Level::NullWithinTolerance, true)] {
        let case = specs_of(level)[0].generate();
        assert_eq!(case.meta_json.contains("\"contact.k_n_N_m\""), declared);
        assert_eq!(case.truth.expected, Verdict::NothingMissing);
    }
}

#[test]
fn effects_outside_the_catalogue_must_not_be_named() {
    for id in OUTSIDE_IDS {
        let specs = specs_of(Level::Outside);
        let spec = specs
            .iter()
            .find(|s| s.effects() == [id])
            .expect("every id occurs");
        let truth = spec.generate().truth;
        assert_eq!(truth.expected, Verdict::Unexplained);
        assert!(
            truth.z_nominal_test[B] > 1.2 * truth.z_oracle_test[B],
            "{id}: {truth:?}"
        );
    }
}

#[test]
fn a_small_effect_leaves_its_share_of_the_noise() {
    for spec in specs_of(Level::Small) {
        let truth = spec.generate().truth;
        let share = |channel: usize| {
            let [z, floor] = [truth.z_nominal_test, truth.z_oracle_test].map(|z| z[channel]);
            (z * z / (floor * floor) - 1.0).max(0.0).sqrt()
        };
        let most = share(A).max(share(B));
        // Noise may add to the residual or cancel a part of it.
        let ratio = most / spec.size();
        assert!(
            (0.5..1.6).contains(&ratio),
            "{:?}: {most} instead of {}",
            spec.effects(),
            spec.size()
        );
    }
}

#[test]
fn an_effect_in_one_log_leaves_the_other_alone() {
    let cases = specs_of(Level::OneLog).into_iter().map(|s| s.generate());
    let mut shown_in_test = 0;
    for case in cases {
        let z = |csv: &str| normalised(&case.meta_json, csv).expect("own text");
        let [train, test] = [z(&case.train_csv), z(&case.test_csv)];
        let differs = [A, B, C]
            .iter()
            .any(|c| (train[*c] / test[*c] - 1.0).abs() > 0.05);
        assert!(differs, "{:?}: {train:?} {test:?}", case.truth.effects);
        assert_eq!(case.truth.expected, Verdict::LogsDisagree);
        shown_in_test += usize::from(case.truth.z_nominal_test != case.truth.z_oracle_test);
    }
    assert!((6..=18).contains(&shown_in_test), "{shown_in_test} of 24");
}
