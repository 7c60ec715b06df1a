//! Request for a run on the simulated rig, which the program that serves the workbench provides.

use anyhow::Result;
use serde::Deserialize;
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// A run, as for `softdock run`. Omitted values are those of the scenario. A page names files by their ids.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Simulation {
    /// Scenario file (TOML).
    pub scenario: PathBuf,
    /// Settings of the board (TOML).
    pub settings: Option<PathBuf>,
    /// Recording to write (MCAP), which must not exist.
    pub output: PathBuf,
    /// Whether the robot stays where the scenario starts.
    pub hold: bool,
    /// Length, s.
    pub duration_s: Option<f64>,
    /// Delay law.
    pub law: Option<String>,
    /// Initial speed of the moving spacecraft, mm/s.
    pub speed_mm_s: Option<f64>,
    /// Effects for the rig to hide.
    pub effect: Vec<String>,
    /// Seed of all random numbers.
    pub seed: Option<u64>,
}

/// Carries out a run. After each part of it the callback decides whether it goes on. Returns the document that `softdock run
/// --json` prints.
pub type Simulator =
    dyn Fn(&Simulation, &dyn Fn(f64) -> ControlFlow<()>) -> Result<Value> + Send + Sync;
