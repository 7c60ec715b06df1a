//! The scores: every definition with a case that counts and one that does not.

use std::collections::BTreeMap;

use softdock_hidden_effects::score::{
    Answer, Rate, Scores, error_drop_percent, parse_answers, score,
};
use softdock_hidden_effects::{Level, NoiseRange, Truth, Verdict, parse_truth, suite, truth_json};

fn truth(level: Level, effects: &[&str], expected: Verdict) -> Truth {
    Truth {
        effects: effects.iter().map(|e| (*e).to_owned()).collect(),
        parameters: BTreeMap::new(),
        expected,
        level,
        size: 1.0,
        noise: NoiseRange::Usual,
        z_oracle_test: [1.0, 1.0, 0.0, 1.0],
        z_nominal_test: [1.0, 3.0, 0.0, 1.0],
    }
}

fn answer(verdict: Verdict, effects: &[&str], b: f64) -> Answer {
    Answer {
        verdict,
        effects: effects.iter().map(|e| (*e).to_owned()).collect(),
        test_rms: [1.0, b, 0.0, 1.0],
        seconds: 0.5,
    }
}

fn rate(right: usize, of: usize) -> Rate {
    Rate { right, of }
}

#[test]
fn rank_of_a_single_effect_counts() {
    let single = truth(Level::Single, &["guide_coulomb"], Verdict::Named);
    let mut scores = Scores::default();
    let lists: [&[&str]; 4] = [
        &["guide_coulomb"],
        &["guide_viscous", "contact_cubic", "guide_coulomb"],
        &["a", "b", "c", "guide_coulomb"],
        &[],
    ];
    for list in lists {
        scores.add(&single, Some(&answer(Verdict::Named, list, 1.0)));
    }
    // The right id with the wrong verdict, and no answer at all.
    scores.add(
        &single,
        Some(&answer(Verdict::Unexplained, &["guide_coulomb"], 1.0)),
    );
    scores.add(&single, None);
    assert_eq!(scores.single_top1, rate(1, 6));
    assert_eq!(scores.single_top3, rate(2, 6));
    assert_eq!(scores.rank_all_correct, rate(1, 6));
}

#[test]
fn pair_counts_in_any_order_and_with_nothing_extra() {
    let pair = truth(
        Level::Compound,
        &["ft_scale", "cable_stiffness"],
        Verdict::Named,
    );
    let mut scores = Scores::default();
    let lists: [&[&str]; 4] = [
        &["cable_stiffness", "ft_scale"],
        &["cable_stiffness", "ft_scale", "guide_coulomb"],
        &["cable_stiffness", "guide_coulomb", "ft_scale"],
        &["guide_coulomb", "guide_viscous"],
    ];
    for list in lists {
        scores.add(&pair, Some(&answer(Verdict::Named, list, 1.0)));
    }
    assert_eq!(scores.compound_exact, rate(2, 4));
    assert_eq!(scores.compound_any, rate(3, 4));
    assert_eq!(scores.rank_all_correct, rate(1, 4));
}

#[test]
fn harder_cases_have_scores_of_their_own() {
    let ids = ["ft_scale", "cable_stiffness", "guide_coulomb"];
    let mut scores = Scores::default();
    let triple = truth(Level::Triple, &ids, Verdict::Named);
    for said in [&ids[..], &ids[..2]] {
        scores.add(&triple, Some(&answer(Verdict::Named, said, 1.0)));
    }
    let small = truth(Level::Small, &ids[..1], Verdict::Named);
    scores.add(&small, Some(&answer(Verdict::Named, &ids[..1], 1.0)));
    scores.add(&small, Some(&answer(Verdict::NothingMissing, &[], 1.0)));
    let one_log = truth(Level::OneLog, &ids[..1], Verdict::LogsDisagree);
    scores.add(&one_log, Some(&answer(Verdict::LogsDisagree, &[], 1.0)));
    scores.add(&one_log, Some(&answer(Verdict::Named, &ids[..1], 1.0)));
    let expected = [rate(1, 2); 3];
    let found = [scores.triple_exact, scores.small_top1, scores.logs_disagree];
    assert_eq!(found, expected);
    assert_eq!(scores.single_top1, rate(0, 0));
    assert_eq!(scores.rank_all_correct, rate(3, 6));
}

#[test]
fn silence_counts_where_nothing_is_missing_and_honesty_outside() {
    let null = truth(Level::Null, &[], Verdict::NothingMissing);
    let outside = truth(Level::Outside, &["OOL_x"], Verdict::Unexplained);
    let mut scores = Scores::default();
    for verdict in [
        Verdict::NothingMissing,
        Verdict::Unexplained,
        Verdict::Named,
    ] {
        scores.add(&null, Some(&answer(verdict, &[], 1.0)));
        scores.add(&outside, Some(&answer(verdict, &[], 1.0)));
    }
    assert_eq!(scores.null_clean, rate(1, 3));
    assert_eq!(scores.outside_unexplained, rate(1, 3));
    assert_eq!(scores.rank_all_correct, rate(2, 6));
    assert!(
        scores.error_drop_percent.is_empty(),
        "drop counts for named effects only"
    );
}

