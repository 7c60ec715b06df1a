//! The frame of a plot: maps data to drawing units.

use super::axis::Axis;
use super::canvas::Spot;
use std::ops::Range;

/// The two axes and the position of the frame between them, in drawing units.
pub(super) struct Frame {
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) columns: Range<i32>,
    pub(super) rows: Range<i32>,
}

impl Frame {
    /// Position of a data point.
    pub(super) fn at(&self, (x, y): (f64, f64)) -> Spot {
        let along = |part: f64, pixels: &Range<i32>| part * f64::from(pixels.end - pixels.start);
        (
            self.columns.start + along(self.x.part(x), &self.columns).round() as i32,
            self.rows.end - along(self.y.part(y), &self.rows).round() as i32,
        )
    }
}
