//! Jogs of the robot of a connected board.

use super::Actuator;
use crate::cli::agree::agree;
use crate::cli::live::{raised_by_ctrl_c, upload};
use crate::cli::progress::Progress;
use anyhow::{Result, ensure};
use clap::Args;
use softdock_commissioning::identify::identify;
use softdock_commissioning::identify::live::Jogs;
use softdock_commissioning::live::{LiveBoard, LiveRecorder};
use softdock_io::port::BAUD_RATE;
use softdock_io::say;
use std::net::SocketAddr;
use std::sync::atomic::Ordering;

/// Where the board is.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Jog the robot of the board on this serial device, pseudo-terminal, or tcp:HOST:PORT
    #[arg(long, conflicts_with_all = ["recording", "rehearse"])]
    pub(super) port: Option<String>,
    /// Speed of a serial device, bit/s
    #[arg(long, value_name = "BIT_PER_S", default_value_t = BAUD_RATE)]
    baud: u32,
    /// UDP address on which the board's cycles are heard, if not `network.recorder` of its settings
    #[arg(long, value_name = "UDP_ADDR", requires = "port")]
    listen: Option<SocketAddr>,
    /// Do not ask whether the robot may move
    #[arg(short, long, requires = "port")]
    yes: bool,
    /// Write what was found into the board's settings
    #[arg(long, requires = "port")]
    upload: bool,
}

impl Actuator {
    /// Asks, jogs, identifies, and uploads.
    pub(super) fn jog_live(&self, port: &str) -> Result<()> {
        let mut board = LiveBoard::connect(Some(port), self.live.baud)?;
        say!("{port}: {}", board.client.identity().text);
        let jogs = Jogs::new(&mut board, &self.axis)?;
        let address = board.recorder(self.live.listen)?;
        board.hold()?;
        say!("The robot will move:\n{}", jogs.announcement().trim_end());
        if !self.live.yes {
            ensure!(
                !self.to.json,
                "--json asks nobody: say --yes to let the robot move"
            );
            agree("Is its way free?", "nothing moved")?;
        }
        let stop = raised_by_ctrl_c()?;
        let mut recorder = LiveRecorder::open(address, self.keep.as_deref())?;
        let bar = Progress::new();
        let done = jogs.run(&mut board, &mut recorder, &stop, |share, word| {
            bar.show(share, word);
        });
        drop(bar);
        if let Err(error) = done {
            say!("{}", recorder.interrupted());
            return Err(error);
        }
        let (recording, notes) = recorder.finish()?;
        for note in notes {
            say!("warning: {note}");
        }
        let found = identify(&recording)?;
        // From here on each step is atomic: Ctrl-C no longer interrupts.
        ensure!(
            !stop.load(Ordering::Relaxed),
            "stopped after the jog: nothing was written"
        );
        let origin = format!("a jog of the robot along {}", self.axis.join(", "));
        self.give(&found, &origin)?;
        match self.live.upload {
            true => upload(&mut board, &found.fragment(&origin)),
            false => Ok(()),
        }
    }
}
