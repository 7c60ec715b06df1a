//! Logs of other programs.

use softdock_analysis::compare::compare;
use softdock_analysis::import::docking_rig_log;
use softdock_analysis::import::mapping::import_at_least;
use softdock_io::recording::Recording;
use softdock_physics::model::Model;

/// Separates the texts of an input.
const SEPARATOR: &str = "\n=====\n";

/// A mapping and a table.
pub(super) fn table(input: &[u8]) {
    let separator = SEPARATOR.as_bytes();
    let mut places = input.windows(separator.len());
    let Some(place) = places.position(|window| window == separator) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("mapping.toml"), &input[..place]).unwrap();
    std::fs::write(path("log.csv"), &input[place + separator.len()..]).unwrap();
    if let Ok(logs) = import_at_least(folder.path(), &path("mapping.toml"), Some(2)) {
        let model = logs.model.map_or_else(Model::default, |(model, _)| model);
        for log in logs.train.iter().chain(&logs.test) {
            compared(&model, log);
        }
    }
}

/// A folder of docking-rig-log/1.
pub(super) fn rig_log(input: &[u8]) {
    let text = String::from_utf8_lossy(input);
    let mut parts = text.split(SEPARATOR);
    let (Some(meta), Some(train)) = (parts.next(), parts.next()) else {
        return;
    };
    let test = parts.next().unwrap_or(train);
    if let Ok(logs) = docking_rig_log::from_text(meta, train, test) {
        compared(&logs.model, &logs.test);
    }
}

/// An imported log can be compared, or the comparison returns an error; and it can be written.
fn compared(model: &Model, recording: &Recording) {
    let _ = compare(model, recording);
    recording.write_to(Vec::new()).unwrap();
}
