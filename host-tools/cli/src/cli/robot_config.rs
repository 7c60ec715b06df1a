//! `softdock robot-config`: the robot's side of the configuration.

use super::{print, print_json};
use crate::robot_config::{ethernet_xml, notes};
use anyhow::{Result, ensure};
use clap::Args;
use serde::Serialize;
use softdock_app::settings::BoardSettings;
use softdock_io::input::{self, refuse_overwrite_of};
use softdock_io::output::write_whole;
use softdock_io::say;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// Write the robot's RSI Ethernet configuration that matches the board's settings.
///
/// Copy the file to the robot controller's RSI folder. What to enter in the RSI objects is printed
/// to standard error.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: softdock robot-config --settings board.toml --board 192.168.1.20:49152 -o softdock.xml"
)]
pub(super) struct RobotConfig {
    /// Settings of the board (TOML); without it, the defaults
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Address of the board, as the robot sees it
    #[arg(long, value_name = "UDP_ADDR")]
    board: SocketAddr,
    /// File to write (XML); without it, standard output
    #[arg(short, long, value_name = "FILE.xml")]
    output: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Written<'a> {
    xml: &'a str,
    notes: &'a str,
}

impl RobotConfig {
    pub(super) fn execute(self) -> Result<()> {
        ensure!(
            self.board.is_ipv4() && !self.board.ip().is_unspecified() && self.board.port() != 0,
            "--board is {}; expected the IPv4 address and port at which the robot finds the board, \
             such as 192.168.1.20:49152",
            self.board
        );
        let settings: BoardSettings = match &self.settings {
            Some(path) => input::load(path)?,
            None => BoardSettings::default(),
        };
        let xml = ethernet_xml(&settings, self.board)?;
        match &self.output {
            Some(path) => {
                let inputs: Vec<&Path> = self.settings.iter().map(PathBuf::as_path).collect();
                refuse_overwrite_of(&inputs, path, self.force)?;
                write_whole(path, &xml)?;
            }
            None if self.json => {}
            None => print(&xml)?,
        }
        let notes = notes(&settings);
        if self.json {
            return print_json(&Written {
                xml: &xml,
                notes: &notes,
            });
        }
        say!("{}", notes.trim_end());
        Ok(())
    }
}
