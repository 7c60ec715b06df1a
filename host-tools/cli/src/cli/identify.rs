//! `softdock identify`: how the robot follows.

mod live;

use super::findings::Destination;
use super::outputs::mcap_file;
use anyhow::{Context, Result};
use clap::{Args, Subcommand};
use softdock_commissioning::identify::{Identification, identify};
use softdock_commissioning::input::read;
use softdock_experiments::jog_rehearsal::jog;
use softdock_experiments::scenario::Scenario;
use softdock_io::input::refuse_overwrite_of;
use softdock_io::recording::Recording;
use softdock_io::say;
use softdock_physics::model::Axis;
use std::path::{Path, PathBuf};

/// Find out how the robot follows what it is told.
#[derive(Debug, Args)]
pub(super) struct Identify {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Actuator(Box<Actuator>),
}

impl Identify {
    pub(super) fn execute(self) -> Result<()> {
        match self.what {
            What::Actuator(actuator) => actuator.execute(),
        }
    }
}

/// Transport delay, lag or servo, pause at a zero crossing and limits, from a jog or step recording.
///
/// The command and the measured pose of every cycle are in every recording. Delay and lag trade off
/// against each other; their sum, the mean delay, is known best.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock identify actuator --port /dev/ttyACM0 --axis x,-z --into board.toml
(jogs the robot, after a question, and records what the board sends to `network.recorder`)

softdock identify actuator --recording jog.mcap --into board.toml

softdock identify actuator --recording log.csv --mapping mapping.toml --report robot.html
(a table of another program; the mapping says which column is what)

softdock identify actuator --rehearse scenario.toml
(the jog on the simulated rig of a scenario, in free space)")]
struct Actuator {
    /// Recording (MCAP), or a table or folder that `softdock import` reads
    #[arg(long, value_name = "PATH")]
    recording: Option<PathBuf>,
    /// What the columns of a table are (TOML)
    #[arg(long, value_name = "FILE.toml", requires = "recording")]
    mapping: Option<PathBuf>,
    /// Jog the simulated rig of a scenario instead
    #[arg(long, value_name = "SCENARIO.toml", conflicts_with = "recording")]
    rehearse: Option<PathBuf>,
    /// Axes of the jog, one after the other: x, y, z, or the rotations a, b, c about z, y, x of the
    /// flange; -x goes the other way. A rehearsal takes one of x, y, z
    #[arg(
        long,
        value_name = "AXES",
        default_value = "x",
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with = "recording"
    )]
    axis: Vec<String>,
    /// Recording of the jog to write
    #[arg(long, value_name = "JOG.mcap", conflicts_with = "recording", value_parser = mcap_file)]
    keep: Option<PathBuf>,
    #[command(flatten)]
    live: live::Options,
    #[command(flatten)]
    to: Destination,
}

impl Actuator {
    fn execute(self) -> Result<()> {
        let inputs = [&self.recording, &self.rehearse, &self.mapping];
        let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
        self.to.check(&inputs)?;
        if let Some(file) = &self.keep {
            refuse_overwrite_of(&inputs, file, self.to.force)?;
        }
        if let Some(port) = &self.live.port {
            return self.jog_live(port);
        }
        let (recording, origin) = self.recorded()?;
        let found = identify(&recording)?;
        self.give(&found, &origin)
    }

    /// The recording and a description of its origin.
    fn recorded(&self) -> Result<(Recording, String)> {
        match (&self.recording, &self.rehearse) {
            (Some(path), _) => {
                let read = read(path, self.mapping.as_deref())?;
                for note in &read.notes {
                    say!("warning: {note}");
                }
                Ok((read.recording, path.display().to_string()))
            }
            (None, Some(path)) => self.rehearsed(path),
            (None, None) => anyhow::bail!(
                "what shall be identified? A robot that is there: --port /dev/ttyACM0 or --port tcp:127.0.0.1:29537; \
                 a recorded jog: --recording JOG.mcap; that of a simulated rig: --rehearse SCENARIO.toml"
            ),
        }
    }

    fn rehearsed(&self, path: &Path) -> Result<(Recording, String)> {
        let scenario = Scenario::load(path)?;
        let wanted = self.axis.join(",");
        let named = |axis: &Axis| axis.to_string() == wanted;
        let axis = Axis::ALL
            .into_iter()
            .find(named)
            .with_context(|| format!("--axis {wanted}: a rehearsal expects x, y or z"))?;
        let recording = jog(&scenario, axis, scenario.seed)?;
        if let Some(file) = &self.keep {
            recording.write(file)?;
        }
        let origin = format!("a jog of the simulated rig of {}", path.display());
        Ok((recording, origin))
    }

    /// Writes and prints the identification.
    fn give(&self, found: &Identification, origin: &str) -> Result<()> {
        for note in &found.notes {
            say!("note: {note}");
        }
        let text = format!("{}\n\n{}\n", found.sentence(), found.table());
        let page = || crate::pages::identification::page(found, origin);
        self.to.give(found, &found.fragment(origin), page, &text)
    }
}
