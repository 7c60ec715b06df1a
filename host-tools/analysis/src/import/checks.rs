//! Checks whether a recording can be compared with a model. These checks apply to any recording, before a fit concludes something
//! from a wrong one.
//!
//! Whatever makes a comparison meaningless is an error. Whatever a person has to look at is a warning: a suspected unit is
//! reported, never corrected, because only the user knows the right one.

pub(crate) mod acceleration;
mod causality;
pub(crate) mod force;
mod spikes;
mod timing;
mod units;
mod zero;

pub use acceleration::filter_needed;
pub use force::signs;
pub(super) use timing::{GAP, ensure_rising};

use softdock_app::record::CycleRecord;
use softdock_io::recording::Recording;
use softdock_physics::model::{Axis, Model};

/// Fewest rows of a log of a motion: less than half a second of a 4 ms cycle shows no effect.
const FEWEST_ROWS: usize = 100;
/// Fewest rows of measurements at rest: weight, centre of mass and zero are ten unknowns, and
/// each row gives six numbers, of which many repeat.
const FEWEST_AT_REST: usize = 12;

/// What is known about a recording.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// Name in sentences: the file.
    pub name: &'a str,
    /// Sample time that the user states, s.
    pub sample_time_s: Option<f64>,
    /// The model that it belongs to.
    pub model: Option<&'a Model>,
    /// Least number of rows; by default that which a diagnosis needs.
    pub fewest_rows: Option<usize>,
    /// The recording is being imported. When it is read back later, units and columns are not asked about again.
    pub imports: bool,
}

impl<'a> Context<'a> {
    /// Of a recording that was imported before, in sentences without its name.
    fn of_model(model: Option<&'a Model>) -> Self {
        Self {
            name: "",
            sample_time_s: None,
            model,
            fewest_rows: None,
            imports: false,
        }
    }

    /// Whether the rows are measurements at rest, independent of each other.
    fn at_rest(&self) -> bool {
        self.model.is_some_and(|model| model.sensor.at_rest)
    }
}

/// A recording that no comparison can use. Rows are counted from 1, without a header.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CheckError {
    /// Too few rows.
    #[error("{name}: {received} rows, at least {expected} are needed; {remedy}")]
    TooShort {
        /// The recording.
        name: String,
        /// Rows that are needed.
        expected: usize,
        /// Rows that are there.
        received: usize,
        /// What to do.
        remedy: &'static str,
    },
    /// The time is the same in two rows, or runs backwards.
    #[error(
        "{name}, row {row}: the time is {time_s} s after {before_s} s; expected a time that rises in every row, counted from 1 as \
         they are in the file: {remedy}"
    )]
    TimeNotRising {
        /// The recording.
        name: String,
        /// Row.
        row: usize,
        /// Its time, s.
        time_s: f64,
        /// Time of the row before, s.
        before_s: f64,
        /// What to do.
        remedy: &'static str,
    },
    /// The rows are not as far apart as promised.
    #[error(
        "{name}: the rows are {received_s:.6} s apart on average, but the sample time is given as \
         {expected_s} s; correct whichever is wrong"
    )]
    SampleTime {
        /// The recording.
        name: String,
        /// Promised, s.
        expected_s: f64,
        /// Found, s.
        received_s: f64,
    },
    /// Position and velocity are in different units.
    #[error(
        "{name}: position {axis} changes {ratio:.4} times as fast as its velocity says: {hint}"
    )]
    Units {
        /// The recording.
        name: String,
        /// The axis.
        axis: Axis,
        /// Change of the position over its velocity.
        ratio: f64,
        /// What to do.
        hint: String,
    },
    /// Nothing changes.
    #[error(
        "{name}: no velocity, pose or wrench changes in its {rows} rows, {from_s} s to {to_s} s; expected a test in which \
         something moves or is loaded; {remedy}"
    )]
    NothingChanges {
        /// The recording.
        name: String,
        /// Its rows.
        rows: usize,
        /// Time of the first, s.
        from_s: f64,
        /// Time of the last, s.
        to_s: f64,
        /// What to do.
        remedy: &'static str,
    },
}

/// Checks a recording; the result is what the user should know.
///
/// # Errors
///
/// [`CheckError`]: too short, times that do not rise or contradict the promised sample time,
/// position and velocity in different units, nothing that changes.
pub fn check(recording: &Recording, context: &Context<'_>) -> Result<Vec<String>, CheckError> {
    let cycles = recording.cycles.as_slice();
    let expected = context.fewest_rows.unwrap_or(if context.at_rest() {
        FEWEST_AT_REST
    } else {
        FEWEST_ROWS
    });
    if cycles.len() < expected {
        return Err(CheckError::TooShort {
            name: context.name.to_owned(),
            expected,
            received: cycles.len(),
            remedy: match context.at_rest() {
                true => {
                    "take more poses, or, with `test_every` of [split], keep fewer of them apart"
                }
                false => "record for longer",
            },
        });
    }
    let mut warnings = Vec::new();
    let sample_time_s = timing::check(cycles, context, &mut warnings)?;
    ensure_changes(cycles, context.name)?;
    units::check(cycles, sample_time_s, context, &mut warnings)?;
    if !context.at_rest() {
        causality::check(cycles, sample_time_s, context, &mut warnings);
        zero::check(cycles, sample_time_s, context, &mut warnings);
        if context.imports {
            spikes::check(cycles, context, &mut warnings);
        }
    }
    force::check(recording, context, &mut warnings);
    Ok(warnings)
}

/// Refuses a recording in which no measured value changes.
fn ensure_changes(cycles: &[CycleRecord], name: &str) -> Result<(), CheckError> {
    let (Some(first), Some(last)) = (cycles.first(), cycles.last()) else {
        return Ok(());
    };
    /// Changes below this, in SI units, are none: no sensor resolves them. A filter leaves such a rest of a step long before.
    const NOTHING: f64 = 1e-12;
    // A quantity that is not measured is NaN, which never counts as a change.
    let differ = |a: &[f64], b: &[f64]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > NOTHING);
    let measured = |cycle: &CycleRecord| {
        let (a, b) = (&cycle.trace, &first.trace);
        differ(&a.pose, &b.pose)
            || differ(&a.executed_velocity, &b.executed_velocity)
            || differ(&cycle.inputs.sensor.wrench, &first.inputs.sensor.wrench)
    };
    if cycles.iter().any(measured) {
        return Ok(());
    }
    let sent = |cycle: &CycleRecord| differ(&cycle.trace.sent_velocity, &first.trace.sent_velocity);
    Err(CheckError::NothingChanges {
        name: name.to_owned(),
        rows: cycles.len(),
        from_s: first.trace.time_s,
        to_s: last.trace.time_s,
        remedy: match cycles.iter().any(sent) {
            true => {
                "only what was sent does, and nothing that was measured follows it: map what was measured, in \
                 [executed_velocity], [position], [orientation] or [wrench], or take rows in which it moves"
            }
            false => {
                "take other rows: [rows] of a mapping says which, and `train_share` of its [split] where the test part \
                 begins"
            }
        },
    })
}
