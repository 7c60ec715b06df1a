//! `softdock campaign merge`.

use crate::cli::answer;
use crate::cli::outputs::html_file;
use anyhow::{Result, ensure};
use clap::Args;
use serde::Serialize;
use softdock_experiments::campaign::carry_out::{failed, own_files};
use softdock_experiments::campaign::merge::merge;
use softdock_experiments::campaign::page;
use softdock_experiments::campaign::place::Place;
use softdock_experiments::campaign::plan::Plan;
use softdock_experiments::campaign::results::Results;
use softdock_experiments::campaign::summary::{Summary, summary};
use softdock_io::input::refuse_overwrite_of;
use softdock_io::output::write_whole;
use std::path::PathBuf;

/// Merge all parts of a campaign into one table, and say what it found.
///
/// Success with its interval, quantiles with bounds, which factor matters, and the worst rows. The table does not depend on shards, machines or interruptions: the same plan and program give the same file.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: softdock campaign merge campaign -o results.parquet --csv --report results.html"
)]
pub(super) struct Merge {
    /// Folder of the campaign, or its address in an object store (`file:///..`, `s3://..`)
    campaign: PathBuf,
    /// Table to write (Parquet)
    #[arg(short, long, value_name = "FILE.parquet")]
    output: PathBuf,
    /// Write the same table as CSV beside it, with units and meanings in a JSON file
    #[arg(long)]
    csv: bool,
    /// Write what was found as a page (HTML)
    #[arg(long, value_name = "FILE.html", value_parser = html_file)]
    report: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Merged {
    files: Vec<String>,
    rows: u64,
    failed: u64,
    summary: Summary,
}

impl Merged {
    fn text(&self) -> String {
        let tables = page::tables(&self.summary).into_iter();
        let tables: String = tables
            .map(|(title, table)| format!("{title}\n\n{table}\n"))
            .collect();
        let (headline, files) = (page::headline(&self.summary), self.files.join(", "));
        format!("{headline}\n\n{tables}{files}\n")
    }
}

impl Merge {
    pub(super) fn execute(self) -> Result<()> {
        let parquet = self
            .output
            .extension()
            .is_some_and(|ending| ending == "parquet");
        ensure!(
            parquet,
            "{}: the table is Parquet; --csv writes it as CSV too",
            self.output.display()
        );
        let csv = self.csv.then(|| self.output.with_extension("csv"));
        let description = csv.as_ref().map(|csv| csv.with_extension("json"));
        let tables: Vec<PathBuf> = [self.output].into_iter().chain(csv).collect();
        let place = Place::open(&self.campaign)?;
        let plan = Plan::read(&place)?;
        let own = own_files(&place)?;
        for file in tables.iter().chain(&description).chain(&self.report) {
            refuse_overwrite_of(&own, file, self.force)?;
        }
        let table = merge(&plan, &place)?;
        for file in &tables {
            table.write(file)?;
        }
        let results = Results {
            plan: &plan,
            table: &table,
        };
        let summary = summary(&results, &place)?;
        if let Some(report) = &self.report {
            let page = page::page(&results, &summary)?;
            write_whole(report, page.to_html())?;
        }
        let files = tables.iter().chain(&description).chain(&self.report);
        let merged = Merged {
            files: files.map(|file| file.display().to_string()).collect(),
            rows: plan.rows(),
            failed: failed(&table)?,
            summary,
        };
        answer(self.json, &merged, || merged.text())
    }
}
