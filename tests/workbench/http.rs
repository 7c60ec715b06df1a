//! What programs get: the same numbers as on the command line, series as bytes, jobs with their progress.

use super::server::{Bench, imported};
use serde_json::{Value, json};
use softdock_tests::process::{done, json, scratch, words};
use std::fs;

fn selection() -> Value {
    json!({"model": "model.toml", "fit": ["train.mcap"], "test": ["test.mcap"]})
}

#[test]
fn programs_get_what_the_commands_print() {
    let folder = imported("workbench_http", "guide_coulomb");
    let bench = Bench::start(&folder);

    let recordings = bench.get("/api/recordings").json();
    let ids: Vec<&str> = recordings
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|r| r["id"].as_str())
        .collect();
    assert!(
        ids.contains(&"train.mcap") && ids.contains(&"test.mcap"),
        "{ids:?}"
    );
    assert_eq!(bench.get("/api/models").json()[0]["id"], "model.toml");
    assert_eq!(
        bench.get("/api/effects").json(),
        json(&folder, &["effects"])
    );
    let pair = json!({"model": "model.toml", "recording": "test.mcap"});
    assert_eq!(
        bench.post("/api/compare", &pair).json(),
        json(&folder, &["compare", "model.toml", "test.mcap"])
    );

    let channels = bench.get("/api/recordings/test.mcap/channels").json();
    let name = channels[0]["name"].as_str().unwrap();
    let series = bench.get(&format!(
        "/api/recordings/test.mcap/series?c={name}&from=0.5&to=1"
    ));
    let prediction =
        bench.get("/api/prediction?recording=test.mcap&model=model.toml&channel=wrench&axis=x");
    for (answer, columns) in [(series, 2), (prediction, 4)] {
        assert_eq!(answer.status, 200);
        let number =
            |at: usize| u32::from_le_bytes(answer.body[at..at + 4].try_into().unwrap()) as usize;
        assert!(number(0) > 100);
        assert_eq!(
            (number(4), answer.body.len()),
            (columns, 8 + 8 * number(0) * columns)
        );
    }

    let check = bench.post("/api/check", &selection()).json();
    assert_eq!(check["ready"], true, "{check}");
    let events = bench.job(&json!({"kind": "diagnose", "args": selection()}));
    let of = |kind: &str| events.iter().filter(|event| event.0 == kind).count();
    assert!(of("stage") > 3 && of("candidate") > 10, "{events:?}");
    let (last, mut found) = events.last().unwrap().clone();
    let mut expected = json(
        &folder,
        &words("add model.toml --fit train.mcap --test test.mcap --dry-run"),
    );
    assert_eq!(last, "result", "{found}");
    for document in [&mut found, &mut expected] {
        let document = document.as_object_mut().unwrap();
        // What depends on the clock, the paths of the diff's header, and what only one of the two has.
        for key in ["seconds", "difference", "if_match", "doubt", "notes"] {
            document.remove(key);
        }
    }
    assert_eq!(found, expected);

    assert_eq!(
        bench.get("/api/models/model.toml/history").json(),
        json(&folder, &["history", "model.toml"])
    );
}

/// Adds, undoes, and writes nothing over what somebody else wrote.
#[test]
fn a_model_is_changed_only_as_it_was_seen() {
    let folder = imported("workbench_change", "guide_coulomb");
    let bench = Bench::start(&folder);
    let path = folder.join("model.toml");
    let original = fs::read_to_string(&path).unwrap();
    let add = json!({"kind": "add", "args": {"selection": selection(), "effect": "guide_coulomb"}});
    let events = bench.job(&add);
    let found = &events.last().unwrap().1;
    assert!(
        found["difference"]
            .as_str()
            .unwrap()
            .contains("+id = \"guide_coulomb\""),
        "{found}"
    );
    assert_eq!(
        fs::read_to_string(&path).unwrap(),
        original,
        "a trial writes nothing"
    );

    let write = json!({"job": 1, "if_match": found["if_match"]});
    fs::write(&path, format!("{original}\n# mine\n")).unwrap();
    let refused = bench.post("/api/models/model.toml/effects", &write);
    assert_eq!(refused.status, 409, "{}", refused.json());
    assert!(fs::read_to_string(&path).unwrap().ends_with("# mine\n"));

    fs::write(&path, &original).unwrap();
    let written = bench.post("/api/models/model.toml/effects", &write);
    assert_eq!(written.status, 200, "{}", written.json());
    assert!(fs::read_to_string(&path).unwrap().contains("guide_coulomb"));
    assert_eq!(
        bench.post("/api/models/model.toml/effects", &write).status,
        409
    );

    let remove = json!({"if_match": written.json()["if_match"], "write": true});
    let removed = bench.post(
        "/api/models/model.toml/effects/guide_coulomb/remove",
        &remove,
    );
    assert_eq!(removed.status, 200, "{}", removed.json());
    let without = fs::read_to_string(&path).unwrap();
    let undo = json!({"if_match": removed.json()["if_match"]});
    let undone = bench.post("/api/models/model.toml/undo", &undo);
    assert_eq!(undone.status, 200, "{}", undone.json());
    assert!(fs::read_to_string(&path).unwrap().contains("guide_coulomb"));
    fs::write(&path, without).unwrap();
    assert!(
        !fs::read_to_string(&path)
            .unwrap()
            .contains("id = \"guide_coulomb\"")
    );
}

