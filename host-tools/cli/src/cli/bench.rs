//! `softdock bench`: how good the program is, measured.

mod delay;
mod diagnose;

use anyhow::Result;
use clap::Args;

/// Measure how good the program is at its work.
#[derive(Debug, Args)]
pub(super) struct Bench {
    #[command(subcommand)]
    what: What,
}

commands!(What {
    Delay(delay::Delay),
    Diagnose(diagnose::Diagnose),
});

impl Bench {
    pub(super) fn execute(self) -> Result<()> {
        self.what.execute()
    }
}
