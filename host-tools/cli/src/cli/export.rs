//! `softdock export`: a recording for other programs.

use super::outputs::exported_file;
use super::print_json;
use anyhow::{Result, ensure};
use clap::Args;
use serde::Serialize;
use softdock_io::input::refuse_overwrite_of;
use softdock_io::recording::{Recording, export_csv};
use softdock_io::say;
use std::path::{Path, PathBuf};

/// Write a recording as CSV, or with the standard messages of ROS 2 for viewers.
///
/// CSV has a JSON sidecar that names columns, units and settings. With the ending .mcap the copy has, beside the
/// recording, transforms, markers and stamped messages, so that Foxglove, RViz and others draw the docking; time stamps
/// are of the wall clock where the recording knows it. `compare --series FILE.mcap` adds what a model predicts.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock export run.mcap -o run.csv

softdock export run.mcap -o view.mcap")]
pub(super) struct Export {
    /// Recording (MCAP)
    recording: PathBuf,
    /// File to write: CSV, or MCAP for viewers with the ending .mcap
    #[arg(short, long, value_name = "RUN.csv|.mcap", value_parser = exported_file)]
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
    files: Vec<&'a Path>,
    cycles: usize,
}

impl Export {
    pub(super) fn execute(self) -> Result<()> {
        let recording = Recording::open(&self.recording)?;
        for note in recording.notes() {
            say!("note: {note}");
        }
        ensure!(
            !recording.cycles.is_empty(),
            "the recording holds no whole cycle; nothing is written"
        );
        let is_mcap = self
            .output
            .extension()
            .is_some_and(|ending| ending == "mcap");
        let sidecar = self.output.with_extension("json");
        let mut files = vec![self.output.as_path()];
        if !is_mcap {
            files.push(&sidecar);
        }
        for file in &files {
            refuse_overwrite_of(&[&self.recording], file, self.force)?;
        }
        match is_mcap {
            true => recording.write_ros2(None, &self.output)?,
            false => export_csv(&recording, &self.output)?,
        }
        if self.json {
            let cycles = recording.cycles.len();
            return print_json(&Written { files, cycles });
        }
        Ok(())
    }
}
