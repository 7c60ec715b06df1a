//! `softdock qemu`: the microcontroller's firmware in QEMU.

use super::board::checked;
use super::live::raised_by_ctrl_c;
use anyhow::Result;
use clap::Args;
use softdock_app::emulated_flash::Crash;
use softdock_io::address::address;
use softdock_io::identity;
use softdock_io::say;
use softdock_rig::board::qemu::{Chip, Qemu};
use std::net::SocketAddr;
use std::path::PathBuf;

/// Run the microcontroller's firmware in QEMU, with the robot on UDP and the sensor on TCP.
///
/// Builds the firmware from the sources of this repository, writes the settings into its emulated
/// flash, and prints its log. The addresses are those of `softdock board`: the robot sends its RSI
/// telegrams to --robot, the sensor's side connects to --can and speaks SLCAN. Seen from the
/// firmware, whoever sends from this computer has the address 10.0.2.2. Ctrl-C ends it. In the
/// repository, `cargo qemu -- ..` is the same. With SOFTDOCK_FIRMWARE_PROFILE=dev in the environment
/// the firmware is built unoptimised, for tests; what goes to a board never is.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: softdock qemu --settings board.toml --robot 127.0.0.1:49152 --can 127.0.0.1:29536 --service 127.0.0.1:29537 --start"
)]
pub(super) struct QemuCommand {
    /// Settings of the board (TOML)
    #[arg(long, value_name = "FILE")]
    settings: PathBuf,
    /// File that is the board's flash and keeps what `softdock params` changes; made if missing, and
    /// once it holds settings they go before those of --settings
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// UDP address to listen on for the robot
    #[arg(long, value_name = "UDP_ADDR", value_parser = address)]
    robot: SocketAddr,
    /// TCP address to listen on for the sensor's SLCAN client
    #[arg(
        long,
        value_name = "TCP_ADDR",
        value_parser = address,
        required_unless_present = "ethercat"
    )]
    can: Option<SocketAddr>,
    /// UDP address to listen on for the sensor's EtherCAT segment, a frame in a datagram: the firmware has EtherCAT in
    /// place of CAN
    #[arg(long, value_name = "UDP_ADDR", value_parser = address)]
    ethercat: Option<SocketAddr>,
    /// TCP address to listen on for `softdock params`
    #[arg(long, value_name = "TCP_ADDR", value_parser = address)]
    service: Option<SocketAddr>,
    /// Arm and start as soon as robot and sensor are healthy; once, and not again after a change of the settings
    #[arg(long)]
    start: bool,
    /// Crash at the first start, to see what is told of it at the second
    #[arg(long, value_parser = crash, hide = true)]
    crash: Option<Crash>,
    /// TCP address to listen on for QEMU's machine protocol, to pull the network's cable
    #[arg(long, value_name = "TCP_ADDR", value_parser = address, hide = true)]
    monitor: Option<SocketAddr>,
    /// The emulated chip
    #[arg(long, value_enum, default_value_t)]
    chip: Chip,
}

impl QemuCommand {
    pub(super) fn execute(self) -> Result<()> {
        let settings = checked(&self.settings)?;
        say!("qemu: {}", identity::text());
        let stop = raised_by_ctrl_c()?;
        let board = Qemu {
            settings,
            flash: self.flash,
            robot: self.robot,
            can: self.can,
            ethercat: self.ethercat,
            service: self.service,
            start: self.start,
            crash: self.crash,
            monitor: self.monitor,
            chip: self.chip,
        };
        board.run(&stop)
    }
}

fn crash(word: &str) -> Result<Crash, String> {
    match word {
        "panic" => Ok(Crash::Panic),
        "stack" => Ok(Crash::StackOverflow),
        "fault" => Ok(Crash::Fault),
        _ => Err("expected panic, stack or fault".into()),
    }
}
