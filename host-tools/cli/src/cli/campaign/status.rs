//! `softdock campaign status`.

use crate::cli::answer;
use anyhow::Result;
use clap::Args;
use softdock_experiments::campaign::place::Place;
use softdock_experiments::campaign::plan::Plan;
use softdock_experiments::campaign::status::{Progress, progress};
use softdock_io::shell::quoted;
use std::path::PathBuf;

/// Say how far a campaign is, and which shards are missing.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock campaign status campaign --json")]
pub(super) struct Status {
    /// Folder of the campaign, or its address in an object store (`file:///..`, `s3://..`)
    campaign: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Status {
    pub(super) fn execute(self) -> Result<()> {
        let place = Place::open(&self.campaign)?;
        let plan = Plan::read(&place)?;
        let progress = progress(&plan, &place)?;
        let Progress {
            rows,
            done,
            failed,
            kept,
            shards,
            missing_shards,
            ..
        } = &progress;
        let place = quoted(place);
        let next = match missing_shards.as_slice() {
            [] => format!("Next: softdock campaign merge {place} -o results.parquet"),
            [first, ..] => {
                let missing: Vec<String> = missing_shards.iter().map(u64::to_string).collect();
                format!(
                    "Shards of {shards} that lack rows: {}\nNext: softdock campaign run {place} --shard {first}/{shards}",
                    missing.join(", ")
                )
            }
        };
        let kept = match kept {
            0 => String::new(),
            kept => format!("; {kept} more are kept by shards that were interrupted or still run"),
        };
        answer(self.json, &progress, || {
            format!("{done} of {rows} rows done, {failed} of them failed{kept}\n{next}\n")
        })
    }
}
