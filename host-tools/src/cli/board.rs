//! `softdock board`: the firmware as a process with real sockets.

use crate::board::process::Process;
use crate::identity;
use crate::input::{self, refuse_overwrite};
use crate::recording::{Header, RecordingWriter};
use anyhow::{Context, Result, ensure};
use clap::Args;
use softdock_app::settings::BoardSettings;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Run the controller on this computer, with the robot on UDP and the sensor on TCP.
///
/// The robot (or a simulator of it) sends its RSI telegrams to --robot. The sensor's side connects
/// to --can and speaks SLCAN. Commands on standard input: hold, arm, start, stop, reset, zero.
/// Ctrl-C ends it.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: softdock board --settings board.toml --robot 127.0.0.1:49152 --can 127.0.0.1:29536 --start"
)]
pub(super) struct Board {
    /// Settings of the board (TOML)
    #[arg(long, value_name = "FILE")]
    settings: PathBuf,
    /// UDP address to listen on for the robot
    #[arg(long, value_name = "UDP_ADDR")]
    robot: SocketAddr,
    /// TCP address to listen on for the sensor's SLCAN client
    #[arg(long, value_name = "TCP_ADDR")]
    can: SocketAddr,
    /// UDP address of `softdock record`, which gets each cycle; without it, that of the settings
    #[arg(long, value_name = "UDP_ADDR")]
    telemetry: Option<SocketAddr>,
    /// Arm and start as soon as robot and sensor are healthy
    #[arg(long)]
    start: bool,
    /// Recording to write (MCAP)
    #[arg(short, long, value_name = "RUN.mcap")]
    output: Option<PathBuf>,
    /// Overwrite an existing recording
    #[arg(long)]
    force: bool,
}

impl Board {
    pub(super) fn execute(self) -> Result<()> {
        let settings: BoardSettings = input::load(&self.settings)?;
        settings
            .validate()
            .with_context(|| format!("in {}", self.settings.display()))?;
        if let Some(recorder) = self.telemetry {
            ensure!(
                !recorder.ip().is_unspecified() && recorder.port() != 0,
                "--telemetry is {recorder}; expected the address and port on which `softdock \
                 record --listen` listens, such as 192.168.1.5:49200"
            );
        }
        if let Some(path) = &self.output {
            refuse_overwrite(path, self.force)?;
        }
        eprintln!("board: {}", identity::text());
        let stop = Arc::new(AtomicBool::new(false));
        let raised = stop.clone();
        ctrlc::set_handler(move || raised.store(true, Ordering::Relaxed))
            .context("cannot watch for Ctrl-C")?;
        let header = Header {
            identity: identity::text(),
            settings_toml: toml_edit::ser::to_string_pretty(&settings)?,
            scenario_toml: None,
        };
        let Self {
            robot,
            can,
            telemetry,
            start,
            output,
            ..
        } = self;
        let board = Process {
            settings,
            robot,
            can,
            telemetry,
            start,
        }
        .listen()?;
        let writer = output
            .map(|path| RecordingWriter::create(&path, &header))
            .transpose()?;
        board.run(&stop, move |records| {
            let Some(mut writer) = writer else {
                return Ok(());
            };
            for record in records {
                writer.push(&record, None)?;
            }
            writer.finish().map(drop)
        })
    }
}
