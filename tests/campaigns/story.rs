//! The campaign of the examples, from plan to report.

use super::{done, json};
use softdock_io::data_table::{DataTable, Values};
use softdock_tests::process::scratch;
use std::fs;
use std::path::Path;

#[test]
fn the_example_leads_to_a_report() {
    let folder = scratch("campaign_example");
    let example =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/campaign/spring-rod.toml");
    let example = example.to_str().unwrap();
    done(&folder, &["campaign", "plan", example, "-o", "campaign"]);
    let run = json(&folder, &["campaign", "run", "campaign", "--json"]);
    assert_eq!((&run["rows"], &run["failed"]), (&300.into(), &0.into()));
    let merged = json(
        &folder,
        &[
            "campaign",
            "merge",
            "campaign",
            "-o",
            "results.parquet",
            "--report",
            "results.html",
            "--json",
        ],
    );
    let summary = &merged["summary"];
    // Without a law nothing comes back right; with the predictor nearly everything does.
    let groups = summary["groups"].as_array().unwrap();
    let share = |law: &str| {
        let group = groups.iter().find(|group| group["value"] == law).unwrap();
        group["success"]["value"].as_f64().unwrap()
    };
    assert_eq!(share("none"), 0.0);
    assert!(share("predictor") > 0.9, "{summary}");
    assert_eq!(summary["worst"].as_array().unwrap().len(), 10);
    let rerun = summary["worst"][0]["rerun"].as_str().unwrap();
    assert!(
        rerun.starts_with("softdock campaign rerun campaign --index "),
        "{rerun}"
    );
    let page = fs::read_to_string(folder.join("results.html")).unwrap();
    for part in [
        "Which factor matters",
        "Where it succeeds",
        "Worst rows",
        "rerun campaign",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

/// Three of the dockings in the standard's box: what was captured has a time, and every load was measured.
#[test]
fn a_soft_capture_knows_its_loads() {
    let folder = scratch("campaign_soft_capture");
    let example =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/campaign/soft-capture.toml");
    let example = example.to_str().unwrap();
    done(&folder, &["campaign", "plan", example, "-o", "campaign"]);
    let arguments = ["campaign", "run", "campaign", "--shard", "0/40", "--json"];
    let run = json(&folder, &arguments);
    assert_eq!((&run["rows"], &run["failed"]), (&3.into(), &0.into()));
    let part = DataTable::read_parquet(&folder.join("campaign/part-0-of-40.parquet")).unwrap();
    let numbers = |name: &str| match part.values(name).unwrap() {
        Values::Number(values) => values.clone(),
        other => panic!("{name}: {other:?}"),
    };
    let Values::Flag(captured) = part.values("captured").unwrap() else {
        panic!("`captured` is a flag");
    };
    for (captured, at) in captured.iter().zip(numbers("captured_s")) {
        assert_eq!(*captured, Some(at.is_some()));
    }
    for name in ["compression_n", "shear_n", "torsion_n_m", "bending_n_m"] {
        let loads = numbers(name);
        assert!(
            loads.iter().all(|load| load.is_some_and(|n| n > 0.0)),
            "{name}: {loads:?}"
        );
    }
}

/// The corners of the box are every combination of its ends, and a row of them runs.
#[test]
fn the_corners_of_the_standards_box_are_a_campaign() {
    let folder = scratch("campaign_corners");
    let example = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../examples/campaign/soft-capture-corners.toml");
    let example = example.to_str().unwrap();
    let plan = json(&folder, &["campaign", "plan", example, "-o", "c", "--json"]);
    assert_eq!(plan["rows"], 4096, "{plan}");
    let arguments = ["campaign", "run", "c", "--shard", "7/2048", "--json"];
    let run = json(&folder, &arguments);
    assert_eq!((&run["rows"], &run["failed"]), (&2.into(), &0.into()));
}
