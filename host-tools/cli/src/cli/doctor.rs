//! `softdock doctor`: is everything ready for a test?

use super::agree::agree;
use super::answer;
use super::progress::Progress;
use anyhow::{Result, bail, ensure};
use clap::Args;
use serde::Serialize;
use softdock_app::settings::BoardSettings;
use softdock_commissioning::doctor::{
    Check, Onlooker, State, of_port, of_recording, of_settings, runs_with, same_settings,
    self_test, table, worst,
};
use softdock_io::input;
use softdock_io::port::BAUD_RATE;
use softdock_io::recording::Recording;
use softdock_io::say;
use std::io::IsTerminal;
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

softdock doctor --port /dev/ttyACM0 --self-test --hang
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
    /// First power-on: have the board show its clock, flash, reset, CAN controller, network and LEDs as
    /// well. It writes the settings that it has once more, and starts over
    #[arg(long, requires = "port")]
    self_test: bool,
    /// Have the board hang as well, so that its watchdog shows that it resets it
    #[arg(long, requires = "self_test")]
    hang: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

/// The person at the terminal: is told each step, and answers questions if there is one.
struct Terminal;

impl Onlooker for Terminal {
    fn tell(&mut self, step: &str) {
        say!("doctor: {step}");
    }

    fn sees(&mut self, question: &str) -> Option<bool> {
        let there = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
        there.then(|| agree(question, "no").is_ok())
    }
}

#[derive(Serialize)]
struct Summary<'a> {
    checks: &'a [Check],
}

impl Doctor {
    /// Options of the self-test at the first power-on of the board on this port.
    pub(super) fn self_test(port: String, hang: bool) -> Self {
        Self {
            recording: None,
            settings: None,
            port: Some(port),
            baud: BAUD_RATE,
            self_test: true,
            hang,
            json: false,
        }
    }

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
            checks.extend(self_test(port, self.baud, self.hang, &mut Terminal));
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
        answer(self.json, &Summary { checks: &checks }, || {
            format!("{}\n", table(&checks))
        })?;
        match state {
            State::Bad => {
                bail!("{bad} of the checks are bad; no test should run before they are not")
            }
            State::Good | State::Warning => Ok(()),
        }
    }
}