/// Effects are tried together, as `add` does it: all of them or none.
#[test]
fn several_effects_are_tried_together_or_not_at_all() {
    let folder = imported("workbench_several", "guide_coulomb");
    let bench = Bench::start(&folder);
    let tried = |effects: Value| {
        let args = json!({"selection": selection(), "effect": effects});
        let events = bench.job(&json!({"kind": "add", "args": args}));
        let (kind, last) = events.last().unwrap();
        (kind.clone(), last.clone())
    };
    let (kind, found) = tried(json!(["guide_coulomb"]));
    assert_eq!(
        (kind.as_str(), &found["effects"]),
        ("result", &json!(["guide_coulomb"]))
    );
    let (kind, refused) = tried(json!(["guide_coulomb", "guide_viscous"]));
    let why = refused.to_string();
    assert_eq!(kind, "error", "{why}");
    assert!(
        why.contains("do not pay for the parameters of `guide_viscous`"),
        "{why}"
    );
    let (_, refused) = tried(json!(["guide_coulomb", "guide_coulomb"]));
    assert!(
        refused.to_string().contains("each effect once"),
        "{refused}"
    );
}

/// A formula that no file has is tried, and written with its effect.
#[test]
fn an_own_hypothesis_is_tried_and_written() {
    let folder = imported("workbench_hypothesis", "guide_coulomb");
    let bench = Bench::start(&folder);
    let own = json!({
        "id": "rubbing", "acts_on": "guide", "formula": "-friction_n*direction",
        "parameters": {"friction_n": {"unit": "N", "low": 0.0, "high": 50.0}}
    });
    let mut args = json!({"selection": selection(), "hypothesis": own});
    let events = bench.job(&json!({"kind": "add", "args": args}));
    let (kind, found) = events.last().unwrap();
    assert_eq!(kind, "result", "{found}");
    let write = json!({"job": 1, "if_match": found["if_match"], "force": true});
    let written = bench.post("/api/models/model.toml/effects", &write);
    assert_eq!(written.status, 200, "{}", written.json());
    let text = fs::read_to_string(folder.join("model.toml")).unwrap();
    assert!(
        text.contains("[[hypothesis]]") && text.contains("id = \"rubbing\""),
        "{text}"
    );

    args["effect"] = json!("guide_coulomb");
    let both = bench.post("/api/jobs", &json!({"kind": "add", "args": args}));
    assert_eq!(both.status, 422);
    assert!(both.json().to_string().contains("received both"));
    args.as_object_mut().unwrap().remove("effect");

    args["hypothesis"]["id"] = json!("rubbing_too");
    args["hypothesis"]["formula"] = json!("-friction_n*directon");
    let refused = bench.post("/api/jobs", &json!({"kind": "add", "args": args}));
    assert_eq!(refused.status, 422);
    assert!(
        refused.json()["error"]
            .as_str()
            .unwrap()
            .contains("did you mean `direction`?")
    );
}

#[test]
fn a_diagnosis_can_be_ended() {
    let folder = imported("workbench_cancel", "guide_coulomb");
    let bench = Bench::start(&folder);
    let diagnose = json!({"kind": "diagnose", "args": selection()});
    let id = bench.post("/api/jobs", &diagnose).json()["id"].clone();
    let ended = bench.ask("DELETE", &format!("/api/jobs/{id}"), &Value::Null);
    assert_eq!(ended.status, 204);
    let told = bench.get(&format!("/api/jobs/{id}/events")).body;
    let told = String::from_utf8(told).unwrap();
    assert!(
        told.contains("event: error") && told.contains("ended on request"),
        "{told}"
    );
    // And the next one runs.
    assert_eq!(bench.job(&diagnose).last().unwrap().0, "result");
}

#[test]
fn what_is_missing_is_said_before_a_diagnosis() {
    let folder = imported("workbench_check", "guide_coulomb");
    let bench = Bench::start(&folder);
    let twice = json!({"model": "model.toml", "fit": ["train.mcap"], "test": ["train.mcap"]});
    let check = bench.post("/api/check", &twice).json();
    assert_eq!(check["ready"], false, "{check}");
    assert!(
        check["against"]
            .as_str()
            .unwrap()
            .starts_with("train.mcap is given twice"),
        "{check}"
    );
    let refused = bench.post("/api/jobs", &json!({"kind": "diagnose", "args": twice}));
    assert_eq!(refused.status, 422, "{}", refused.json());
}

