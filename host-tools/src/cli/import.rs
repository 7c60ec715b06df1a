//! `softdock import`: CSV back into a recording.

use super::print_json;
use crate::input::refuse_overwrite;
use crate::recording::import_csv;
use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Read a CSV with its JSON sidecar, as `export` writes them, back into a recording.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock import run.csv -o imported\n(writes imported/run.mcap)")]
pub(super) struct Import {
    /// CSV file; its sidecar stands beside it
    path: PathBuf,
    /// Folder to write into
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Overwrite an existing recording
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Written<'a> {
    files: [&'a Path; 1],
    cycles: usize,
}

impl Import {
    pub(super) fn execute(self) -> Result<()> {
        let recording = import_csv(&self.path)?;
        let name = self.path.file_stem().context("the CSV file has no name")?;
        let output = self.output.join(name).with_extension("mcap");
        refuse_overwrite(&output, self.force)?;
        std::fs::create_dir_all(&self.output)
            .with_context(|| format!("cannot create {}", self.output.display()))?;
        recording.write(&output)?;
        let written = Written {
            files: [&output],
            cycles: recording.cycles.len(),
        };
        if self.json {
            print_json(&written)
        } else {
            Ok(())
        }
    }
}
