//! Logs of other rigs as recordings: a docking-rig-log/1 folder, or any table through a mapping
//! file that says what its columns are.

pub mod checks;
pub mod docking_rig_log;
pub mod mapping;
pub mod model_text;
pub mod starter;
pub mod summary;
pub mod table;
pub mod table_error;
mod turns;

use softdock_io::recording::Recording;
use softdock_physics::model::Model;

/// A model and the two logs to fit it on and to test it on.
#[derive(Clone, Debug)]
pub struct ImportedLogs {
    /// Nominal model.
    pub model: Model,
    /// Log to fit on.
    pub train: Recording,
    /// Log that the fit must not see.
    pub test: Recording,
    /// What the user should know; sentences that name the file.
    pub warnings: Vec<String>,
}
