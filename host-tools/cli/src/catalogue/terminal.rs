//! Pictures in characters: a curve in Braille dots over a dotted reference.
//!
//! Each character holds two by four dots, so that a curve of 64 by 12 characters has a resolution
//! of 128 by 48. The curve without the effect is drawn in whole characters (`·`) below it; where
//! only the Braille curve is seen, the two are the same.

use super::picture::Picture;
use drawille::Canvas;
use softdock_report::number::significant;
use std::fmt::Write;

/// Characters of the plotting area.
const COLUMNS: usize = 64;
const ROWS: usize = 12;
/// Dots of the plotting area, two by four in a character.
const DOTS: (u32, u32) = (2 * COLUMNS as u32, 4 * ROWS as u32);
/// Width of the labels of y, characters.
const LABEL: usize = 9;

/// Smallest and largest finite value, widened where they coincide.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low < high {
        (low, high)
    } else if low.is_finite() {
        (low - 1.0, low + 1.0)
    } else {
        (0.0, 1.0)
    }
}

/// A curve within the ranges `x` and `y`, as rows of Braille characters.
fn braille(points: &[(f64, f64)], x: (f64, f64), y: (f64, f64)) -> Vec<String> {
    let along = |value: f64, (low, high): (f64, f64), dots: u32| {
        ((value - low) / (high - low) * f64::from(dots - 1)).round() as u32
    };
    let place = |point: (f64, f64)| {
        let down = DOTS.1 - 1 - along(point.1, y, DOTS.1);
        (along(point.0, x, DOTS.0), down)
    };
    // A canvas takes the indices of its last dot, not its size.
    let mut canvas = Canvas::new(DOTS.0 - 1, DOTS.1 - 1);
    for pair in points.windows(2) {
        if pair.iter().all(|(x, y)| x.is_finite() && y.is_finite()) {
            let (from, to) = (place(pair[0]), place(pair[1]));
            canvas.line(from.0, from.1, to.0, to.1);
        }
    }
    canvas.rows()
}

/// The picture as lines of text.
pub(super) fn draw(picture: &Picture) -> String {
    let points = || picture.without.iter().chain(&picture.with);
    let (x, y) = (
        range(points().map(|point| point.0)),
        range(points().map(|point| point.1)),
    );
    let [without, with] = [&picture.without, &picture.with].map(|curve| braille(curve, x, y));
    let mut text = format!("{:LABEL$} {}\n", "", picture.y_label);
    for (row, (without, with)) in without.iter().zip(&with).enumerate() {
        let label = match row {
            0 => significant(y.1, 3),
            _ if row == ROWS - 1 => significant(y.0, 3),
            _ => String::new(),
        };
        let cells = without.chars().zip(with.chars());
        let line: String = cells
            .map(|cell| match cell {
                (' ', ' ') => ' ',
                (_, ' ') => '·',
                (_, dots) => dots,
            })
            .collect();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{label:>LABEL$} │{}", line.trim_end());
    }
    let _ = writeln!(text, "{:LABEL$} └{}", "", "─".repeat(COLUMNS));
    let (first, last) = (significant(x.0, 3), significant(x.1, 3));
    let between = COLUMNS.saturating_sub(first.len() + last.len());
    let _ = writeln!(
        text,
        "{:LABEL$}  {first}{:^between$}{last}",
        "", picture.x_label
    );
    let _ = writeln!(
        text,
        "{:LABEL$}  · without\n{:LABEL$}  ⠤ with {}",
        "", "", picture.size
    );
    text
}
