//! `softdock completions` and `softdock man`: shell completions and manual pages of the commands.

use super::{Cli, print};
use anyhow::{Context, Result};
use clap::{Args, Command, CommandFactory};
use clap_complete::{Shell, generate};
use softdock_io::output::write_whole;
use std::path::{Path, PathBuf};

/// Print completions for a shell.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: softdock completions bash > ~/.local/share/bash-completion/completions/softdock"
)]
pub(super) struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    pub(super) fn execute(self) -> Result<()> {
        let mut script = Vec::new();
        generate(self.shell, &mut Cli::command(), "softdock", &mut script);
        print(&String::from_utf8(script)?)
    }
}

/// Write the manual pages, one for each command.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock man -o ~/.local/share/man/man1")]
pub(super) struct Man {
    /// Folder for the pages; made if missing. Pages of another version are replaced
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

impl Man {
    pub(super) fn execute(self) -> Result<()> {
        std::fs::create_dir_all(&self.output)
            .with_context(|| format!("cannot make the folder {}", self.output.display()))?;
        let mut command = Cli::command();
        command.build();
        write(&command, "softdock", &self.output)
    }
}

/// Writes the page of a command and, recursively, those of its subcommands.
fn write(command: &Command, name: &str, folder: &Path) -> Result<()> {
    let path = folder.join(format!("{name}.1"));
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone())
        .title(name)
        .render(&mut page)?;
    write_whole(&path, page)?;
    let below = command.get_subcommands().filter(|c| c.get_name() != "help");
    below
        .into_iter()
        .try_for_each(|below| write(below, &format!("{name}-{}", below.get_name()), folder))
}
