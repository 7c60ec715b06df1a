//! The mapping file: what a user writes to say what the columns of a foreign table are.

use super::column::{Column, ColumnName};
use crate::import::starter::Told;
use crate::import::table::Dialect;
use serde::{Deserialize, Deserializer};
use softdock_physics::model::FilterModel;

/// A mapping file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Mapping {
    /// A model file beside the mapping that is copied to the recordings.
    pub(super) model: Option<String>,
    /// Values for the starting model if `model` is left out.
    pub(super) starter: Option<Told>,
    /// Names of the tables in the folder that is imported.
    pub(super) files: Files,
    /// How the tables are written.
    pub(super) table: Dialect,
    /// When each row was.
    pub(super) time: Time,
    /// In which rows the loop was closed.
    pub(super) mode: Mode,
    /// Position of M in C.
    pub(super) position: Position,
    /// Orientation of M in C.
    pub(super) orientation: Option<Orientation>,
    /// Velocity that was sent to the robot.
    pub(super) sent_velocity: Twist,
    /// Velocity that it was measured to have.
    pub(super) executed_velocity: Executed,
    /// Velocity that the rig's own model asked for.
    pub(super) model_velocity: Twist,
    /// Raw reading of the sensor.
    pub(super) wrench: Wrench,
    /// Rows that are imported.
    pub(super) rows: Rows,
    /// Low-pass and decimation.
    pub(super) filter: Option<Filter>,
    /// Where the unseen data comes from if there is no file of its own.
    pub(super) split: Option<Split>,
}

/// Names of the tables.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Files {
    /// To fit on.
    pub(super) train: Tables,
    /// To test on.
    pub(super) test: Tables,
}

/// The tables of each log. The tables of one log stand side by side, row by row; numbers of columns run on from one to the next.
/// Written as the name of one table, the names of those of one log, or a list of such lists.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Tables(pub(super) Vec<Vec<String>>);

impl<'de> Deserialize<'de> for Tables {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(
            untagged,
            expecting = "expected a file name, a list of file names side by side, or a list of such lists, one for each log"
        )]
        enum Names {
            One(String),
            Beside(Vec<String>),
            Logs(Vec<Vec<String>>),
        }
        let mut logs = match Names::deserialize(deserializer)? {
            Names::One(name) => vec![vec![name]],
            Names::Beside(names) => vec![names],
            Names::Logs(logs) => logs,
        };
        logs.retain(|tables| !tables.is_empty());
        Ok(Self(logs))
    }
}

/// When each row was.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Time {
    /// Column with the time.
    pub(super) column: Option<Column>,
    /// Time from row to row, s, if there is no such column.
    pub(super) sample_time_s: Option<f64>,
    /// What becomes of rows with the time of the row before; they are an error if nothing is said.
    pub(super) duplicates: Option<Duplicates>,
    /// Rate to which rows at any steps are interpolated.
    pub(super) resample_hz: Option<Resample>,
    /// What becomes of gaps; they are cut if nothing is said.
    pub(super) gaps: Option<Gaps>,
}

/// Which of several rows with one time is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Duplicates {
    /// The first of them.
    KeepFirst,
    /// The last of them.
    KeepLast,
}

/// A rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Resample {
    /// The rate of the median step.
    Auto,
    /// This one, Hz, above 0.
    Hz(f64),
}

impl<'de> Deserialize<'de> for Resample {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "expected a rate in Hz or \"auto\"")]
        enum Written {
            Hz(f64),
            Word(String),
        }
        match Written::deserialize(deserializer)? {
            Written::Hz(hz) if hz.is_finite() && hz > 0.0 => Ok(Self::Hz(hz)),
            Written::Word(word) if word == "auto" => Ok(Self::Auto),
            Written::Hz(hz) => Err(serde::de::Error::custom(format!(
                "expected a rate above 0 Hz or \"auto\", found {hz}"
            ))),
            Written::Word(word) => Err(serde::de::Error::custom(format!(
                "expected a rate in Hz or \"auto\", found \"{word}\""
            ))),
        }
    }
}

