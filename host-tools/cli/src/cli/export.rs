//! `softdock export`: a recording as CSV.

use super::print_json;
use anyhow::{Result, ensure};
use clap::Args;
use serde::Serialize;
use softdock_analysis::input::refuse_overwrite_of;
use softdock_analysis::recording::{Recording, export_csv};
use std::path::{Path, PathBuf};

/// Write a recording as CSV with a JSON sidecar that names columns, units and settings.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock export run.mcap -o run.csv")]
pub(super) struct Export {
    /// Recording (MCAP)
    recording: PathBuf,
    /// File to write (CSV); the sidecar stands beside it
    #[arg(short, long, value_name = "RUN.csv")]
    output: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Written<'a> {
    files: [&'a Path; 2],
    cycles: usize,
}

impl Export {
    pub(super) fn execute(self) -> Result<()> {
        let recording = Recording::open(&self.recording)?;
        if let Some(cut) = &recording.cut {
            eprintln!("note: {cut}");
        }
        ensure!(
            !recording.cycles.is_empty(),
            "the recording holds no whole cycle; nothing is written"
        );
        let sidecar = self.output.with_extension("json");
        ensure!(
            self.output != sidecar,
            "{} is the name of the sidecar; give the table another one, such as {}",
            sidecar.display(),
            self.output.with_extension("csv").display()
        );
        refuse_overwrite_of(&[&self.recording], &self.output, self.force)?;
        refuse_overwrite_of(&[&self.recording], &sidecar, self.force)?;
        export_csv(&recording, &self.output)?;
        let written = Written {
            files: [&self.output, &sidecar],
            cycles: recording.cycles.len(),
        };
        if self.json {
            print_json(&written)
        } else {
            Ok(())
        }
    }
}
