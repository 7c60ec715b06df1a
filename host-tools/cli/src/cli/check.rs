//! `softdock check`: what a delay will do to a contact, before the contact.

use super::answer;
use anyhow::{Result, ensure};
use clap::Args;
use softdock_experiments::check::{Rig, check, load_board};
use std::path::PathBuf;

/// Say before the contact whether it will be stable, which rebound each delay law will give, what
/// is beyond physics, and what to change.
///
/// Ends with an error if the law that the settings choose is not stable.
/// The contact is taken as one mass on one wall. Linear theory gives the critical delay, stiffness,
/// mass and damping without compensation; each law is computed with the board's own cycle.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock check board.toml rig.toml

SETTINGS and RIG may also be one scenario:
         softdock check scenario.toml scenario.toml")]
pub(super) struct CheckCommand {
    /// Settings of the board (TOML), or a scenario, whose board is taken
    settings: PathBuf,
    /// The rig, true or assumed (TOML), or a scenario, whose robot and first wall are taken
    rig: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl CheckCommand {
    pub(super) fn execute(self) -> Result<()> {
        let board = load_board(&self.settings)?;
        let rig = Rig::load(&self.rig, &board)?;
        let found = check(&board, &rig)?;
        answer(self.json, &found, || found.to_string())?;
        let stable = found.chosen().is_some_and(|law| law.stable);
        ensure!(
            stable,
            "law `{}` is not stable on this contact: do not close the loop with it",
            found.chosen_law
        );
        Ok(())
    }
}
