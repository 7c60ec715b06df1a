//! A run on the simulated rig, into a new recording of the folder.

use super::job::Job;
use super::simulation::Simulation;
use crate::problem::Problem;
use crate::state::Shared;
use anyhow::{Result, ensure};
use serde_json::Value;
use serde_json::json;
use std::path::PathBuf;

/// A run and its files.
pub(super) struct Run {
    bench: Shared,
    simulation: Simulation,
}

impl Run {
    /// # Errors
    ///
    /// An id names no file, or the recording to write exists.
    pub(super) fn new(bench: &Shared, wish: Simulation) -> Result<Self, Problem> {
        let toml = |id: &PathBuf| bench.folder.file(&id.to_string_lossy(), "toml");
        let simulation = Simulation {
            scenario: toml(&wish.scenario)?,
            settings: wish.settings.as_ref().map(toml).transpose()?,
            output: bench
                .folder
                .new_file(&wish.output.to_string_lossy(), "mcap")?,
            ..wish
        };
        Ok(Self {
            bench: bench.clone(),
            simulation,
        })
    }

    /// Runs the simulation; a cancelled run leaves no recording.
    pub(super) fn run(self, job: &Job) -> Result<Value> {
        let going_on = |share: f64| {
            // Not by unwinding, which would leave the recording.
            job.tell_if_wanted("stage", json!({"share": share, "what": "simulating"}))
        };
        let root = self.bench.folder.prefix();
        let ran = (self.bench.simulator)(&self.simulation, &going_on);
        let mut said = ran.map_err(|why| anyhow::anyhow!(format!("{why:#}").replace(&root, "")))?;
        ensure!(!job.is_cancelled(), "ended on request");
        without(&mut said, &root);
        Ok(said)
    }
}

/// Removes a text from all strings of a value.
fn without(value: &mut Value, text: &str) {
    match value {
        Value::String(own) => *own = own.replace(text, ""),
        Value::Array(all) => all.iter_mut().for_each(|one| without(one, text)),
        Value::Object(all) => all.values_mut().for_each(|one| without(one, text)),
        Value::Null | Value::Bool(_) | Value::Number(_) => {}
    }
}
