//! Recordings: every cycle of a run with its settings and the identity of the firmware.
//!
//! The native format is MCAP with ROS 2 messages, which Foxglove and PlotJuggler open:
//! - `topics` names every recorded number, `field` and `words` say how it is described,
//! - `cdr` and `schema` turn these into messages and their description,
//! - `single` and `recomputation` store in half the space what can be computed again,
//! - `writer` and `reader` write messages into a file and read them back, also from a truncated file,
//! - `mcap_file` is the file that the writer writes,
//! - `table` stores logs of other programs with only the columns that they have,
//! - `csv_files` and `text` do the same as CSV with a JSON file beside it,
//! - `columns` gives the recorded quantities as series for plots,
//! - `numbers` writes a table as a topic,
//! - `ros2` makes a copy with the standard messages of ROS 2, for viewers,
//! - `outline` reads the length of a file without reading its cycles,
//! - `wall_clock` assigns times of day to cycles,
//! - `difference` compares two records of a cycle.

mod cdr;
mod columns;
mod csv_files;
mod difference;
mod field;
mod file_format;
mod mcap_file;
mod numbers;
mod outline;
mod reader;
mod recomputation;
mod ros2;
mod schema;
mod single;
mod table;
mod text;
mod topics;
mod wall_clock;
mod words;
mod writer;

pub use columns::Column;
pub use csv_files::{export_csv, import_csv};
pub use difference::{Comparison, Difference};
pub use outline::Outline;
pub use recomputation::Rounded;
pub use wall_clock::{WALL_CLOCK, WallClock};
pub use writer::RecordingWriter;

use crate::input;
use serde::{Deserialize, Serialize};
use softdock_app::record::CycleRecord;
use softdock_control::settings::Settings;

/// Name and version of the format, in every recording.
pub const FORMAT: &str = "softdock/1";

/// Name of the metadata record that identifies a file of softdock.
const METADATA: &str = "softdock";

/// MCAP profile of the files: programs for ROS 2 look for it.
const PROFILE: &str = "ros2";
/// MCAP profile that versions up to 0.1.0 wrote.
const OWN_PROFILE: &str = "softdock";

/// Description of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// Firmware that ran: name, version, git hash, dirty or not.
    pub identity: String,
    /// The board's settings as TOML, complete (defaults included).
    pub settings_toml: String,
    /// The scenario of a simulated run as TOML.
    pub scenario_toml: Option<String>,
    /// Number of whole turns that the first pose of an imported log stands for, about the axis of a rotating machine: a pose
    /// alone is known up to whole turns.
    pub whole_turns: i32,
    /// Beginning of the log if this recording is a later part of it; None for a whole log.
    pub began: Option<Beginning>,
}

/// Start of a log. Effects that count from there depend on it: a drift, a spring that rests at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beginning {
    /// Time of the first cycle, s.
    pub time_s: f64,
    /// First pose of M in C: position (m), quaternion (w x y z).
    pub pose: [f64; 7],
    /// Whole turns of that pose: see [`Header::whole_turns`].
    pub whole_turns: i32,
}

impl Header {
    /// The settings of the control cycle: the table `control` of the board's settings. The other
    /// tables concern its links.
    pub fn control_settings(&self) -> anyhow::Result<Settings> {
        #[derive(serde::Deserialize)]
        struct Board {
            control: Settings,
        }
        let board: Board = input::parse(&self.settings_toml, "settings in the recording")?;
        Ok(board.control)
    }
}

/// True state of a simulated rig at the instant of a cycle. Real rigs have no such record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TruthRecord {
    /// Time of the rig, s.
    pub time_s: f64,
    /// Pose of M in C: position (m), quaternion (w x y z).
    pub pose: [f64; 7],
    /// Velocity of M: linear in C (m/s), angular in M (rad/s).
    pub velocity: [f64; 6],
    /// Contact wrench at M, axes of M (N, N·m).
    pub contact_wrench: [f64; 6],
}

/// A recording in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Identity and settings.
    pub header: Header,
    /// All cycles in their order.
    pub cycles: Vec<CycleRecord>,
    /// The rig's truth for each cycle; empty for a real rig.
    pub truth: Vec<TruthRecord>,
    /// Why the file ended early, if it was cut off; the cycles before are complete.
    pub cut: Option<String>,
    /// First cycle of a simulated run whose numbers this version computes otherwise than the writer; None if there is none.
    pub rounded: Option<Rounded>,
    /// Wall clock, if a computer with a clock made the recording.
    pub wall_clock: Option<WallClock>,
}
