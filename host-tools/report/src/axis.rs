//! A linear axis: data range, ticks and label, in the form that plotters lays out.

use super::ticks::Ticks;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// A linear axis over a range that is finite and not empty.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    range: Range<f64>,
    pub(super) ticks: Ticks,
}

impl Axis {
    /// An axis with about `wanted` ticks.
    pub(super) fn new(range: Range<f64>, wanted: usize) -> Self {
        let ticks = Ticks::new(&range, wanted);
        Self { range, ticks }
    }

    /// Whether zero lies inside, not only at an end.
    pub(super) fn spans_zero(&self) -> bool {
        self.range.start < 0.0 && self.range.end > 0.0
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let part = (value - self.range.start) / (self.range.end - self.range.start);
        limit.0 + (part * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            Vec::new()
        } else {
            self.ticks.values.clone()
        }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.label(*value)
    }
}
