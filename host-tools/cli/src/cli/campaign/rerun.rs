//! `softdock campaign rerun`.

use crate::cli::outputs::mcap_file;
use crate::cli::{print, print_json};
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use serde::Serialize;
use softdock_experiments::campaign::outcome::Observer;
use softdock_experiments::campaign::plan::{Conditions, Plan};
use softdock_experiments::campaign::shard::own_files;
use softdock_experiments::campaign::{row, table};
use softdock_experiments::record_file::record_file;
use softdock_io::input::refuse_overwrite_of;
use softdock_io::telemetry::{Bounds, Pieces, Time};
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Run one row of a campaign again, and record every cycle.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock campaign rerun campaign --index 4711 -o case.mcap")]
pub(super) struct Rerun {
    /// Folder of the campaign
    folder: PathBuf,
    /// Index of the row
    #[arg(long, value_name = "K")]
    index: u64,
    /// Recording to write (MCAP)
    #[arg(short, long, value_name = "RUN.mcap", value_parser = mcap_file)]
    output: PathBuf,
    /// Overwrite an existing recording
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Rerun {
    pub(super) fn execute(self) -> Result<()> {
        let plan = Plan::read_to_run(&self.folder)?;
        let rows = plan.rows();
        ensure!(
            self.index < rows,
            "there is no row {}; the last is {}",
            self.index,
            rows - 1
        );
        refuse_overwrite_of(&own_files(&self.folder)?, &self.output, self.force)?;
        if let Some(bench) = plan.campaign.bench {
            let Conditions { seed, values } = plan.conditions(self.index);
            bail!(
                "a row of a benchmark has no recording; `{}` shows it",
                bench.command(seed, &values)
            );
        }
        let scenario = plan
            .scenario(self.index)
            .context("the row has no recording: its settings are refused")?;
        let mut observer = Observer::new(&scenario);
        let mut pieces = Pieces::new(&self.output, Bounds::default(), Time::Virtual);
        let ran = record_file(&scenario, &mut pieces, &mut |record, truth| {
            observer.push(record, truth);
            ControlFlow::Continue(())
        })?;
        let outcome = observer.finish(&ran);
        ensure!(
            outcome == row::execute(&plan, self.index),
            "the recorded run differs from the row; this is a defect of softdock"
        );
        let recording = self.output.display().to_string();
        let again = Again {
            index: self.index,
            recording: &recording,
            success: table::is_success(&plan, &outcome),
            conditions: plan
                .factors
                .iter()
                .zip(plan.conditions(self.index).values)
                .map(|(factor, value)| (factor.name.clone(), value))
                .collect(),
            outcome: &outcome,
        };
        if self.json {
            return print_json(&again);
        }
        print(&again.text())
    }
}

#[derive(Serialize)]
struct Again<'a> {
    index: u64,
    recording: &'a str,
    success: bool,
    conditions: serde_json::Map<String, serde_json::Value>,
    outcome: &'a softdock_experiments::campaign::outcome::Outcome,
}

impl Again<'_> {
    fn text(&self) -> String {
        let conditions = self
            .conditions
            .iter()
            .map(|(name, value)| format!("  {name} = {value}\n"));
        let outcomes = softdock_experiments::campaign::outcome::NUMBERS
            .iter()
            .filter_map(|number| {
                Some(format!(
                    "  {} = {:.6}\n",
                    number.name,
                    (number.value)(self.outcome)?
                ))
            });
        format!(
            "{}: row {}, {}\n{}outcome\n{}",
            self.recording,
            self.index,
            if self.success {
                "a success"
            } else {
                "no success"
            },
            conditions.collect::<String>(),
            outcomes.collect::<String>(),
        )
    }
}
