//! `softdock params`: settings, state and commands of a board over its serial line.

mod change;
mod show;
mod state;

use super::progress::Progress;
use anyhow::{Context, Result};
use clap::{Args, Subcommand};
use softdock_commissioning::parameters::{Client, Setting};
use softdock_io::port::{BAUD_RATE, Port, only_board};
use softdock_io::say;
use std::path::PathBuf;

/// Settings, state and commands of a board over its serial line.
///
/// The line is the NUCLEO's USB cable, or the --service of `softdock board` and `cargo qemu`. What a
/// board can be set to is asked from the board itself.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock params list --port /dev/ttyACM0")]
pub(super) struct Params {
    #[command(subcommand)]
    command: Command,
    /// Serial device, pseudo-terminal, or tcp:HOST:PORT; by default the only board on USB
    #[arg(long, global = true, value_name = "PORT")]
    port: Option<String>,
    /// Speed of a serial device, bit/s
    #[arg(long, global = true, value_name = "BIT_PER_S", default_value_t = BAUD_RATE)]
    baud: u32,
    /// Print one JSON document
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The serial ports of this computer
    #[command(after_help = "Example: softdock params ports")]
    Ports,
    /// All settings with values, units and ranges
    #[command(after_help = "Example: softdock params list --port tcp:127.0.0.1:29537")]
    List,
    /// The value of a setting
    #[command(after_help = "Example: softdock params get control.sensor.tool_mass_kg")]
    Get {
        /// Its name, as `list` shows it
        name: String,
    },
    /// Change a setting, for good
    #[command(after_help = "Example: softdock params set control.sensor.tool_mass_kg 1.25")]
    Set {
        /// Its name, as `list` shows it
        name: String,
        /// Its value: a number, a word, or a list like "[0, 0, -9.81]"
        #[arg(allow_hyphen_values = true)]
        value: String,
        #[command(flatten)]
        confirm: Confirm,
    },
    /// All settings as a TOML file with descriptions, units and ranges
    #[command(after_help = "Example: softdock params dump -o board.toml")]
    Dump {
        /// File to write in place of standard output
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,
        /// Overwrite an existing file
        #[arg(long)]
        force: bool,
    },
    /// What a settings file would change
    #[command(after_help = "Example: softdock params diff board.toml")]
    Diff {
        #[command(flatten)]
        file: File,
    },
    /// Write a settings file to the board, for good: all of it or nothing
    #[command(after_help = "Example: softdock params upload board.toml")]
    Upload {
        #[command(flatten)]
        file: File,
        /// Do not ask
        #[arg(short, long)]
        yes: bool,
        #[command(flatten)]
        confirm: Confirm,
    },
    /// End a trial of settings, or go back to those before the present ones
    #[command(after_help = "Example: softdock params rollback")]
    Rollback {
        #[command(flatten)]
        confirm: Confirm,
    },
    /// The state of the board again and again, a line each time
    #[command(after_help = "Example: softdock params watch --period 0.5")]
    Watch {
        /// Time from one line to the next, s
        #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = state::period)]
        period: f64,
        /// End after so many lines; with --json they make one document
        #[arg(long, value_name = "N")]
        samples: Option<usize>,
    },
    /// The state of the board, its counters and the end of its log
    #[command(after_help = "Example: softdock params status")]
    Status,
    /// Give a command: hold, arm, start, stop, reset, zero, or jog with an axis
    #[command(after_help = "\
Example: softdock params mode hold

softdock params mode jog x
(in hold: the robot moves along x, `control.jog` says how far and how fast; the other way is \"jog -x\",
in quotes; y, z and the rotations a, b, c likewise)")]
    Mode {
        /// The command
        #[arg(required = true, num_args = 1..=2, value_name = "COMMAND")]
        command: Vec<String>,
    },
}

#[derive(Debug, Args)]
struct File {
    /// Settings of the board (TOML); what it leaves out gets its default
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// What the file leaves out stays as it is
    #[arg(long)]
    keep: bool,
}

#[derive(Debug, Args)]
struct Confirm {
    /// Time after which the board goes back to its old settings if this program does not come back, s
    #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u16).range(1..=3600))]
    confirm_within: u16,
}

/// The board that is talked to.
struct Board {
    client: Client,
    port: String,
    json: bool,
}

impl Params {
    pub(super) fn execute(self) -> Result<()> {
        if matches!(self.command, Command::Ports) {
            return show::ports(self.json);
        }
        if let Command::Watch { samples: None, .. } = self.command
            && self.json
        {
            anyhow::bail!("--json prints one document: say how long with --samples N");
        }
        let mut board = Board::connect(self.port, self.baud, self.json)?;
        match self.command {
            Command::Ports => Ok(()),
            Command::List => board.print_list(),
            Command::Get { name } => board.get(&name),
            Command::Dump { output, force } => board.dump(output.as_deref(), force),
            Command::Diff { file } => board.diff(&file),
            Command::Set {
                name,
                value,
                confirm,
            } => board.set(&name, &value, &confirm),
            Command::Upload { file, yes, confirm } => board.upload(&file, yes, &confirm),
            Command::Rollback { confirm } => board.roll_back(&confirm),
            Command::Watch { period, samples } => board.watch(period, samples),
            Command::Status => board.print_status(),
            Command::Mode { command } => board.mode(&command.join(" ")),
        }
    }
}

impl Board {
    fn connect(port: Option<String>, baud: u32, json: bool) -> Result<Self> {
        let name = match port {
            Some(port) => port,
            None => only_board()?,
        };
        let port = Port::open(&name, baud)?;
        let client = Client::connect(port).with_context(|| name.clone())?;
        say!("{name}: {}", client.identity().text);
        let port = name;
        Ok(Self { client, port, json })
    }

    /// All settings; on a serial line that takes some seconds.
    fn settings(&mut self) -> Result<Vec<Setting>> {
        let bar = Progress::new();
        let settings = self.client.list(|count, of| {
            bar.show(f64::from(count) / f64::from(of), "reading settings");
        });
        drop(bar);
        settings.with_context(|| self.port.clone())
    }
}
