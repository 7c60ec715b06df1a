//! The regime that explains an error: the range of a velocity, position, load, time or frequency in which it shows, and how it
//! depends on that.

mod candidates;
mod evaluate;
mod frequency;
mod words;

use super::Source;
use super::motion::Motion;
use super::series::Series;
use candidates::Candidate;
pub use frequency::Spectrum;
use serde::Serialize;
use softdock_physics::model::{Axis, Channel};
pub(super) use words::quantity;

/// Probability of any false regime among all that are tested for a recording.
const LEVEL: f64 = 0.01;
/// Least share of the error without its offset that a regime has to explain ...
const EXPLAINS: f64 = 0.25;
/// ... least share of the whole error ...
const MATTERS: f64 = 0.02;
/// ... and, of an interval, least difference between its shares of the error and of the time.
const PLACE_GAIN: f64 = 0.3;

/// What an error may depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Velocity of M, with its sign.
    Velocity,
    /// Position of M.
    Position,
    /// Rotation of M from its first pose.
    Orientation,
    /// Load that the model expects on the sensor beyond that of free flight.
    Force,
    /// Change of the velocity of M per second.
    Acceleration,
    /// Time in the recording.
    TimeInRun,
    /// Time since the last contact began.
    TimeSinceContact,
    /// Frequency of the error itself.
    Frequency,
}

impl Quantity {
    /// Whether its absolute value is a quantity of its own, as speed is.
    fn has_size(self) -> bool {
        matches!(self, Self::Velocity | Self::Acceleration | Self::Force)
    }
}

/// How an error depends on a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Dependence {
    /// The mean error depends on it.
    Mean,
    /// The size of the error does; the mean is much smaller.
    Size,
    /// It swings in a band of frequencies.
    Band,
}

/// Error of the cycles in one interval of the quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Lower end, in the quantity's unit.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Mean of the quantity; in a band of frequencies its middle.
    pub centre: f64,
    /// Cycles in it; 0 in a band of frequencies.
    pub cycles: usize,
    /// Mean error, in the channel's unit.
    pub mean: f64,
    /// Standard deviation of the error about this mean, in the channel's unit.
    pub spread: f64,
    /// Root mean square of the error over the noise to expect.
    pub rms_sigma: f64,
    /// Part of the axis' error beyond the noise, 0 to 1.
    pub share: f64,
}

/// A stretch of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end, in the quantity's unit.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Part of the recorded time that the quantity spends there, 0 to 1.
    pub time_share: f64,
}

/// A quantity, and the error of one axis along it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Regime {
    /// Channel of the error.
    pub channel: Channel,
    /// Axis of the error.
    pub axis: Axis,
    /// Quantity on which it may depend.
    pub variable: Quantity,
    /// Axis of this quantity; None for times and frequencies.
    pub along: Option<Axis>,
    /// SI unit of the quantity.
    pub unit: &'static str,
    /// Only cycles in contact are sorted by the quantity; the others count as one more bin.
    pub in_contact: bool,
    /// Cycles are sorted by the size of the quantity, without its sign.
    pub absolute: bool,
    /// How the error depends on the quantity.
    pub dependence: Dependence,
    /// Share of the error beyond the noise for which the quantity accounts, 0 to 1, without a constant offset.
    pub share: f64,
    /// Part of the error beyond the noise that a constant offset accounts for, 0 to 1.
    pub offset_share: f64,
    /// That offset, in the channel's unit.
    pub offset: f64,
    /// Where most of the error is, if its size depends on the quantity; of a frequency its band.
    pub at: Option<Interval>,
    /// Probability of at least this share by chance, given the correlation of the error in time.
    pub p: f64,
    /// Significant at 1 % over all regimes that were tried.
    pub significant: bool,
    /// The error along the quantity.
    pub bins: Vec<Bin>,
}

impl Regime {
    /// Whether it explains the error well enough to be the first thing said of it.
    pub fn explains(&self) -> bool {
        let gain = self.at.map_or(1.0, |at| self.share - at.time_share);
        let is_place = self.dependence == Dependence::Size;
        self.significant
            && self.share >= MATTERS
            && self.share_beside_offset() >= EXPLAINS
            && (!is_place || gain >= PLACE_GAIN)
    }

    /// Its share of the error beyond the noise that an offset leaves.
    pub fn share_beside_offset(&self) -> f64 {
        beside_offset(self.share, self.offset_share)
    }
}

/// All quantities with which errors are compared.
pub(super) struct Regimes<'a> {
    source: &'a Source<'a>,
    candidates: Vec<Candidate>,
    level: f64,
}

impl<'a> Regimes<'a> {
    /// Prepares the quantities of a recording. `axes`: number of errors that will be compared with them.
    pub(super) fn new(
        source: &'a Source<'a>,
        motion: &Motion,
        contacts: &[std::ops::Range<usize>],
        axes: usize,
    ) -> Self {
        let candidates = candidates::all(source, motion, contacts);
        let tries = axes.max(1) * (2 * candidates.len() + 1);
        Self {
            source,
            candidates,
            level: LEVEL / tries as f64,
        }
    }

    /// Regimes of the error of an axis, one for each kind of quantity, the best first.
    pub(super) fn of(&self, series: &Series) -> Vec<Regime> {
        evaluate::ranked(self.source, &self.candidates, series, self.level)
    }
}

/// Converts a share of the error to a share of what an offset leaves of it.
fn beside_offset(share: f64, offset_share: f64) -> f64 {
    (share / (1.0 - offset_share).max(MATTERS)).min(1.0)
}
