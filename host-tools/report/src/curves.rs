//! Drawing of one series: a thinned line, stairs or markers.

use super::canvas::{SCALE, units};
use super::decimate::{self, Point};
use super::plot::{Chart, Series, Style};
use super::theme::{Hue, Paint};
use anyhow::Result;
use plotters::element::{Circle, PathElement};
use plotters::style::{Color, ShapeStyle};

/// Distance of the points at which a line reports where it passes, in pixels.
const PASSED_EVERY_PX: i32 = 8;

/// Draws the series; returns the places, in drawing units, that it covers.
pub(super) fn draw(
    chart: &mut Chart<'_, '_>,
    series: &Series,
    hue: Hue,
) -> Result<Vec<(i32, i32)>> {
    if series.style == Style::Points {
        return draw_markers(chart, &series.points, hue);
    }
    let y_start = chart.y_range().start;
    let column = |x: f64| i64::from(chart.backend_coord(&(x, y_start)).0 / SCALE);
    let pieces = decimate::line(&series.points, column);
    let mut passed = Vec::new();
    for piece in pieces {
        let piece = if series.style == Style::Step {
            stairs(&piece)
        } else {
            piece
        };
        passed.extend(places(chart, &piece));
        if let [point] = piece[..] {
            let dot = Paint::Hue(hue).solid().filled();
            chart.draw_series([Circle::new(point, units(2.0), dot)])?;
        } else {
            chart.draw_series([PathElement::new(piece, series.style.stroke(hue))])?;
        }
    }
    Ok(passed)
}

fn draw_markers(chart: &mut Chart<'_, '_>, points: &[Point], hue: Hue) -> Result<Vec<(i32, i32)>> {
    let place = |chart: &Chart<'_, '_>, point: Point| chart.backend_coord(&point);
    let kept = decimate::cloud(points, |point| {
        let (x, y) = place(chart, point);
        (i64::from(x / SCALE), i64::from(y / SCALE))
    });
    let passed = kept.iter().map(|&point| place(chart, point)).collect();
    // Translucent, so that a dense place looks denser.
    let style: ShapeStyle = Paint::Hue(hue).solid().mix(0.75).filled();
    chart.draw_series(
        kept.into_iter()
            .map(|point| Circle::new(point, units(2.2), style)),
    )?;
    Ok(passed)
}

/// A line that holds each value until the next point.
fn stairs(points: &[Point]) -> Vec<Point> {
    let holds = points
        .windows(2)
        .flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    holds.chain(points.last().copied()).collect()
}

/// Points along a line, close enough for the legend to see a long stroke between two far points.
fn places(chart: &Chart<'_, '_>, points: &[Point]) -> Vec<(i32, i32)> {
    let corners: Vec<(i32, i32)> = points
        .iter()
        .map(|point| chart.backend_coord(point))
        .collect();
    let strokes = corners.windows(2).flat_map(|pair| {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        let count = (dx.abs().max(dy.abs()) / (PASSED_EVERY_PX * SCALE)).max(1);
        let from = pair[0];
        (0..count).map(move |i| (from.0 + dx * i / count, from.1 + dy * i / count))
    });
    strokes.chain(corners.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stairs_hold_each_value() {
        assert_eq!(
            stairs(&[(0.0, 1.0), (1.0, 3.0), (2.0, 2.0)]),
            [(0.0, 1.0), (1.0, 1.0), (1.0, 3.0), (2.0, 3.0), (2.0, 2.0)]
        );
        assert_eq!(stairs(&[(0.0, 1.0)]), [(0.0, 1.0)]);
    }
}
