//! `softdock workbench`: recordings and models of a folder in the browser.

use super::print;
use anyhow::Result;
use clap::Args;
use softdock_workbench::Server;
use std::path::PathBuf;

/// Look at recordings and models in the browser: compare, diagnose, try effects, add them, undo.
///
/// Prints the address of the page, and answers until Ctrl-C. Only this computer can reach it. It
/// writes nothing but the model file, and that only when told to.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock workbench runs --open")]
pub(super) struct Workbench {
    /// Folder with recordings (MCAP) and models (TOML)
    #[arg(default_value = ".")]
    folder: PathBuf,
    /// Port to listen on; 0 is a free one
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
}

impl Workbench {
    pub(super) fn execute(self) -> Result<()> {
        let server = Server::new(&self.folder, self.port)?;
        let url = server.url();
        print(&format!("{url}\n"))?;
        if self.open && open::that_detached(&url).is_err() {
            eprintln!("note: no browser was found; open the address yourself");
        }
        server.serve()
    }
}
