//! Tables of other programs, written and imported through a mapping.

use softdock_analysis::import::mapping::{MappedLogs, import};
use softdock_analysis::import::starter::starter;
use softdock_physics::model::Model;
use softdock_tests::process::scratch;
use std::fs;

/// Imports the files of a table through a mapping, in a folder of its own.
pub(super) fn imported(
    test: &str,
    mapping: &str,
    files: &[(&str, String)],
) -> Result<MappedLogs, String> {
    let folder = scratch(test);
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
    fs::write(folder.join("mapping.toml"), mapping).unwrap();
    import(&folder, &folder.join("mapping.toml")).map_err(|error| format!("{error:#}"))
}

/// The model to start from that an import writes for its logs.
pub(super) fn started(logs: &MappedLogs) -> Model {
    let starter = starter(&logs.train, logs.filtered.as_ref(), &logs.told).unwrap();
    Model::from_toml(&starter.text, "model.toml").unwrap()
}

/// A table with a header; each row is made of its number.
pub(super) fn table(header: &str, rows: usize, row: impl Fn(f64) -> String) -> String {
    let rows = (0..rows).map(|n| row(n as f64) + "\n");
    format!("{header}\n{}", rows.collect::<String>())
}

pub(super) fn near(received: &[f64], expected: &[f64]) -> bool {
    let near = |(r, e): (&f64, &f64)| (r - e).abs() < 1e-9;
    received.len() == expected.len() && received.iter().zip(expected).all(near)
}
