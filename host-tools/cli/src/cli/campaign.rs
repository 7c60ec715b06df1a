//! `softdock campaign`: one scenario under thousands of conditions.

mod carry_out;
mod merge;
mod plan;
mod rerun;
mod status;
mod submit;

use anyhow::Result;
use clap::Args;

/// One scenario under thousands of conditions, on one machine or on many.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock campaign plan examples/campaign/spring-rod.toml -o campaign
         softdock campaign run campaign
         softdock campaign merge campaign -o results.parquet --report results.html

docs/campaigns.md describes the campaign file, the columns of the results, and clusters.")]
pub(super) struct Campaign {
    #[command(subcommand)]
    command: Command,
}

commands!(Command {
    Plan(plan::Plan),
    Run(carry_out::Run),
    Status(status::Status),
    Merge(merge::Merge),
    Rerun(rerun::Rerun),
    Hq(submit::HyperQueue),
    Slurm(submit::Slurm),
});

impl Campaign {
    pub(super) fn execute(self) -> Result<()> {
        self.command.execute()
    }
}
