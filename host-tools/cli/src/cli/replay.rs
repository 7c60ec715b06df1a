//! `softdock replay`: recompute a recording.

use super::{print, print_json};
use anyhow::{Result, bail};
use clap::Args;
use softdock_analysis::recording::Recording;
use softdock_analysis::replay::replay;
use std::path::PathBuf;

/// Recompute every correction of a recording and compare it bit for bit.
///
/// Ends with 0 if all cycles are identical; else it names the first cycle and quantity that
/// differ.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock replay run.mcap")]
pub(super) struct Replay {
    /// Recording (MCAP)
    recording: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Replay {
    pub(super) fn execute(self) -> Result<()> {
        let recording = Recording::open(&self.recording)?;
        if let Some(cut) = &recording.cut {
            eprintln!("note: {cut}");
        }
        let report = replay(&recording)?;
        if self.json {
            print_json(&report)?;
        } else {
            print(&format!("{report}\n"))?;
        }
        if !report.identical {
            bail!("the replay differs from the recording");
        }
        Ok(())
    }
}
