//! `softdock replay`: recompute a recording.

use super::answer;
use anyhow::{Context, Result, bail};
use clap::Args;
use softdock_io::recording::Recording;
use softdock_io::replay::{Replay as Recomputation, ReplayReport};
use softdock_io::say;
use softdock_io::telemetry::sort_series;
use std::path::PathBuf;

/// Recompute every correction of a recording and compare it bit for bit.
///
/// Ends with 0 if all cycles are identical; else it names the first cycle and quantity that
/// differ. A run that was recorded into several files is given whole, as run*.mcap.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock replay run.mcap run-2.mcap")]
pub(super) struct Replay {
    /// Recordings (MCAP)
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Replay {
    pub(super) fn execute(self) -> Result<()> {
        let report = self.recompute()?;
        answer(self.json, &report, || format!("{report}\n"))?;
        if !report.identical {
            bail!("the replay differs from the recording");
        }
        Ok(())
    }

    /// Recomputes one file after the other in memory, up to the first difference.
    fn recompute(&self) -> Result<ReplayReport> {
        let mut recomputation = Recomputation::default();
        let mut report = None;
        let mut recordings = self.recordings.clone();
        sort_series(&mut recordings);
        for path in &recordings {
            let recording = Recording::open(path)?;
            for note in recording.notes() {
                say!("note: {note}");
            }
            let found = recomputation.take(&recording);
            let found = found.with_context(|| path.display().to_string())?;
            let identical = found.identical;
            report = Some(found);
            if !identical {
                break;
            }
        }
        report.context("expected at least one recording")
    }
}
