//! The recordings that a fit works with.

use anyhow::Result;
use softdock_analysis::fit::Logs;
use softdock_io::say;
use softdock_physics::model::Model;
use std::path::PathBuf;

/// Reads and checks the recordings; warnings go to standard error.
pub(super) fn open(model: &Model, train: &[PathBuf], test: &[PathBuf]) -> Result<Logs> {
    let logs = Logs::open(model, train, test)?;
    for note in &logs.notes {
        say!("warning: {note}");
    }
    Ok(logs)
}
