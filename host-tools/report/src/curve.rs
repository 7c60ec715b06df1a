//! A curve, and how it is drawn with no more points than a screen can show.
//!
//! A recording has ten to a hundred points per pixel column. Drawing first, lowest, highest and last of each column
//! gives the same pixels as drawing all, so that a peak of one cycle survives.

use super::axis::LARGEST;
use super::canvas::{Canvas, SCALE, Spot, units};
use super::frame::Frame;
use super::theme::{Hue, Paint};
use anyhow::Result;
use plotters::style::{Color, ShapeStyle};
use std::collections::HashSet;

/// Markers of a cloud of points.
const MAX_MARKERS: usize = 1000;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A solid line from point to point.
    Line,
    /// A marker per point.
    Points,
    /// A line that holds each value until the next point, as a sampled command does.
    Step,
    /// A dashed line, for predictions, limits and references.
    Dashed,
}

impl Style {
    /// Stroke of a line in this style.
    pub(super) fn stroke(self, hue: Hue) -> ShapeStyle {
        let paint = Paint::Hue(hue);
        let color = if self == Self::Dashed {
            paint.dashed()
        } else {
            paint.solid()
        };
        color.stroke_width(units(1.6).unsigned_abs())
    }
}

/// A named curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend; without a name the series does not appear there.
    pub name: String,
    /// Points in the units of the axes. A point that is not finite makes a gap.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
    /// Colour; by default the next of the palette.
    pub color: Option<Hue>,
}

impl Series {
    /// A series in the given style and the next colour.
    pub fn new(name: impl Into<String>, style: Style, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: name.into(),
            points,
            style,
            color: None,
        }
    }

    /// A solid line.
    pub fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(name, Style::Line, points)
    }

    /// A dashed line.
    pub fn dashed(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(name, Style::Dashed, points)
    }

    /// The same series in this colour.
    #[must_use]
    pub fn colored(mut self, hue: Hue) -> Self {
        self.color = Some(hue);
        self
    }

    /// The points that can be drawn.
    pub(super) fn drawable(&self) -> impl Iterator<Item = &(f64, f64)> {
        self.points.iter().filter(|point| drawable(point))
    }

    /// Draws the series.
    pub(super) fn draw(&self, canvas: &Canvas<'_>, frame: &Frame, hue: Hue) -> Result<()> {
        if self.style == Style::Points {
            let cloud = self.drawable().map(|point| frame.at(*point)).collect();
            for at in thin_cloud(cloud) {
                // Translucent, so that a dense place looks denser.
                canvas.dot(at, 2.2, Paint::Hue(hue), 0.75)?;
            }
            return Ok(());
        }
        let on_screen = self.points.split(|point| !drawable(point));
        let on_screen = on_screen.map(|piece| piece.iter().map(|p| frame.at(*p)).collect());
        for piece in thin_line(on_screen) {
            match piece[..] {
                [at] => canvas.dot(at, 2.0, Paint::Hue(hue), 1.0)?,
                _ if self.style == Style::Step => {
                    canvas.line(stairs(&piece), self.style.stroke(hue))?;
                }
                _ => canvas.line(piece, self.style.stroke(hue))?,
            }
        }
        Ok(())
    }
}

fn drawable(point: &(f64, f64)) -> bool {
    point.0.abs() <= LARGEST && point.1.abs() <= LARGEST
}

/// A line that holds each value until the next point.
fn stairs(points: &[Spot]) -> Vec<Spot> {
    let holds = points
        .windows(2)
        .flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    holds.chain(points.last().copied()).collect()
}

/// The column of pixels on which a point falls.
fn column(spot: &Spot) -> i32 {
    spot.0 / SCALE
}

/// Joins the pieces of a line where the gap between them cannot be seen, and thins each.
fn thin_line(pieces: impl Iterator<Item = Vec<Spot>>) -> Vec<Vec<Spot>> {
    let mut joined: Vec<Vec<Spot>> = Vec::new();
    for piece in pieces {
        let Some(start) = piece.first().map(column) else {
            continue;
        };
        match joined.last_mut() {
            Some(last)
                if last
                    .last()
                    .is_some_and(|end| (start - column(end)).abs() <= 1) =>
            {
                last.extend(piece);
            }
            _ => joined.push(piece),
        }
    }
    let thin = |piece: Vec<Spot>| {
        piece
            .chunk_by(|a, b| column(a) == column(b))
            .flat_map(outline)
            .collect()
    };
    joined.into_iter().map(thin).collect()
}

/// First, lowest, highest and last of the points of a column, in their order.
fn outline(points: &[Spot]) -> Vec<Spot> {
    let indices = 0..points.len();
    let lowest = indices.clone().min_by_key(|&index| points[index].1);
    let highest = indices.max_by_key(|&index| points[index].1);
    let mut kept: Vec<usize> = [0, points.len() - 1]
        .into_iter()
        .chain(lowest)
        .chain(highest)
        .collect();
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|index| points[index]).collect()
}

/// Thins points to one marker per cell of a grid, which is coarsened until few enough remain. An isolated point always stays.
fn thin_cloud(mut points: Vec<Spot>) -> Vec<Spot> {
    let mut cell = SCALE;
    while points.len() > MAX_MARKERS {
        cell *= 2;
        let mut seen = HashSet::new();
        points.retain(|(x, y)| seen.insert((x / cell, y / cell)));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn stairs_hold_each_value() {
        assert_eq!(
            stairs(&[(0, 1), (1, 3), (2, 2)]),
            [(0, 1), (1, 1), (1, 3), (2, 3), (2, 2)]
        );
        assert_eq!(stairs(&[(0, 1)]), [(0, 1)]);
    }

    #[test]
    fn a_peak_of_one_sample_survives() {
        let mut points: Vec<Spot> = (0..15_000).map(|i| (i / 5, 0)).collect();
        points[7_321].1 = 5;
        points[7_322].1 = -6;
        let thinned = thin_line([points.clone()].into_iter());
        assert_eq!(thinned.len(), 1);
        assert!(thinned[0].len() <= 4 * 751);
        assert!(thinned[0].contains(&points[7_321]) && thinned[0].contains(&points[7_322]));
    }

    #[test]
    fn only_a_gap_that_can_be_seen_splits_a_line() {
        let at = |px: i32| (px * SCALE, 0);
        let pieces = [vec![at(0), at(1)], vec![], vec![at(2)], vec![at(9)]];
        assert_eq!(
            thin_line(pieces.into_iter()),
            [vec![at(0), at(1), at(2)], vec![at(9)]]
        );
    }

    proptest! {
        #[test]
        fn a_cloud_stays_small_and_keeps_what_stands_alone(cloud in proptest::collection::vec((0..2400, 0..800), 2000)) {
            let alone = (3000, 3000);
            let kept = thin_cloud(cloud.into_iter().chain([alone]).collect());
            prop_assert!(kept.len() <= MAX_MARKERS && kept.contains(&alone));
        }
    }
}
