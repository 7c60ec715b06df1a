//! `softdock campaign rerun`.

use crate::cli::answer;
use crate::cli::outputs::mcap_file;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use serde::Serialize;
use softdock_experiments::campaign::carry_out::own_files;
use softdock_experiments::campaign::outcome::{Observer, Outcome};
use softdock_experiments::campaign::place::Place;
use softdock_experiments::campaign::plan::{Conditions, Plan};
use softdock_experiments::campaign::stored::{StoredRow, value};
use softdock_experiments::campaign::table;
use softdock_experiments::record_file::record_file;
use softdock_io::data_table::DataTable;
use softdock_io::input::refuse_overwrite_of;
use softdock_io::telemetry::{Bounds, FileSeries, Time};
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Run one row of a campaign again, record every cycle, and hold it against the row that is stored.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock campaign rerun campaign --index 4711 -o case.mcap")]
pub(super) struct Rerun {
    /// Folder of the campaign, or its address in an object store (`file:///..`, `s3://..`)
    campaign: PathBuf,
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
        let place = Place::open(&self.campaign)?;
        let plan = Plan::read_to_run(&place)?;
        let rows = plan.rows();
        ensure!(
            self.index < rows,
            "there is no row {}; the last is {}",
            self.index,
            rows - 1
        );
        refuse_overwrite_of(&own_files(&place)?, &self.output, self.force)?;
        if let Some(bench) = plan.campaign.bench {
            let Conditions { seed, values } = plan.conditions(self.index);
            bail!(
                "a row of a benchmark has no recording; `{}` shows it",
                bench.command(seed, &values)
            );
        }
        let outcome = self.recorded(&plan)?;
        let success = table::is_success(&plan, &outcome);
        let row = table::table(&plan, &[(self.index, outcome.clone())]);
        let stored = StoredRow::find(&plan, &place, self.index)?;
        let recording = self.output.display().to_string();
        if let Some(stored) = &stored
            && let Some(difference) = stored.difference(&row)?
        {
            bail!(
                "row {} differs from the one in {} of {place}: {difference}\n\
                 The same program gives the same bits on every machine: one of the two is damaged, or this is a defect of softdock. The new run is in {recording}.",
                self.index,
                stored.place
            );
        }
        let factors = plan.factors.iter().map(|factor| factor.name.clone());
        let summary = RerunSummary {
            index: self.index,
            recording: &recording,
            success,
            same_as: stored.map(|stored| stored.place),
            conditions: factors.zip(plan.conditions(self.index).values).collect(),
            outcome: &outcome,
        };
        answer(self.json, &summary, || summary.text(&row))
    }

    /// Runs the row and records every cycle.
    fn recorded(&self, plan: &Plan) -> Result<Outcome> {
        let scenario = plan
            .scenario(self.index)
            .context("the row has no recording: its settings are refused")?;
        let mut observer = Observer::new(&scenario);
        let mut series = FileSeries::new(&self.output, Bounds::default(), Time::Virtual);
        let ran = record_file(&scenario, &mut series, &mut |record, truth| {
            observer.push(record, truth);
            ControlFlow::Continue(())
        })?;
        Ok(observer.finish(&ran))
    }
}

#[derive(Serialize)]
struct RerunSummary<'a> {
    index: u64,
    recording: &'a str,
    success: bool,
    /// Location of the stored row that is identical bit for bit; None if the row was not computed before.
    same_as: Option<String>,
    conditions: serde_json::Map<String, serde_json::Value>,
    outcome: &'a Outcome,
}

impl RerunSummary<'_> {
    /// All columns of the row, as text.
    fn text(&self, row: &DataTable) -> String {
        let same = match &self.same_as {
            Some(place) => format!("bit for bit the row in {place}"),
            None => "not carried out before, so there is no row to compare it with".to_owned(),
        };
        let columns = row.columns.iter().map(|column| {
            let unit = column.unit.replace('1', "");
            match value(&column.values, 0) {
                Some(value) => format!("  {} = {value} {unit}", column.name),
                None => format!("  {} = none", column.name),
            }
        });
        let lines = columns.map(|line| format!("{}\n", line.trim_end()));
        format!("{}: {same}\n{}", self.recording, lines.collect::<String>())
    }
}