/// What becomes of gaps between rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Gaps {
    /// The row behind a gap begins anew: nothing is concluded across it.
    Cut,
    /// They are filled by straight lines.
    Bridge,
}

/// In which rows the loop was closed; in the others the motion was commanded.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Mode {
    /// Column that holds it.
    pub(super) column: Option<ColumnName>,
    /// Its values in closed loop; left out: any number but zero.
    pub(super) running: Vec<String>,
    /// Without a column: first row, from 1, and last.
    pub(super) running_rows: Option<[usize; 2]>,
}

/// Position of M in C.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Position {
    x: Option<Column>,
    y: Option<Column>,
    z: Option<Column>,
}

/// Orientation of M in C: four columns of a quaternion, or those of a rotation vector, which about
/// a single axis is the angle; or three angles of turns one after the other.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Orientation {
    /// Columns of a quaternion.
    pub(super) quaternion: Option<[ColumnName; 4]>,
    /// Their order.
    pub(super) order: Order,
    /// `rx`, `ry`, `rz` are angles of rotations about these axes, each axis as the rotation before has turned it.
    pub(super) euler: Option<Turns>,
    rx: Option<Column>,
    ry: Option<Column>,
    rz: Option<Column>,
}

/// Order of the parts of a quaternion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Order {
    /// The real part first.
    #[default]
    Wxyz,
    /// The real part last, as ROS has it.
    Xyzw,
}

/// Axes of three turns, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Turns(pub(super) [usize; 3]);

impl<'de> Deserialize<'de> for Turns {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        let axes: Option<Vec<usize>> = word.chars().map(|c| "xyz".find(c)).collect();
        let axes = axes.and_then(|axes| <[usize; 3]>::try_from(axes).ok());
        let each_once = |axes: &[usize; 3]| (0..3).all(|axis| axes.contains(&axis));
        axes.filter(each_once).map(Self).ok_or_else(|| {
            serde::de::Error::custom(format!(
                "expected x, y and z in the order of the turns, as \"zyx\", found \"{word}\""
            ))
        })
    }
}

/// Linear velocity in C and angular velocity in M.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Twist {
    x: Option<Column>,
    y: Option<Column>,
    z: Option<Column>,
    rx: Option<Column>,
    ry: Option<Column>,
    rz: Option<Column>,
}

/// Executed velocity: columns, or the difference of two poses.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Executed {
    /// From the pose.
    pub(super) derive: bool,
    x: Option<Column>,
    y: Option<Column>,
    z: Option<Column>,
    rx: Option<Column>,
    ry: Option<Column>,
    rz: Option<Column>,
}

/// Raw reading of the sensor.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Wrench {
    /// Axes in which the table has it.
    pub(super) frame: Frame,
    fx: Option<Column>,
    fy: Option<Column>,
    fz: Option<Column>,
    tx: Option<Column>,
    ty: Option<Column>,
    tz: Option<Column>,
}

/// Axes of a wrench.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Frame {
    /// Those of the sensor.
    #[default]
    Sensor,
    /// Those of the robot's base; they are turned into the sensor's with the pose of the row.
    Base,
}

/// Rows that are imported; a row has to meet all conditions that are given.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Rows {
    first: Option<usize>,
    last: Option<usize>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    /// What becomes of rows with a cell that holds no number.
    pub(super) incomplete: Incomplete,
    /// Range of the training log, in place of the four keys above.
    pub(super) train: Option<Span>,
    /// Range of the test log. Without a file of its own it is taken from the same file.
    pub(super) test: Option<Span>,
}

/// A range of rows.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Span {
    /// First row, from 1, without the header.
    pub(super) first: Option<usize>,
    /// Last row.
    pub(super) last: Option<usize>,
    /// Earliest time, s.
    pub(super) from_s: Option<f64>,
    /// Latest time, s.
    pub(super) to_s: Option<f64>,
}

/// One of two logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// To fit on.
    Train,
    /// To test on.
    Test,
}

