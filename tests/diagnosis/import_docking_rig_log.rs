//! Imported docking-rig-log/1 folders against the residuals that their authors computed.
//!
//! The data is not part of the project: `SOFTDOCK_DATA` names the folder that holds it.

use serde_json::Value;
use softdock_analysis::compare::compare;
use softdock_analysis::import::docking_rig_log;
use softdock_io::recording::Recording;
use softdock_physics::model::{Channel, Model};
use softdock_tests::process::{json, recorded_data, scratch};
use std::fs;
use std::path::PathBuf;

/// The residuals in `truth.json` have four decimals.
const TOLERANCE: f64 = 1e-3;

/// The development cases.
fn cases() -> Option<PathBuf> {
    recorded_data("hidden-effects-dev")
}

/// Residual of a channel in units of the data sheet's noise.
fn residual(model: &Model, recording: &Recording, channel: Channel) -> f64 {
    let comparison = compare(model, recording).unwrap();
    let total = comparison.totals.iter().find(|t| t.name == channel);
    total.unwrap().rms_sigma
}

#[test]
fn the_nominal_residuals_of_two_cases_are_reproduced() {
    residuals_are_reproduced(12);
}

#[test]
#[ignore = "long: 24 cases"]
fn the_nominal_residuals_of_all_cases_are_reproduced() {
    residuals_are_reproduced(1);
}

/// Of every so many cases.
fn residuals_are_reproduced(every: usize) {
    let Some(folder) = cases() else { return };
    let truth: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("truth.json")).unwrap()).unwrap();
    let truth = truth.as_object().unwrap();
    assert_eq!(truth.len(), 24);
    for (case, truth) in truth.iter().step_by(every) {
        let logs = docking_rig_log::read(&folder.join(case)).unwrap();
        assert!(logs.warnings.is_empty(), "{case}: {:?}", logs.warnings);
        for (log, recording) in [("train", &logs.train), ("test", &logs.test)] {
            for (letter, channel) in [
                ("A", Channel::ExecutedVelocity),
                ("B", Channel::Wrench),
                ("K", Channel::Pose),
            ] {
                let expected = truth[log]["z_nominal"][letter].as_f64().unwrap();
                let received = residual(&logs.model, recording, channel);
                assert!(
                    (received - expected).abs() < TOLERANCE,
                    "{case} {log} {letter}: expected {expected}, received {received}"
                );
            }
        }
    }
}

#[test]
fn the_command_writes_a_model_and_two_recordings() {
    let Some(folder) = cases() else { return };
    let scratch = scratch("import_docking_rig_log");
    let case = folder.join("d05");
    let report = json(&scratch, &["import", case.to_str().unwrap(), "-o", "d05"]);
    assert_eq!(report["cycles"], 5000);
    assert_eq!(report["warnings"], Value::Array(Vec::new()));
    assert_eq!(report["files"].as_array().unwrap().len(), 3);

    let logs = docking_rig_log::read(&case).unwrap();
    let written = scratch.join("d05");
    assert_eq!(
        Model::load(&written.join("model.toml")).unwrap(),
        logs.model
    );
    for (name, recording) in [("train.mcap", &logs.train), ("test.mcap", &logs.test)] {
        assert_eq!(Recording::open(&written.join(name)).unwrap(), *recording);
    }
}
