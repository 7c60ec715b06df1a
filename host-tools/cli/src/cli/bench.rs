//! `softdock bench`: how good the program is, measured.

mod delay;
mod diagnose;

use anyhow::Result;
use clap::{Args, Subcommand};

/// Measure how good the program is at its work.
#[derive(Debug, Args)]
pub(super) struct Bench {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Delay(delay::Delay),
    Diagnose(diagnose::Diagnose),
}

impl Bench {
    pub(super) fn execute(self) -> Result<()> {
        match self.what {
            What::Delay(command) => command.execute(),
            What::Diagnose(command) => command.execute(),
        }
    }
}
