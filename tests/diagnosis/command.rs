//! The commands that find, add, fit and show a missing effect, on whole cases.
//!
//! Recorded data is not part of the project: `SOFTDOCK_DATA` names the folder that holds it.

use serde_json::Value;
use softdock_analysis::import::docking_rig_log;
use softdock_io::recording::Recording;
use softdock_tests::process::{Finished, done, json, recorded_data, scratch, softdock};
use std::fs;
use std::path::{Path, PathBuf};

/// A folder with a generated case that hides these effects, imported.
fn generated(test: &str, effects: &[&str]) -> PathBuf {
    let folder = scratch(test);
    let suite = softdock_hidden_effects::suite(1);
    let spec = suite.iter().find(|spec| spec.effects() == effects);
    let case = spec.expect("the suite has every effect").generate();
    let logs =
        docking_rig_log::from_text(&case.meta_json, &case.train_csv, &case.test_csv).unwrap();
    logs.train.write(&folder.join("train.mcap")).unwrap();
    logs.test.write(&folder.join("test.mcap")).unwrap();
    fs::write(folder.join("model.toml"), logs.model.to_toml()).unwrap();
    folder
}

const LOGS: [&str; 3] = ["train.mcap", "--test", "test.mcap"];

fn diagnosed(folder: &Path) -> Value {
    json(folder, &[&["diagnose", "model.toml"][..], &LOGS].concat())
}

/// Finds, adds and finds again; the effect has to be gone and the error lower. What was found at first.
fn the_error_falls(folder: &Path, effect: &str) -> Value {
    let found = diagnosed(folder);
    assert_eq!(found["verdict"], "named", "{found}");
    assert_eq!(found["effects"][0], effect);
    for (name, estimate) in found["parameters"][effect].as_object().unwrap() {
        let of = |key: &str| estimate[key].as_f64().unwrap_or(f64::NAN);
        assert!(
            of("low") <= of("value") && of("value") <= of("high"),
            "{name}: {estimate}"
        );
        assert!(estimate["unit"].is_string());
    }
    let added = json(
        folder,
        &[&["add", "model.toml", "--fit"][..], &LOGS].concat(),
    );
    assert_eq!(added["written"], true);
    let again = diagnosed(folder);
    assert_eq!(again["verdict"], "nothing_missing", "{again}");
    let history = json(folder, &["history", "model.toml"]);
    let steps = history["steps"].as_array().unwrap();
    let effects: Vec<&str> = steps.iter().filter_map(|s| s["effect"].as_str()).collect();
    assert_eq!(effects, ["nominal", effect]);
    for error in ["train_error", "test_error"] {
        let [before, after] = [0, 1].map(|k| steps[k][error].as_f64().unwrap());
        assert!(
            after < 0.95 * before,
            "{error} goes from {before} to {after}"
        );
    }
    // What was said on the way is what the model in the file does now.
    let levels = &again["residual_rms_sigma"]["before"];
    let squared = |channel| {
        levels[channel]
            .as_f64()
            .map_or(f64::NAN, |level| level * level)
    };
    let noisy = ["executed_velocity", "wrench", "pose"].map(squared);
    let measured = noisy.iter().filter(|square| **square > 1e-6).count();
    let sum = noisy.iter().sum::<f64>() + squared("model_velocity");
    let rms = (sum / measured as f64).sqrt();
    let promised = steps[1]["test_error"].as_f64().unwrap();
    assert!(
        (rms / promised - 1.0).abs() < 1e-4,
        "{rms} is not {promised}"
    );
    found
}

