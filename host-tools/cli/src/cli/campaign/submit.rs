//! `softdock campaign hq` and `slurm`.

use crate::cli::print;
use anyhow::Result;
use clap::Args;
use softdock_experiments::campaign::place::Place;
use softdock_experiments::campaign::plan::Plan;
use softdock_experiments::campaign::submit;
use std::path::PathBuf;

/// What both ask for.
#[derive(Debug, Args)]
struct Division {
    /// Folder of the campaign, where all machines see it, or its address in an object store (`s3://..`)
    campaign: PathBuf,
    /// Into how many tasks the rows are divided
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    shards: u64,
    /// Processors of a task
    #[arg(long, value_name = "T", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: u64,
}

impl Division {
    fn print(&self, line: fn(&Place, u64, usize) -> Result<String>) -> Result<()> {
        let place = Place::open(&self.campaign)?;
        Plan::read_to_run(&place)?;
        print(&format!(
            "{}\n",
            line(&place, self.shards, self.threads as usize)?
        ))
    }
}

/// Print the line that hands a campaign to HyperQueue. Nothing is submitted.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock campaign hq campaign --shards 40")]
pub(super) struct HyperQueue {
    #[command(flatten)]
    division: Division,
}

impl HyperQueue {
    pub(super) fn execute(self) -> Result<()> {
        self.division.print(submit::hyperqueue)
    }
}

/// Print the line that hands a campaign to Slurm. Nothing is submitted.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock campaign slurm campaign --shards 40 --threads 4")]
pub(super) struct Slurm {
    #[command(flatten)]
    division: Division,
}

impl Slurm {
    pub(super) fn execute(self) -> Result<()> {
        self.division.print(submit::slurm)
    }
}
