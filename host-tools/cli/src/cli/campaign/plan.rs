//! `softdock campaign plan`.

use crate::cli::answer;
use anyhow::{Result, ensure};
use clap::Args;
use serde::Serialize;
use softdock_experiments::campaign::place::Place;
use softdock_experiments::campaign::{plan, setting};
use softdock_io::shell::quoted;
use softdock_report::{Cell, Column, Table};
use std::path::PathBuf;

/// Check a campaign file and write the plan that every run of it follows.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: softdock campaign plan examples/campaign/spring-rod.toml -o campaign"
)]
pub(super) struct Plan {
    /// Campaign file (TOML)
    campaign: PathBuf,
    /// Folder of the campaign, or its address in an object store (`file:///..`, `s3://..`)
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Planned<'a> {
    rows: u64,
    hash: &'a str,
    binary: &'a str,
    combinations: u64,
    factors: Vec<Factor<'a>>,
}

#[derive(Serialize)]
struct Factor<'a> {
    name: &'a str,
    settings: &'a [String],
    unit: &'a str,
    distribution: String,
}

impl Plan {
    pub(super) fn execute(self) -> Result<()> {
        let plan = plan::Plan::new(&self.campaign)?;
        // There is no --force: the folder may hold rows that took days.
        let place = Place::open(&self.output)?;
        ensure!(
            !place.is_taken()?,
            "{place} exists already, nothing was written: give another folder with -o, or remove this one first if nobody needs what is in it. \
             (`softdock campaign run {}` goes on with a campaign that was planned there.)",
            quoted(&place)
        );
        plan.write(&place)?;
        let factor = |factor: &'_ plan::PlannedFactor| factor.distribution.text();
        let factors = plan.factors.iter().map(|planned| Factor {
            name: &planned.name,
            settings: &planned.settings,
            unit: setting::unit(&planned.settings[0]),
            distribution: factor(planned),
        });
        let planned = Planned {
            rows: plan.rows(),
            hash: &plan.hash,
            binary: &plan.binary,
            combinations: plan.combinations(),
            factors: factors.collect(),
        };
        let mut table = Table::new(
            ["factor", "unit", "values", "setting"]
                .map(Column::text)
                .into(),
        );
        for factor in &planned.factors {
            let cells = [
                factor.name,
                factor.unit,
                &factor.distribution,
                &factor.settings.join(", "),
            ];
            table.push(cells.map(Cell::text).into());
        }
        answer(self.json, &planned, || {
            let (rows, hash, place) = (planned.rows, planned.hash, quoted(&place));
            format!("{table}\n{rows} rows, plan {hash}\nNext: softdock campaign run {place}\n")
        })
    }
}
