//! What is asked of a simulated rig. Whoever serves the workbench brings the rig.

use anyhow::Result;
use serde::Deserialize;
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// A run, as `softdock run` takes it. What is not said is the scenario's. A page names files by their ids.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Simulation {
    /// Scenario file (TOML).
    pub scenario: PathBuf,
    /// Settings of the board (TOML).
    pub settings: Option<PathBuf>,
    /// Recording to write (MCAP); there is none yet.
    pub output: PathBuf,
    /// The robot rests where the scenario starts.
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

/// Carries a run out, asks after each share of it whether it is to go on, and says what `softdock run --json` prints.
pub type Simulator =
    dyn Fn(&Simulation, &dyn Fn(f64) -> ControlFlow<()>) -> Result<Value> + Send + Sync;
