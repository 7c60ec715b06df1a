//! Input of a command of this group: one of our recordings, or anything that can be imported.

use anyhow::{Result, ensure};
use softdock_analysis::import::{docking_rig_log, mapping};
use softdock_io::recording::{Recording, import_csv};
use softdock_physics::model::Model;
use std::path::Path;

/// Least number of rows that can show anything.
const FEWEST_ROWS: usize = 3;

/// A recording with what is known about it.
#[derive(Debug)]
pub struct Read {
    /// The recording.
    pub recording: Recording,
    /// Rows that the mapping keeps back as unseen.
    pub unseen: Option<Recording>,
    /// The model that belongs to it.
    pub model: Option<Model>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Reads a recording (MCAP), a table that `softdock export` wrote, a docking-rig-log/1 folder, or
/// with a mapping any table.
///
/// # Errors
///
/// Those of the import.
pub fn read(path: &Path, mapping_file: Option<&Path>) -> Result<Read> {
    if let Some(mapping_file) = mapping_file {
        let mut logs = mapping::import_at_least(path, mapping_file, Some(FEWEST_ROWS))?;
        ensure!(
            logs.train.len() == 1 && logs.test.len() < 2,
            "{}: expected one log, and at most one of test data; it names {} and {}",
            mapping_file.display(),
            logs.train.len(),
            logs.test.len()
        );
        return Ok(Read {
            recording: logs.train.remove(0),
            unseen: logs.test.pop(),
            model: logs.model.map(|(model, _)| model),
            notes: logs.warnings,
        });
    }
    if path.is_dir() {
        let logs = docking_rig_log::read(path)?;
        return Ok(Read {
            recording: logs.train,
            unseen: None,
            model: Some(logs.model),
            notes: logs.warnings,
        });
    }
    let is_table = path.extension().is_some_and(|e| e == "csv" || e == "txt");
    let recording = if is_table {
        import_csv(path)?
    } else {
        Recording::open(path)?
    };
    ensure!(
        !recording.cycles.is_empty(),
        "{} holds no cycle; record again",
        path.display()
    );
    Ok(Read {
        notes: recording.notes().collect(),
        recording,
        unseen: None,
        model: None,
    })
}
