//! `softdock workbench`: recordings and models of a folder in the browser.

use super::print;
use super::run::Run;
use anyhow::Result;
use clap::Args;
use serde_json::Value;
use softdock_io::say;
use softdock_workbench::{AccessToken, Reach, Server, Simulation};
use std::net::IpAddr;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Look at recordings and models in the browser: compare, diagnose, try effects, add them, undo.
///
/// Prints the address of the page, and answers until Ctrl-C. Only this computer can reach it, unless --listen says
/// otherwise. It writes the model file when told to, and recordings of runs that it is told to make; nothing else.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock workbench runs --open

softdock workbench runs --listen 192.168.1.5 --port 8080 --token $(openssl rand -hex 16)
(for other computers; the address that it prints carries the token)")]
pub(super) struct Workbench {
    /// Folder with recordings (MCAP) and models (TOML)
    #[arg(default_value = ".")]
    folder: PathBuf,
    /// Port to listen on; 0 is a free one
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// Address on which other computers reach it; 0.0.0.0 is every address of this one
    #[arg(long, value_name = "ADDR", requires = "token")]
    listen: Option<IpAddr>,
    /// What those who ask at --listen have to know: at least 16 letters and digits
    #[arg(long, requires = "listen")]
    token: Option<AccessToken>,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
}

impl Workbench {
    pub(super) fn execute(self) -> Result<()> {
        let reach = match self.listen.zip(self.token) {
            Some((address, token)) => Reach::Network(address, token),
            None => Reach::ThisComputer,
        };
        if let Reach::Network(address, _) = &reach {
            say!(
                "warning: whoever reaches {address} and knows the token reads the recordings and models of this \
                 folder and changes its models; the line is not encrypted"
            );
        }
        let server = Server::new(&self.folder, self.port, reach, Box::new(simulate))?;
        let url = server.url();
        print(&format!("{url}\n"))?;
        if self.listen.is_some_and(|address| address.is_unspecified()) {
            say!("note: on another computer, the name or address of this one stands in its place");
        }
        if self.open && open::that_detached(&url).is_err() {
            say!("note: no browser was found; open the address yourself");
        }
        server.serve()
    }
}

/// Carries out a run that a page asks for.
fn simulate(wanted: &Simulation, goes_on: &dyn Fn(f64) -> ControlFlow<()>) -> Result<Value> {
    Ok(serde_json::to_value(Run::of(wanted)?.carry_out(goes_on)?)?)
}
