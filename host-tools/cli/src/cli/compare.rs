//! `softdock compare`: model against recording.

use super::{print, print_json};
use anyhow::Result;
use clap::Args;
use softdock_analysis::compare::compare;
use softdock_analysis::input::refuse_overwrite;
use softdock_analysis::model::Model;
use softdock_analysis::recording::Recording;
use std::path::PathBuf;

/// Compare a model with a recording: how large is the error, in which channel, and where.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock compare model.toml run.mcap --report compare.html")]
pub(super) struct Compare {
    /// Model file (TOML)
    model: PathBuf,
    /// Recording (MCAP)
    recording: PathBuf,
    /// Report to write (one HTML page)
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Overwrite an existing report
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Compare {
    pub(super) fn execute(self) -> Result<()> {
        let model = Model::load(&self.model)?;
        let recording = Recording::open(&self.recording)?;
        if let Some(cut) = &recording.cut {
            eprintln!("note: {cut}");
        }
        let comparison = compare(&model, &recording)?;
        if let Some(path) = &self.report {
            refuse_overwrite(path, self.force)?;
            crate::pages::comparison::page(&comparison)?.write(path)?;
            eprintln!("report: {}", path.display());
        }
        if self.json {
            return print_json(&comparison);
        }
        let tables: Vec<String> = comparison
            .tables()
            .iter()
            .map(ToString::to_string)
            .collect();
        print(&format!(
            "{}\n\n{}\n",
            comparison.sentence,
            tables.join("\n\n")
        ))
    }
}
