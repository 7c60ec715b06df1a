//! What programs get: the same numbers as on the command line, series as bytes, jobs with their progress.

use super::server::{Bench, imported};
use serde_json::{Value, json};
use softdock_tests::process::softdock;
use std::fs;
use std::path::Path;

fn selection() -> Value {
    json!({"model": "model.toml", "fit": ["train.mcap"], "test": ["test.mcap"]})
}

/// What a command prints.
fn printed(folder: &Path, arguments: &[&str]) -> Value {
    let run = softdock(folder, &[arguments, &["--json"]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap()
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
        printed(&folder, &["effects"])
    );
    let pair = json!({"model": "model.toml", "recording": "test.mcap"});
    assert_eq!(
        bench.post("/api/compare", &pair).json(),
        printed(&folder, &["compare", "model.toml", "test.mcap"])
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
    let mut expected = printed(
        &folder,
        &[
            "add",
            "model.toml",
            "--fit",
            "train.mcap",
            "--test",
            "test.mcap",
            "--dry-run",
        ],
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
        printed(&folder, &["history", "model.toml"])
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
    assert!(
        !fs::read_to_string(&path)
            .unwrap()
            .contains("id = \"guide_coulomb\"")
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