impl Rows {
    /// Those of one log.
    pub(super) fn of(&self, part: Part) -> Span {
        let own = match part {
            Part::Train => self.train,
            Part::Test => self.test,
        };
        own.unwrap_or(Span {
            first: self.first,
            last: self.last,
            from_s: self.from_s,
            to_s: self.to_s,
        })
    }
}

/// What becomes of rows with a cell that is empty, not finite or `NA`, in a column that is mapped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Incomplete {
    /// They are an error.
    #[default]
    Refuse,
    /// They are left out, which makes gaps.
    LeaveOut,
    /// The cell is interpolated within its column: for tables in which each row holds some of the channels.
    Interpolate,
}

/// A zero-phase Butterworth low-pass on all measured channels, then decimation.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Filter {
    /// Cutoff frequency, Hz.
    pub(super) cutoff_hz: f64,
    /// Order of the filter that runs forwards and backwards.
    #[serde(default = "default_order")]
    pub(super) order: u32,
    /// Every n-th row is kept.
    #[serde(default = "one")]
    pub(super) decimate: usize,
    /// Time that is left out at either end, s: the filter knows the signal on one side only there.
    #[serde(default)]
    pub(super) trim_s: f64,
}

impl Filter {
    /// As a model file says it.
    pub(super) fn as_modelled(self) -> FilterModel {
        FilterModel {
            order: self.order,
            cutoff_hz: self.cutoff_hz,
        }
    }
}

fn default_order() -> u32 {
    4
}

fn one() -> usize {
    1
}

/// How one table becomes training and test data.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Split {
    /// Every n-th row is test data. For measurements at rest.
    TestEvery(usize),
    /// The first part is training data: its share, 0 to 1. For motions.
    TrainShare(f64),
}

/// Keys of the parts of a position.
pub(super) const POSITION_KEYS: [&str; 3] = ["x", "y", "z"];
/// Keys of the parts of a rotation vector.
pub(super) const ROTATION_KEYS: [&str; 3] = ["rx", "ry", "rz"];
/// Keys of the parts of a velocity.
pub(super) const TWIST_KEYS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
/// Keys of the parts of a wrench.
pub(super) const WRENCH_KEYS: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];

impl Position {
    /// In the order of [`POSITION_KEYS`].
    pub(super) fn columns(&self) -> [Option<&Column>; 3] {
        [&self.x, &self.y, &self.z].map(Option::as_ref)
    }
}

impl Orientation {
    /// In the order of [`ROTATION_KEYS`].
    pub(super) fn rotation_columns(&self) -> [Option<&Column>; 3] {
        [&self.rx, &self.ry, &self.rz].map(Option::as_ref)
    }
}

impl Twist {
    /// In the order of [`TWIST_KEYS`].
    pub(super) fn columns(&self) -> [Option<&Column>; 6] {
        [&self.x, &self.y, &self.z, &self.rx, &self.ry, &self.rz].map(Option::as_ref)
    }
}

impl Executed {
    /// In the order of [`TWIST_KEYS`].
    pub(super) fn columns(&self) -> [Option<&Column>; 6] {
        [&self.x, &self.y, &self.z, &self.rx, &self.ry, &self.rz].map(Option::as_ref)
    }
}

impl Wrench {
    /// Notes on columns in a converter's unit whose scale is not known.
    pub(super) fn unscaled(&self) -> impl Iterator<Item = String> {
        let columns = self.columns().into_iter().zip(WRENCH_KEYS);
        columns.filter_map(|(column, key)| {
            let si = if key.starts_with('f') { "N" } else { "N·m" };
            let said = column?.unscaled(si)?;
            Some(format!("[wrench] {key}: {said}"))
        })
    }

    /// In the order of [`WRENCH_KEYS`].
    pub(super) fn columns(&self) -> [Option<&Column>; 6] {
        [&self.fx, &self.fy, &self.fz, &self.tx, &self.ty, &self.tz].map(Option::as_ref)
    }
}