#[test]
fn a_hidden_friction_is_found_added_and_gone() {
    let folder = generated("cli_friction", &["guide_coulomb"]);
    the_error_falls(&folder, "guide_coulomb");
    let text = done(
        &folder,
        &["history", "model.toml", "--report", "history.html"],
    );
    assert!(
        text.contains("+ guide_coulomb") && text.contains("█"),
        "{text}"
    );
    let page = fs::read_to_string(folder.join("history.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("guide_coulomb"));
}

#[test]
#[ignore = "long: one more machine to diagnose"]
fn effects_that_are_asked_for_are_added_together() {
    let folder = generated("cli_together", &["actuation_delay", "guide_coulomb"]);
    fn add<'a>(ids: &[&'a str]) -> Vec<&'a str> {
        [&["add", "model.toml"], ids, &["--fit"], &LOGS[..]].concat()
    }
    let before = fs::read_to_string(folder.join("model.toml")).unwrap();
    for (ids, says) in [
        (
            &["actuation_delay", "guide_coulomb", "actuation_delay"][..],
            "received `actuation_delay` twice",
        ),
        (
            &["actuation_delay", "guide_coulomb", "cable_stiffness"],
            "do not pay for the parameters of `cable_stiffness`",
        ),
        (
            &[
                "actuation_delay",
                "guide_coulomb",
                "ft_saturation",
                "--force",
            ],
            "determine no parameter of `ft_saturation`",
        ),
    ] {
        let refused = softdock(&folder, &add(ids));
        assert!(
            !refused.success && refused.stderr.contains(says),
            "{refused:?}"
        );
    }
    assert_eq!(
        fs::read_to_string(folder.join("model.toml")).unwrap(),
        before
    );
    let added = |ids: &[&str]| {
        let added = json(&folder, &add(ids));
        let effects = added["effects"].as_array().unwrap().iter();
        let mut effects: Vec<String> = effects
            .filter_map(Value::as_str)
            .map(str::to_owned)
            .collect();
        effects.sort_unstable();
        effects
    };
    let all = ["actuation_delay", "cable_stiffness", "guide_coulomb"];
    let forced = [&all[..], &["--force", "--dry-run"]].concat();
    assert_eq!(added(&forced), all);
    let both = ["actuation_delay", "guide_coulomb"];
    assert_eq!(added(&both), both);
    let again = softdock(&folder, &add(&["actuation_delay"]));
    assert!(
        again
            .stderr
            .contains("`actuation_delay` is in the model already"),
        "{again:?}"
    );
}

/// By how much the experiment that is proposed would tell effects apart, on the simulated rig.
fn separation_then(found: &Value) -> Option<f64> {
    found["experiment"].get("separation_then")?.as_f64()
}

/// What tells a delay from a lag, quick changes of the velocity, is part of the rehearsal.
#[test]
#[ignore = "long: five diagnoses of a hidden delay"]
fn a_hidden_delay_is_found_added_and_gone() {
    let folder = generated("cli_delay", &["actuation_delay"]);
    fs::copy(folder.join("model.toml"), folder.join("nominal.toml")).unwrap();
    let plain = the_error_falls(&folder, "actuation_delay");
    assert_eq!(separation_then(&plain), None, "{plain}");
    let arguments = [&["diagnose", "nominal.toml"][..], &LOGS, &["--rehearse"]];
    let rehearsed = json(&folder, &arguments.concat());
    assert_eq!(rehearsed["runner_up"], plain["runner_up"]);
    assert!(separation_then(&rehearsed) > Some(100.0), "{rehearsed}");
}

#[test]
#[ignore = "long: a real axis through the whole command"]
fn recorded_data_goes_the_same_way() {
    let Some(case) = recorded_data("hidden-effects-dev/d10") else {
        return;
    };
    let folder = scratch("cli_recorded");
    done(
        &folder,
        &["import", &case.display().to_string(), "-o", "case"],
    );
    the_error_falls(&folder.join("case"), "cable_stiffness");
}

#[test]
fn a_diagnosis_is_told_in_text_json_and_a_page() {
    let folder = generated("cli_diagnosis", &["guide_viscous"]);
    let diagnose = [&["diagnose", "model.toml"][..], &LOGS].concat();
    let document = json(&folder, &[&diagnose[..], &["--rehearse"]].concat());
    assert!(separation_then(&document) > Some(100.0), "{document}");
    for pointer in [
        "/verdict",
        "/effects/0",
        "/parameters/guide_viscous/damping_n_s_per_m/value",
        "/residual_rms_sigma/before/executed_velocity",
        "/residual_rms_sigma/after/pose",
        "/runner_up",
        "/experiment",
        "/where/0/from_s",
        "/where/0/regime",
        "/seconds",
    ] {
        assert!(
            document.pointer(pointer).is_some(),
            "{pointer} in {document}"
        );
    }
    let told = done(
        &folder,
        &[&diagnose[..], &["--report", "page.html"]].concat(),
    );
    let first = told.lines().next().unwrap_or_default();
    assert!(
        first.starts_with("Missing: ") && first.contains("guide_viscous"),
        "{first}"
    );
    assert!(told.contains("N·s/m") && told.contains("Hypotheses"));
    let page = fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("guide_viscous") && page.contains("<svg"));
    let again = softdock(
        &folder,
        &[&diagnose[..], &["--report", "page.html"]].concat(),
    );
    again.refused(&["page.html exists already"]);
}

