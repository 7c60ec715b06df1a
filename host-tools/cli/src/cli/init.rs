//! `softdock init`: files to start from.

use super::print;
use anyhow::{Context, Result, ensure};
use clap::Args;
use softdock_experiments::starter;
use softdock_io::input::refuse_overwrite;
use softdock_io::output::write_whole;
use softdock_io::say;
use softdock_io::shell::quoted;
use std::path::PathBuf;

/// Write a scenario, a board, a rig and a model to start from.
///
/// A probe between two springs, on which a diagnosis can tell one effect from another. The other
/// commands take the files as they are; change them to what your laboratory has. Nothing is
/// overwritten.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock init laboratory")]
pub(super) struct Init {
    /// Folder for the files; made if missing
    #[arg(value_name = "DIR", default_value = ".")]
    folder: PathBuf,
}

impl Init {
    pub(super) fn execute(self) -> Result<()> {
        let files = starter::files()?;
        for (name, _) in &files {
            let path = self.folder.join(name);
            // There is no --force: people edit these files by hand.
            ensure!(
                refuse_overwrite(&path, false).is_ok(),
                "{} exists already, nothing was written: choose another folder, as in `softdock init laboratory`",
                path.display()
            );
        }
        std::fs::create_dir_all(&self.folder)
            .with_context(|| format!("cannot make the folder {}", self.folder.display()))?;
        for (name, text) in &files {
            let path = self.folder.join(name);
            write_whole(&path, text)?;
            say!("{} written", path.display());
        }
        let enter = if self.folder.as_os_str() == "." {
            String::new()
        } else {
            format!("  cd {}\n", quoted(self.folder.display()))
        };
        print(&format!(
            "Next:\n{enter}  softdock check board.toml rig.toml\n  softdock run scenario.toml -o run.mcap\n  \
             softdock compare model.toml run.mcap --report compare.html\n"
        ))
    }
}
