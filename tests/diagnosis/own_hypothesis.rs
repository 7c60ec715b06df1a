//! An effect that the catalogue does not have, as a formula in the model file.

use softdock_analysis::diagnose::{Verdict, diagnose};
use softdock_analysis::import::docking_rig_log;
use softdock_hidden_effects::suite;
use softdock_physics::model::Model;

/// A ripple along the guide, as a user would write it.
const RIPPLE: &str = r#"
[[hypothesis]]
id = "ripple"
title = "Ripple of the guide"
acts_on = "guide"
formula = "sine_n * sin(2*PI*position/pitch_m) + cosine_n * cos(2*PI*position/pitch_m)"
[hypothesis.parameters]
sine_n = { unit = "N", low = -20, high = 20 }
cosine_n = { unit = "N", low = -20, high = 20 }
pitch_m = { unit = "m", low = 0.002, high = 0.02 }
"#;

/// The judge's ripple is outside of the catalogue: unexplained, until the user has an idea.
#[test]
fn a_formula_is_named_fitted_and_leaves_nothing_behind() {
    let spec = suite(3)
        .into_iter()
        .find(|spec| spec.effects() == ["OOL_force_ripple"])
        .unwrap();
    let case = spec.generate();
    let logs =
        docking_rig_log::from_text(&case.meta_json, &case.train_csv, &case.test_csv).unwrap();
    let judged = |model: &Model| {
        diagnose(model, &[&logs.train], &[&logs.test], &|_, _| {})
            .unwrap()
            .diagnosis
    };
    assert_eq!(judged(&logs.model).verdict, Verdict::Unexplained);

    let written: Model = toml_edit::de::from_str(RIPPLE).unwrap();
    let mut model = logs.model.clone();
    model.hypotheses = written.hypotheses;
    let found = judged(&model);
    assert_eq!(
        (found.verdict, found.effects.as_slice()),
        (Verdict::Named, &["ripple".to_owned()][..])
    );
    let pitch = &found.parameters["ripple"]["pitch_m"];
    let expected = case.truth.parameters["OOL_force_ripple"]["pitch_m"];
    assert!(
        pitch.low < expected && expected < pitch.high,
        "{expected}: {pitch:?}"
    );
    // What the judge's own plant leaves with the truth.
    let (left, oracle) = (
        found.residual_rms_sigma.after.wrench,
        case.truth.z_oracle_test[1],
    );
    assert!(left < 1.02 * oracle, "{left} {oracle}");
}

#[test]
fn a_mistake_is_named_with_its_place() {
    let refused = |from: &str, to: &str| {
        let model: Model = toml_edit::de::from_str(&RIPPLE.replace(from, to)).unwrap();
        model.validate().unwrap_err().to_string()
    };
    let said = refused("* sin(2*PI*position", "* sin(2*PI*postion");
    assert!(
        said.contains("`ripple`: `formula`: `postion` at character"),
        "{said}"
    );
    assert!(said.contains("did you mean `position`?"), "{said}");
    let said = refused("pitch_m = { unit = \"m\"", "pitch_m = { unit = \"s\"");
    assert!(said.contains("does not give N"), "{said}");
    let said = refused("id = \"ripple\"", "id = \"guide_coulomb\"");
    assert!(
        said.contains("the catalogue has an effect of this name"),
        "{said}"
    );
    let said = refused("acts_on = \"guide\"", "acts_on = \"gide\"");
    assert!(said.contains("expected guide, contact, wall, fx"), "{said}");
    let said = refused("low = 0.002", "low = 0.2");
    assert!(said.contains("expected low < high"), "{said}");
}