#[test]
fn a_model_is_edited_only_when_that_helps() {
    let folder = generated("cli_add", &["guide_viscous"]);
    let model = || fs::read_to_string(folder.join("model.toml")).unwrap();
    let before = format!("# my rig\n{}", model());
    fs::write(folder.join("model.toml"), &before).unwrap();
    let add = |effect: &str, more: &[&str]| {
        let fit = [&["add", "model.toml", effect, "--fit"][..], &LOGS].concat();
        softdock(&folder, &[&fit[..], more].concat())
    };
    add("guide_viscos", &[]).refused(&["did you mean `guide_viscous`?"]);
    // Nothing of these is in the log.
    for absent in ["ft_saturation", "clock_jitter"] {
        add(absent, &[]).refused(&[absent]);
    }
    let dry = add("guide_viscous", &["--dry-run"]);
    assert!(
        dry.stdout.contains("+id = \"guide_viscous\""),
        "{}",
        dry.stdout
    );
    assert_eq!(model(), before, "nothing but a real step changes the file");
    let added = add("guide_viscous", &[]).succeeded();
    assert!(
        added.stdout.contains("which the fit has not seen"),
        "{}",
        added.stdout
    );
    assert!(model().starts_with(&before), "{}", model());
    add("guide_viscous", &[]).refused(&["in the model already", "softdock fit"]);
}

#[test]
fn a_refit_moves_what_the_log_determines_and_names_the_rest() {
    let folder = generated("cli_fit", &["guide_viscous"]);
    let add = ["add", "model.toml", "guide_viscous", "--fit"];
    done(&folder, &[&add[..], &LOGS].concat());
    let path = folder.join("model.toml");
    let fitted = fs::read_to_string(&path).unwrap();
    let value = |text: &str| -> f64 {
        let model = softdock_physics::model::Model::from_toml(text, "model").unwrap();
        model.effects[0].parameters["damping_n_s_per_m"]
    };
    let truth = value(&fitted);
    // Somebody writes a wrong number into the file.
    let line = format!("damping_n_s_per_m = {truth:?}");
    assert!(fitted.contains(&line), "{fitted}");
    fs::write(&path, fitted.replace(&line, "damping_n_s_per_m = 2.0")).unwrap();
    let fit = [&["fit", "model.toml"][..], &LOGS].concat();
    let found = json(&folder, &fit);
    let parameters = found["parameters"].as_array().unwrap();
    let of = |name: &str| parameters.iter().find(|p| p["name"] == name).unwrap();
    let damping = of("guide_viscous.damping_n_s_per_m");
    let number = |key: &str| damping[key].as_f64().unwrap();
    assert!(
        (number("value") / truth - 1.0).abs() < 0.1,
        "{damping} and {truth}"
    );
    assert!(
        number("low") < truth && truth < number("high"),
        "{damping} and {truth}"
    );
    assert_eq!(number("prior_share"), 0.0);
    assert_eq!(of("actuator.transport_delay_s")["unit"], "s");
    for one in found["undetermined"].as_array().unwrap() {
        assert!(
            one["reason"].as_str().unwrap().contains("this log"),
            "{one}"
        );
    }
    let errors = |key: &str| [0, 1].map(|k| found["steps"][k][key].as_f64().unwrap());
    for key in ["train_error", "test_error"] {
        let [before, after] = errors(key);
        assert!(after < before, "{key} goes from {before} to {after}");
    }
    assert_eq!(found["written"], false);
    done(&folder, &[&fit[..], &["--write"]].concat());
    let written = value(&fs::read_to_string(&path).unwrap());
    assert!((written / number("value") - 1.0).abs() < 1e-6);
    let history = json(&folder, &["history", "model.toml"]);
    let steps = history["steps"].as_array().unwrap();
    let effects: Vec<&str> = steps.iter().filter_map(|s| s["effect"].as_str()).collect();
    assert_eq!(effects, ["nominal", "guide_viscous", "edited", "refit"]);
}

/// What a command says of a recording that was made worse.
fn said_of(test: &str, spoil: impl Fn(&mut Recording)) -> Finished {
    let folder = generated(test, &[]);
    let mut log = Recording::open(&folder.join("train.mcap")).unwrap();
    spoil(&mut log);
    log.write(&folder.join("bad.mcap")).unwrap();
    softdock(
        &folder,
        &["diagnose", "model.toml", "bad.mcap", "--test", "test.mcap"],
    )
}