#[test]
fn drop_is_measured_against_the_oracle() {
    let single = truth(Level::Single, &["guide_coulomb"], Verdict::Named);
    let drop = |b: f64| error_drop_percent(&single, &answer(Verdict::Named, &[], b));
    let close = |found: Option<f64>, expected: f64| {
        assert!(
            (found.expect("counts") - expected).abs() < 1e-9,
            "{found:?} {expected}"
        );
    };
    close(drop(1.0), 100.0);
    close(drop(3.0), 0.0);
    close(drop(f64::NAN), 0.0);
    // E = sqrt(2 + b²): sqrt(11) nominal, sqrt(3) oracle, sqrt(6) here.
    close(
        drop(2.0),
        100.0 * (11.0_f64.sqrt() - 6.0_f64.sqrt()) / (11.0_f64.sqrt() - 3.0_f64.sqrt()),
    );
    let mut hidden = single.clone();
    hidden.z_nominal_test[1] = 1.01;
    assert_eq!(
        error_drop_percent(&hidden, &answer(Verdict::Named, &[], 1.0)),
        None
    );
}

#[test]
fn summary_of_drops_and_times() {
    let single = truth(Level::Single, &["guide_coulomb"], Verdict::Named);
    let mut scores = Scores::default();
    for (b, seconds) in [(1.0, 0.3), (3.0, 0.1), (1.1, 0.2)] {
        let mut said = answer(Verdict::Named, &["guide_coulomb"], b);
        said.seconds = seconds;
        scores.add(&single, Some(&said));
    }
    assert_eq!(scores.min_drop_percent(), Some(0.0));
    assert!(
        scores
            .median_drop_percent()
            .is_some_and(|d| d > 90.0 && d < 100.0)
    );
    assert_eq!(scores.drop_of_90_percent(), rate(2, 3));
    let seconds = [0.5, 0.75, 1.0].map(|share| scores.seconds_of(share));
    let close = |s: Option<f64>, to: f64| s.is_some_and(|s| (s - to).abs() < 1e-12);
    assert!(close(seconds[0], 0.2) && close(seconds[1], 0.25) && close(seconds[2], 0.3));
    assert_eq!(Scores::default().median_drop_percent(), None);
}

#[test]
fn truth_of_other_sets_and_answers_are_read() {
    let truths = parse_truth(
        r#"{"d01": {"effects": ["ft_crosstalk"], "level": "medium", "expected": "named",
            "params": {"ft_crosstalk": {"C": [[1.0, 0.5], [0.25, 1.0]], "note": "text"}},
            "train": {"z_nominal": {}},
            "test": {"z_nominal": {"A": 1.0, "B": 3.0, "C": 0.0, "K": 1.0},
                     "z_oracle": {"A": 1.0, "B": 1.0, "C": 0.0, "K": 1.0}}}}"#,
    )
    .expect("the format of the development set");
    assert_eq!(truths["d01"].level, Level::Single);
    assert_eq!(truths["d01"].parameters["ft_crosstalk"]["C_1_0"], 0.25);
    let answers = parse_answers(
        r#"{"d01": {"verdict": "named", "effects": ["ft_crosstalk"],
            "test_rms": {"A": 1.0, "B": 1.0, "C": 0.0, "K": 1.0}, "seconds": 1.2}}"#,
    )
    .expect("the format of the answers");
    let scores = score(&truths, &answers);
    assert_eq!(scores.single_top1, rate(1, 1));
    assert!((scores.error_drop_percent[0] - 100.0).abs() < 1e-9);
    assert!(parse_truth("{\"d01\": {}}").is_err());
}

#[test]
fn own_truth_survives_the_file() {
    let case = suite(1)[0].generate();
    let text = truth_json([(case.name.as_str(), &case.truth)]);
    let read = &parse_truth(&text).expect("own text")[&case.name];
    assert_eq!(read.effects, case.truth.effects);
    assert_eq!(
        (read.level, read.expected),
        (case.truth.level, case.truth.expected)
    );
    // Reading a number may change its last bit.
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
    assert!(close(read.size, case.truth.size));
    let z = |t: &Truth| [t.z_nominal_test, t.z_oracle_test].concat();
    assert!(
        z(read)
            .iter()
            .zip(z(&case.truth))
            .all(|(a, b)| close(*a, b))
    );
    for (id, parameters) in &case.truth.parameters {
        for (name, value) in parameters {
            assert!(close(read.parameters[id][name], *value), "{id} {name}");
        }
    }
}
