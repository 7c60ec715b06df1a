//! `softdock demo`: the main job on the simulated rig, in less than half a minute.

mod files;
mod story;

use anyhow::{Context, Result};
use clap::Args;
use files::Files;
use softdock_experiments::demo;
use std::path::PathBuf;
use story::Story;

/// Run a docking test on a rig that hides an effect, see where the model fails, find out what is
/// missing, add it, and watch the error fall.
///
/// Everything happens on the simulated rig: no hardware, no set-up, no network. Without --effect
/// the robot is later than the model says and stands still when it reverses.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock demo --effect guide_coulomb --seed 7 -o my-demo")]
pub(super) struct Demo {
    /// Effect for the rig to hide, in a size drawn from the seed; may be repeated (`softdock
    /// effects` lists them)
    #[arg(long, value_name = "ID")]
    effect: Vec<String>,
    /// Folder to write into; without it, the first free one of softdock-demo, softdock-demo-2 ...
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Seed of the simulated noise and of the effect's size
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Overwrite files of an earlier demonstration in the folder
    #[arg(long)]
    force: bool,
    /// Print one JSON document; the story goes to standard error
    #[arg(long)]
    json: bool,
}

impl Demo {
    pub(super) fn execute(self) -> Result<()> {
        let hidden = demo::hidden(&self.effect, self.seed)?;
        let folder = self.output.clone().unwrap_or_else(files::free_folder);
        let files = Files::in_folder(&folder);
        files.make_room(self.force)?;
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        let story = Story {
            hidden,
            seed: self.seed,
            quiet: self.json,
            files: &files,
        };
        story.tell()
    }
}
