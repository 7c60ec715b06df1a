//! The campaign of the examples, from plan to report.

use softdock_io::data_table::{DataTable, Values};
use softdock_tests::process::{done, json, scratch, words};
use std::fs;
use std::path::Path;

#[test]
fn the_example_leads_to_a_report() {
    let folder = scratch("campaign_example");
    let example =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/campaign/spring-rod.toml");
    let example = example.to_str().unwrap();
    done(&folder, &["campaign", "plan", example, "-o", "campaign"]);
    let run = json(&folder, &["campaign", "run", "campaign"]);
    assert_eq!((&run["rows"], &run["failed"]), (&300.into(), &0.into()));
    let merged = json(
        &folder,
        &words("campaign merge campaign -o results.parquet --report results.html"),
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
    let limit = &summary["limits"][0];
    assert_eq!(
        (&limit["outcome"], &limit["source_read"]),
        (&"restitution".into(), &true.into())
    );
    let page = fs::read_to_string(folder.join("results.html")).unwrap();
    for part in [
        "chosen here: within a tenth",
        "Which factor matters",
        "Where it succeeds",
        "Worst rows",
        "rerun campaign",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

/// Two approaches from the standard's box with both laws: what was captured has a time, every load was measured, and the page
/// says which of its limits nobody has read.
#[test]
fn a_soft_capture_knows_its_loads() {
    let folder = scratch("campaign_soft_capture");
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/campaign");
    let example = fs::read_to_string(examples.join("soft-capture.toml")).unwrap();
    let scenario = examples.join("../../host-tools/scenarios/soft-capture.toml");
    let two = example.replace("samples = 60", "samples = 2").replace(
        "../../host-tools/scenarios/soft-capture.toml",
        scenario.to_str().unwrap(),
    );
    fs::write(folder.join("two.toml"), two).unwrap();
    done(&folder, &["campaign", "plan", "two.toml", "-o", "c"]);
    let run = json(&folder, &["campaign", "run", "c"]);
    assert_eq!((&run["rows"], &run["failed"]), (&4.into(), &0.into()));
    let arguments = words("campaign merge c -o t.parquet --report t.html");
    let said = done(&folder, &arguments);
    let page = fs::read_to_string(folder.join("t.html")).unwrap();
    for text in [said, page] {
        let headline = "Limits without a source that somebody has read: 5 of 6.";
        assert!(text.contains(headline), "{text}");
        assert!(text.contains("✗ IDSS IDD from memory"), "{text}");
    }
    let part = DataTable::read_parquet(&folder.join("t.parquet")).unwrap();
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
    let plan = json(&folder, &["campaign", "plan", example, "-o", "c"]);
    assert_eq!(plan["rows"], 4096, "{plan}");
    let arguments = ["campaign", "run", "c", "--shard", "7/2048"];
    let run = json(&folder, &arguments);
    assert_eq!((&run["rows"], &run["failed"]), (&2.into(), &0.into()));
}
