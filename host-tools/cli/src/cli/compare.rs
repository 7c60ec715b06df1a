//! `softdock compare`: model against recording.

use super::outputs::html_file;
use super::{print, print_json};
use anyhow::{Result, ensure};
use clap::Args;
use serde::Serialize;
use softdock_analysis::compare::{Comparison, SeriesFile, compare};
use softdock_io::data_table::Values;
use softdock_io::input::refuse_overwrite_of;
use softdock_io::output::write_whole;
use softdock_io::recording::Recording;
use softdock_io::say;
use softdock_physics::model::Model;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Compare a model with a recording: how large is the error, in which channel, and where.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock compare model.toml run.mcap --report compare.html
         softdock compare model.toml test1.mcap test2.mcap

softdock compare model.toml run.mcap --series series.parquet
(time, measured, predicted, residual and sigma of each channel and axis as numbers)")]
pub(super) struct Compare {
    /// Model file (TOML)
    model: PathBuf,
    /// Recordings (MCAP), each compared by itself; --report, --series and --json take one
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// Report to write (one HTML page)
    #[arg(long, value_name = "FILE.html", value_parser = html_file)]
    report: Option<PathBuf>,
    /// Measured, predicted, residual and sigma of each channel and axis to write: CSV, Parquet or MCAP by the ending;
    /// MCAP holds the recording too
    #[arg(long, value_name = "FILE.csv|.parquet|.mcap")]
    series: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Output<'a> {
    #[serde(flatten)]
    comparison: &'a Comparison,
    #[serde(skip_serializing_if = "Option::is_none")]
    series: Option<SeriesFile>,
    /// Values of each column by its name; only for a short recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    curves: Option<BTreeMap<String, Values>>,
}

/// Longest recording (rows) whose curves `--json` contains: 1 s at 4 ms. Those of a longer one go into a file of their own.
const SHORT: usize = 250;

fn curves(comparison: &Comparison) -> Option<BTreeMap<String, Values>> {
    let table = comparison.series_table();
    let columns = table
        .columns
        .iter()
        .map(|c| (c.name.clone(), c.values.clone()));
    (table.rows() <= SHORT).then(|| columns.collect())
}

impl Compare {
    fn refuse_overwrite(&self, output: &Path) -> Result<()> {
        let mut inputs = vec![self.model.as_path()];
        inputs.extend(self.recordings.iter().map(PathBuf::as_path));
        refuse_overwrite_of(&inputs, output, self.force)
    }

    pub(super) fn execute(self) -> Result<()> {
        let several = self.recordings.len() > 1;
        ensure!(
            !several || !(self.json || self.report.is_some() || self.series.is_some()),
            "--report, --series and --json expect one recording, received {}; call compare for each",
            self.recordings.len()
        );
        let model = Model::load(&self.model)?;
        for path in &self.recordings {
            if several {
                print(&format!("== {}\n", path.display()))?;
            }
            self.compared(&model, path)?;
        }
        Ok(())
    }

    fn compared(&self, model: &Model, path: &Path) -> Result<()> {
        let recording = Recording::open(path)?;
        for note in recording.notes() {
            say!("note: {note}");
        }
        let comparison = compare(model, &recording)?;
        if let Some(path) = &self.report {
            self.refuse_overwrite(path)?;
            let page = crate::pages::comparison::page(&comparison)?;
            write_whole(path, page.to_html())?;
            say!("report: {}", path.display());
        }
        let series = self.series.as_deref().map(|path| {
            self.refuse_overwrite(path)?;
            comparison.write_series(&recording, path)
        });
        let series = series.transpose()?;
        if let Some(series) = &series {
            say!("series: {}", series.file);
        }
        if self.json {
            return print_json(&Output {
                comparison: &comparison,
                series,
                curves: curves(&comparison),
            });
        }
        let tables: Vec<String> = comparison
            .tables()
            .iter()
            .map(ToString::to_string)
            .collect();
        let forward = comparison.free_simulation.map(|free| free.words() + "\n\n");
        print(&format!(
            "{}\n\n{}{}\n",
            comparison.sentence,
            forward.unwrap_or_default(),
            tables.join("\n\n")
        ))
    }
}
