//! The report of a diagnosis as text: which sections each verdict has, in which order, and what
//! bad input does to it.

use softdock::pages::diagnosis::{Identity, page};
use softdock_tests::synthetic::{self, SyntheticDiagnosis};

fn html(synthetic: &SyntheticDiagnosis) -> String {
    let SyntheticDiagnosis {
        diagnosis,
        before,
        after,
        identity,
    } = synthetic;
    page(diagnosis, before, after, identity).unwrap().to_html()
}

/// Titles of the sections, in order.
fn sections(html: &str) -> Vec<&str> {
    let titles = html.split("<h2>").skip(1);
    titles
        .map(|rest| rest.split("</h2>").next().unwrap())
        .collect()
}

fn assert_contains(html: &str, texts: &[&str]) {
    for text in texts {
        assert!(html.contains(text), "`{text}` is missing");
    }
}

#[test]
fn named_effects_come_with_all_their_evidence() {
    let html = html(&synthetic::named());
    assert_eq!(
        sections(&html),
        [
            "How the error falls",
            "Where the error is largest: executed velocity x",
            "Hypotheses",
            "Parameters",
            "The runner-up, and how to be sure",
            "Where the error showed",
            "What it looks like",
            "Noise floor",
            "Notes",
            "Data and settings",
        ]
    );
    assert_contains(
        &html,
        &[
            ">Named</strong> The robot is 32.1 ms late",
            "✓ -90 %",
            "with the effects",
            "the lag of the best fit is negative",
            "0.03211",
            "[0.03190, 0.03230]",
            "Repeat the test with 2 mm/s",
            "--speed-mm-s 2",
            "softdock add &#39;rig 2/model.toml&#39; --fit",
            "Model with 2 effects added",
            "softdock 0.1.0 (4aa91bc) on nucleo-h743zi",
        ],
    );
    let parameters = html.split("<h2>Parameters</h2>").nth(1).unwrap();
    assert!(
        parameters.find("transport_delay") < parameters.find("reversal_pause"),
        "the most important effect comes first"
    );
}

#[test]
fn nothing_missing_has_no_sections_about_effects() {
    let html = html(&synthetic::nothing_missing());
    assert_eq!(
        sections(&html).first().copied(),
        Some("How large the error is")
    );
    assert_eq!(
        sections(&html)[2..],
        ["Noise floor", "Data and settings"],
        "besides the plot of the largest error"
    );
    assert_contains(&html, &[">Nothing missing</strong>", "held back"]);
    for absent in [
        "with the effects",
        "To take it into the model",
        "Settings of the board",
        "Recorded by",
        "Before [",
    ] {
        assert!(!html.contains(absent), "`{absent}` has no place here");
    }
}

#[test]
fn an_error_without_a_name_is_shown_where_it_is() {
    let html = html(&synthetic::unexplained());
    assert_eq!(
        sections(&html),
        [
            "How large the error is",
            "Where the error is largest: wrench ry",
            "Hypotheses",
            "Where the unexplained error shows",
            "What it looks like",
            "Noise floor",
            "Data and settings",
        ]
    );
    assert_contains(
        &html,
        &[
            ">Unexplained</strong>",
            "it makes unseen data worse",
            "✗ refused",
            "48 % of it follows the force",
            "none good enough for a name",
        ],
    );
    assert!(!html.contains("To take it into"), "there is nothing to add");
}

#[test]
fn a_rest_in_another_axis_gets_its_own_plots() {
    // The effects explain the velocity; what is left unexplained is a torque.
    let mut synthetic = synthetic::unexplained();
    let named = synthetic::named();
    synthetic.diagnosis.effects = vec!["transport_delay".to_owned()];
    synthetic.before.channels[0] = named.before.channels[0].clone();
    // Far larger than the torque.
    for six in synthetic.before.channels[0].predicted.iter_mut().flatten() {
        six[0] += 0.1;
    }
    let html = html(&synthetic);
    let plots: Vec<&str> = sections(&html)
        .into_iter()
        .filter(|s| s.starts_with("Where the error is"))
        .collect();
    assert_eq!(
        plots,
        [
            "Where the error is largest: executed velocity x",
            "Where the error is left: wrench ry"
        ]
    );
}

#[test]
fn predictions_of_different_recordings_are_refused() {
    let mut synthetic = synthetic::named();
    synthetic.after.time_s.pop();
    let error = page(
        &synthetic.diagnosis,
        &synthetic.before,
        &synthetic.after,
        &synthetic.identity,
    )
    .unwrap_err()
    .to_string();
    assert!(
        error.contains("3000 and 2999 cycles") && error.contains("rig 2/test.mcap"),
        "{error}"
    );
}

#[test]
fn numbers_that_are_none_and_hostile_texts_do_no_harm() {
    let mut synthetic = synthetic::named();
    let diagnosis = &mut synthetic.diagnosis;
    diagnosis.sentence = "<script>alert(1)</script>".to_owned();
    diagnosis.seconds = f64::NAN;
    for step in &mut diagnosis.steps {
        step.train_error = f64::NAN;
        step.test_error = Some(f64::INFINITY);
    }
    for ranked in &mut diagnosis.ranked {
        (ranked.gain_train, ranked.gain_test) = (f64::NAN, f64::NEG_INFINITY);
    }
    for estimate in diagnosis
        .parameters
        .values_mut()
        .flat_map(|p| p.values_mut())
    {
        (estimate.value, estimate.low, estimate.high) = (0.0, f64::NEG_INFINITY, f64::NAN);
    }
    for (index, region) in diagnosis.regions.iter_mut().enumerate() {
        (region.from_s, region.to_s) = match index {
            0 => (f64::NAN, f64::NAN),
            1 => (1e300, -1e300),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
    }
    for floor in &mut diagnosis.noise {
        floor.data_sheet = 0.0;
    }
    let html = html(&synthetic);
    assert!(html.contains("n/a") && !html.contains("<script"));
    for prediction in [&mut synthetic.before, &mut synthetic.after] {
        for channel in &mut prediction.channels {
            channel.predicted.clear();
            channel.sigma = [0.0; 6];
        }
    }
    let SyntheticDiagnosis {
        diagnosis,
        before,
        after,
        ..
    } = &synthetic;
    page(diagnosis, before, after, &Identity::default()).unwrap();
}
