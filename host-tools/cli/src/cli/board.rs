//! `softdock board`: the firmware as a process with real sockets.

use super::live::raised_by_ctrl_c;
use super::outputs::mcap_file;
use super::piece_args::PieceArgs;
use anyhow::{Context, Result, ensure};
use clap::Args;
use softdock_app::settings::BoardSettings;
use softdock_io::address::address;
use softdock_io::identity;
use softdock_io::input::{self, refuse_overwrite_of};
use softdock_io::recording::Header;
use softdock_io::say;
use softdock_io::telemetry::{FileSeries, Time};
use softdock_rig::board::process::{CanAddress, Process, Record, ServiceAddress};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Run the controller on this computer, with the robot on UDP and the sensor on TCP.
///
/// The robot (or a simulator of it) sends its RSI telegrams to --robot. The sensor's side connects
/// to --can and speaks SLCAN, or --can names a real SLCAN adapter on the sensor's bus, or the sensor is an EtherCAT segment that sends its frames to --ethercat. Commands on standard input: hold, arm, start, stop, reset, zero, jog x; or,
/// with --service, by `softdock params mode`. Ctrl-C ends it. When `softdock params` changes settings
/// the board starts over, and a recording goes on in a file of its own, as it does when a file has its size: RUN-2.mcap, RUN-3.mcap ..
#[derive(Debug, Args)]
#[command(
    after_help = "Example: softdock board --settings board.toml --robot 127.0.0.1:49152 --can 127.0.0.1:29536 --service 127.0.0.1:29537 --start"
)]
pub(super) struct Board {
    /// Settings of the board (TOML); a flash file that holds settings goes before them
    #[arg(long, value_name = "FILE", required_unless_present = "flash")]
    settings: Option<PathBuf>,
    /// File that is the board's flash and keeps what `softdock params` changes; made if missing
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// UDP address to listen on for the robot
    #[arg(long, value_name = "UDP_ADDR", value_parser = address)]
    robot: SocketAddr,
    /// TCP address to listen on for the sensor's SLCAN client; or an SLCAN adapter to open at 1 Mbit/s: its serial device (/dev/ttyACM0, /dev/ttyUSB0@3000000) or tcp:HOST:PORT
    #[arg(
        long,
        value_name = "TCP_ADDR|ADAPTER",
        required_unless_present = "ethercat"
    )]
    can: Option<CanAddress>,
    /// UDP address to listen on for the sensor's EtherCAT segment, a frame in a datagram; the settings choose the link
    #[arg(long, value_name = "UDP_ADDR", value_parser = address)]
    ethercat: Option<SocketAddr>,
    /// TCP address to listen on for `softdock params`, or `pty` for a pseudo-terminal
    #[arg(long, value_name = "TCP_ADDR|pty")]
    service: Option<ServiceAddress>,
    /// UDP address of `softdock record`, which gets each cycle; without it, that of the settings
    #[arg(long, value_name = "UDP_ADDR", value_parser = address)]
    telemetry: Option<SocketAddr>,
    /// Arm and start as soon as robot and sensor are healthy; once, and not again after a change of the settings
    #[arg(long)]
    start: bool,
    /// Recording to write (MCAP)
    #[arg(short, long, value_name = "RUN.mcap", value_parser = mcap_file)]
    output: Option<PathBuf>,
    #[command(flatten)]
    pieces: PieceArgs,
    /// Overwrite an existing recording
    #[arg(long)]
    force: bool,
}

impl Board {
    pub(super) fn execute(self) -> Result<()> {
        let settings = self.settings.as_deref().map(checked).transpose()?;
        if let Some(recorder) = self.telemetry {
            ensure!(
                !recorder.ip().is_unspecified() && recorder.port() != 0,
                "--telemetry is {recorder}; expected the address and port on which `softdock \
                 record --listen` listens, such as 192.168.1.5:49200"
            );
        }
        if let Some(path) = &self.output {
            let inputs: Vec<&Path> = [&self.settings, &self.flash]
                .into_iter()
                .flatten()
                .map(PathBuf::as_path)
                .collect();
            refuse_overwrite_of(&inputs, path, self.force)?;
        }
        say!("board: {}", identity::text());
        let stop = raised_by_ctrl_c()?;
        let board = Process {
            settings,
            flash: self.flash,
            robot: self.robot,
            can: self.can,
            ethercat: self.ethercat,
            service: self.service,
            telemetry: self.telemetry,
            start: self.start,
        }
        .listen(&stop)?;
        let bounds = self.pieces.bounds()?;
        let output = self
            .output
            .map(|path| FileSeries::new(&path, bounds, Time::Real));
        let output = output.map(Mutex::new).map(Arc::new);
        board.run(&stop, move |settings| recording(output.clone(), settings))
    }
}

/// Reads the settings of a board from a file and validates them.
pub(super) fn checked(path: &Path) -> Result<BoardSettings> {
    let settings: BoardSettings = input::load(path)?;
    settings
        .validate()
        .with_context(|| format!("in {}", path.display()))?;
    Ok(settings)
}

/// Begins the next file of the recording for a board with these settings. Returns the function that writes its records;
/// without `output` it drops them.
fn recording(output: Option<Arc<Mutex<FileSeries>>>, settings: &BoardSettings) -> Result<Record> {
    let Some(output) = output else {
        return Ok(Box::new(|records| {
            records.for_each(drop);
            Ok(())
        }));
    };
    let header = Header {
        identity: identity::text(),
        settings_toml: toml_edit::ser::to_string_pretty(settings)?,
        ..Header::default()
    };
    // Only one board runs at a time, so nobody else holds the lock.
    let locked = || output.lock().unwrap_or_else(PoisonError::into_inner);
    locked().begin(header)?;
    Ok(Box::new(move |records| {
        let mut series = output.lock().unwrap_or_else(PoisonError::into_inner);
        for record in records {
            series.push(&record, None)?;
            for warning in series.take_warnings() {
                say!("board: {warning}");
            }
        }
        series.finish()
    }))
}