#[test]
fn all_parameters_are_fitted_as_the_command_fits_them() {
    let folder = imported("workbench_fit", "guide_coulomb");
    let bench = Bench::start(&folder);
    let events = bench.job(&json!({"kind": "fit", "args": selection()}));
    let (kind, found) = events.last().unwrap();
    assert_eq!(kind, "result", "{found}");
    let arguments = ["fit", "model.toml", "train.mcap", "--test", "test.mcap"];
    let expected = json(&folder, &arguments);
    for key in ["parameters", "undetermined", "steps", "written"] {
        assert_eq!(found[key], expected[key], "{key}");
    }
    let before = std::fs::read_to_string(folder.join("model.toml")).unwrap();
    let write = json!({"job": 1, "if_match": found["if_match"], "force": true});
    let written = bench.post("/api/models/model.toml/effects", &write);
    assert_eq!(written.status, 200, "{}", written.json());
    let history = bench.get("/api/models/model.toml/history").json();
    assert_eq!(history["steps"][1]["effect"], "refit", "{history}");
    // And back, byte for byte, once.
    let undo = json!({"if_match": written.json()["if_match"]});
    let undone = bench.post("/api/models/model.toml/undo", &undo);
    assert_eq!(undone.status, 200, "{}", undone.json());
    let after = std::fs::read_to_string(folder.join("model.toml")).unwrap();
    assert_eq!(after, before);
    assert_eq!(bench.post("/api/models/model.toml/undo", &undo).status, 409);
}

/// The run of the page is the run of the command, into a recording that was not there before.
#[test]
fn a_scenario_is_run_as_the_command_runs_it() {
    let folder = scratch("workbench_run");
    done(&folder, &["init", "."]);
    let bench = Bench::start(&folder);
    let scenarios = bench.get("/api/scenarios").json();
    assert_eq!(scenarios[0]["id"], "scenario.toml", "{scenarios}");
    assert_eq!(scenarios.as_array().unwrap().len(), 1, "{scenarios}");

    let args = json!({"scenario": "scenario.toml", "output": "mine.mcap", "law": "lead", "duration_s": 2.0});
    let events = bench.job(&json!({"kind": "run", "args": args}));
    let (kind, mut said) = events.last().unwrap().clone();
    assert_eq!(kind, "result", "{said}");
    assert_eq!(said["recording"], "mine.mcap");
    let arguments = words("run scenario.toml -o theirs.mcap --law lead --duration-s 2");
    let mut expected = json(&folder, &arguments);
    for document in [&mut said, &mut expected] {
        let document = document.as_object_mut().unwrap();
        for of_this_run in [
            "real_time_factor",
            "cycles_per_processor_second",
            "recording",
        ] {
            document.remove(of_this_run);
        }
    }
    assert_eq!(said, expected);

    let status = |args: Value| {
        let answer = bench.post("/api/jobs", &json!({"kind": "run", "args": args}));
        (answer.status, answer.json().to_string())
    };
    let (code, why) = status(args);
    assert!(code == 409 && why.contains("choose another name"), "{why}");
    for (output, expected) in [
        ("../out.mcap", 400),
        ("out.toml", 422),
        ("no/out.mcap", 422),
    ] {
        let (code, why) = status(json!({"scenario": "scenario.toml", "output": output}));
        assert_eq!(code, expected, "{why}");
    }
    let (code, why) = status(json!({"scenario": "scenario.toml", "output": "x.mcap", "laws": 1}));
    assert!(
        code == 422 && why.contains("unknown field `laws`"),
        "{code} {why}"
    );
    let unknown = json!({"scenario": "scenario.toml", "output": "x.mcap", "law": "leed"});
    let events = bench.job(&json!({"kind": "run", "args": unknown}));
    let why = events.last().unwrap().1["error"]
        .as_str()
        .unwrap()
        .to_owned();
    assert!(
        why.contains("there is no delay law `leed`; expected one of none, "),
        "{why}"
    );
}

#[test]
fn a_run_that_is_ended_leaves_no_recording() {
    let folder = scratch("workbench_run_ended");
    done(&folder, &["init", "."]);
    let bench = Bench::start(&folder);
    let args = json!({"scenario": "scenario.toml", "output": "long.mcap", "duration_s": 3000.0});
    let id = bench
        .post("/api/jobs", &json!({"kind": "run", "args": args}))
        .json()["id"]
        .clone();
    let path = format!("/api/jobs/{id}/events");
    bench.hear(&path, |heard| heard.contains("simulating"));
    assert_eq!(
        bench
            .ask("DELETE", &format!("/api/jobs/{id}"), &Value::Null)
            .status,
        204
    );
    let told = String::from_utf8(bench.get(&path).body).unwrap();
    assert!(told.contains("ended on request"), "{told}");
    assert!(!folder.join("long.mcap").exists());
}