#[test]
fn a_log_that_teaches_nothing_is_refused_in_its_own_words() {
    let short = said_of("cli_short", |log| log.cycles.truncate(40));
    short.refused(&["bad.mcap: 40 rows, at least 100 are needed"]);
    let backwards = said_of("cli_backwards", |log| log.cycles[500].trace.time_s = 0.0);
    backwards.refused(&["bad.mcap, row 501", "expected a time that rises"]);
    let still = said_of("cli_still", |log| {
        let first = log.cycles[0];
        for cycle in &mut log.cycles {
            let time_s = cycle.trace.time_s;
            *cycle = first;
            cycle.trace.time_s = time_s;
        }
    });
    still.refused(&["no velocity, pose or wrench changes"]);
    let unknown = said_of("cli_nan", |log| {
        log.cycles[700].trace.executed_velocity[1] = f64::NAN;
    });
    unknown.refused(&["bad.mcap, row 701: the executed velocity is no number"]);
}

#[test]
fn a_log_that_teaches_little_says_so() {
    let idle = said_of("cli_idle", |log| {
        for cycle in &mut log.cycles {
            cycle.trace.sent_velocity = [0.0; 6];
        }
    });
    assert_eq!(idle.code, Some(0), "{}", idle.stderr);
    assert!(
        idle.stderr.contains("no velocity was sent"),
        "{}",
        idle.stderr
    );
    let gap = said_of("cli_gap", |log| {
        log.cycles.drain(900..1000);
    });
    assert!(gap.stderr.contains("row 901"), "{}", gap.stderr);
    assert!(
        gap.stdout.contains("s are missing after"),
        "a note, too: {}",
        gap.stdout
    );
    let millimetres = said_of("cli_mm", |log| {
        for cycle in &mut log.cycles {
            cycle.trace.pose[..3].iter_mut().for_each(|v| *v *= 1000.0);
        }
    });
    millimetres.refused(&[
        "bad.mcap: position x changes 999.9",
        "is the position in mm?",
    ]);
}

/// A command that never changes shows no limit and no width: what is made of its amounts is no number that cannot be simulated.
#[test]
#[ignore = "long: an actuator that is searched in vain"]
fn a_command_that_never_changes_says_so() {
    let folder = generated("cli_steady", &[]);
    for name in ["train.mcap", "test.mcap"] {
        let mut log = Recording::open(&folder.join(name)).unwrap();
        log.cycles.truncate(500);
        if name.starts_with("train") {
            for cycle in &mut log.cycles {
                cycle.trace.sent_velocity = [0.01, 0.0, 0.0, 0.0, 0.0, 0.0];
            }
        }
        log.write(&folder.join(name)).unwrap();
    }
    let arguments = [&["diagnose", "model.toml"][..], &LOGS].concat();
    let steady = softdock(&folder, &arguments);
    assert_eq!(steady.code, Some(0), "{}", steady.stderr);
    let said = "the velocity that is sent never changes";
    assert!(steady.stderr.contains(said), "{}", steady.stderr);
}

#[test]
fn files_of_the_wrong_kind_are_named() {
    let folder = generated("cli_wrong", &[]);
    let diagnose = |model: &str, log: &str| softdock(&folder, &["diagnose", model, log]);
    diagnose("modl.toml", "train.mcap").refused(&["did you mean", "model.toml"]);
    diagnose("model.toml", "model.toml").refused(&["model.toml"]);
    diagnose("model.toml", "nothing.mcap").refused(&["nothing.mcap"]);
    fs::write(
        folder.join("wrong.toml"),
        "[[effect]]\nid = \"rate_limit\"\nparameters = { max_acceleration = 1.0 }\n",
    )
    .unwrap();
    let wrong = diagnose("wrong.toml", "train.mcap");
    wrong.refused(&[
        "wrong.toml",
        "`rate_limit`",
        "did you mean `max_acceleration_m_s2`?",
    ]);
    let empty = done(&folder, &["history", "model.toml"]);
    assert!(empty.contains("no history yet"), "{empty}");
    let nothing = json(&folder, &["history", "model.toml"]);
    assert_eq!(nothing["steps"].as_array().map(Vec::len), Some(0));
}
