//! `softdock remove`: an effect out of the model file again.

use super::answer;
use anyhow::Result;
use clap::Args;
use serde::Serialize;
use softdock_physics::model::edit::ModelFile;
use std::path::PathBuf;

/// Take an effect out of the model file.
///
/// Everything else in the file stays as it is, its history included.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock remove model.toml guide_coulomb")]
pub(super) struct Remove {
    /// Model file (TOML)
    model: PathBuf,
    /// Effect to remove
    effect: String,
    /// Print the difference to the model file and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Document<'a> {
    effect: &'a str,
    written: bool,
    difference: &'a str,
}

impl Remove {
    pub(super) fn execute(self) -> Result<()> {
        let file = ModelFile::open(&self.model)?;
        let edited = file.without_effect(&self.effect)?;
        let difference = edited.difference();
        if !self.dry_run {
            edited.save()?;
        }
        let document = Document {
            effect: &self.effect,
            written: !self.dry_run,
            difference: &difference,
        };
        answer(self.json, &document, || match self.dry_run {
            true => difference.clone(),
            false => format!(
                "Removed from {}: {}. `softdock diagnose` says what is missing now.\n",
                self.model.display(),
                self.effect
            ),
        })
    }
}
