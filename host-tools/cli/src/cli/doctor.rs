//! `softdock doctor`: is everything ready for a test?

use super::progress::Progress;
use super::{print, print_json};
use anyhow::{Result, bail, ensure};
use clap::Args;
use serde::Serialize;
use softdock_analysis::commission::doctor::{
    Check, State, of_port, of_recording, of_settings, runs_with, same_settings, self_test, table,
    worst,
};
use softdock_analysis::commission::parameters::BAUD_RATE;
use softdock_analysis::input;
use softdock_analysis::recording::Recording;
use softdock_app::settings::BoardSettings;
use std::path::PathBuf;

/// Check board, robot link, sensor and settings, each with what to do.
///
/// From the board itself (--port), from a recording of some seconds in `hold`, from a settings file,
/// or from several of them, which are then compared. Ends with an error if something is bad.
///
/// The board is only asked: nothing of it is changed, and the robot is left alone. With --self-test a new
/// board writes its settings and starts over.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock doctor --port /dev/ttyACM0

softdock doctor hold.mcap --settings board.toml
(what the signals look like: noise, drift, force at rest)

softdock doctor --settings board.toml
(before there is a recording)

softdock doctor --port /dev/ttyACM0 --self-test
(the first power-on of a board, docs/board.md)")]
pub(super) struct Doctor {
    /// Recording (MCAP)
    recording: Option<PathBuf>,
    /// Settings of the board
    #[arg(long, value_name = "BOARD.toml")]
    settings: Option<PathBuf>,
    /// Serial device, pseudo-terminal, or tcp:HOST:PORT of a board
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    /// Speed of a serial device, bit/s
    #[arg(long, value_name = "BIT_PER_S", default_value_t = BAUD_RATE)]
    baud: u32,
    /// First power-on: have the board show its clock, flash, reset and network as well. It writes the
    /// settings that it has once more, and starts over
    #[arg(long, requires = "port")]
    self_test: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Summary {
    checks: Vec<Check>,
}

impl Doctor {
    pub(super) fn execute(self) -> Result<()> {
        ensure!(
            self.recording.is_some() || self.settings.is_some() || self.port.is_some(),
            "what shall be checked? A board that is there: --port /dev/ttyACM0 or --port tcp:127.0.0.1:29537; a \
             recording: RUN.mcap; a settings file: --settings BOARD.toml"
        );
        let mut checks = Vec::new();
        let recording = self.recording.as_deref().map(Recording::open).transpose()?;
        let board: Option<BoardSettings> = self.settings.as_deref().map(input::load).transpose()?;
        if let Some(port) = self.port.as_deref().filter(|_| self.self_test) {
            let mut tell = |step: &str| eprintln!("doctor: {step}");
            checks.extend(self_test(port, self.baud, &mut tell));
        }
        let running = self.port.as_deref().and_then(|port| {
            let bar = Progress::new();
            let (found, running) =
                of_port(port, self.baud, |done| bar.show(done, "watching the board"));
            checks.extend(found);
            running
        });
        if let Some(recording) = &recording {
            checks.extend(of_recording(recording));
        }
        match (&running, &board) {
            // Those of the board have been looked at.
            (Some(running), Some(board)) => checks.push(runs_with(running, board)),
            (None, Some(board)) => checks.extend(of_settings(board)),
            (_, None) => {}
        }
        if let (Some(recording), Some(board)) = (&recording, &board) {
            checks.push(same_settings(recording, board));
        }
        let state = worst(&checks);
        let bad = checks.iter().filter(|c| c.state == State::Bad).count();
        if self.json {
            print_json(&Summary { checks })?;
        } else {
            print(&format!("{}\n", table(&checks)))?;
        }
        match state {
            State::Bad => {
                bail!("{bad} of the checks are bad; no test should run before they are not")
            }
            State::Good | State::Warning => Ok(()),
        }
    }
}
