//! Texts written by users, and recordings.

use softdock_app::robot_link::Prepared;
use softdock_app::settings::BoardSettings;
use softdock_experiments::campaign::plan::Plan;
use softdock_experiments::run::run;
use softdock_experiments::scenario::{SPRING_ROD, Scenario};
use softdock_io::input;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use std::ops::ControlFlow;

/// Length of a run of a scenario, s.
const RUN_S: f64 = 0.1;

/// A recording that can be read can be written and read again without a change.
pub(super) fn recording(input: &[u8]) {
    if let Ok(recording) = Recording::read_from(input, input.len() as u64)
        && let Ok(file) = recording.write_to(Vec::new())
    {
        let again = Recording::read_from(file.as_slice(), file.len() as u64).unwrap();
        // As text, because no NaN equals another.
        assert_eq!(format!("{again:?}"), format!("{recording:?}"));
    }
}

/// A model that is accepted can be written and read again.
pub(super) fn model(input: &[u8]) {
    if let Ok(text) = str::from_utf8(input)
        && let Ok(model) = Model::from_toml(text, "model.toml")
    {
        let again = Model::from_toml(&model.to_toml(), "again").unwrap();
        assert_eq!(format!("{again:?}"), format!("{model:?}"));
    }
}

/// Settings that are accepted are valid for a board.
pub(super) fn settings(input: &[u8]) {
    if let Ok(text) = str::from_utf8(input)
        && let Ok(settings) = input::parse::<BoardSettings>(text, "board.toml")
        && settings.validate().is_ok()
    {
        assert!(Prepared::new(&settings).is_ok());
    }
}

/// An accepted scenario runs or returns an error.
pub(super) fn scenario(input: &[u8]) {
    if let Ok(text) = str::from_utf8(input)
        && let Ok(mut scenario) = input::parse::<Scenario>(text, "scenario.toml")
        && scenario.validate().is_ok()
    {
        scenario.duration_s = RUN_S;
        let _ = run(&scenario, &mut |_, _| ControlFlow::Continue(()));
    }
}

/// Every row of an accepted campaign is a scenario or an error.
pub(super) fn campaign(input: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("campaign.toml");
    std::fs::write(folder.path().join("spring-rod.toml"), SPRING_ROD).unwrap();
    std::fs::write(&file, input).unwrap();
    if let Ok(plan) = Plan::new(&file) {
        for row in [0, plan.rows() / 2, plan.rows() - 1] {
            let _ = plan.scenario(row);
        }
    }
}
