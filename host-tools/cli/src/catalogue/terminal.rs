//! Pictures in characters: a curve in Braille dots over a dotted reference.
//!
//! Each character holds two by four dots, so that a curve of 64 by 12 characters has a resolution
//! of 128 by 48. The curve without the effect is drawn in whole characters (`·`) below it; where
//! only the Braille curve is seen, the two are the same.

use super::picture::Picture;
use softdock_report::number::significant;
use std::fmt::Write;

/// Characters of the plotting area.
const COLUMNS: usize = 64;
const ROWS: usize = 12;
/// Dots of a character.
const DOTS_ACROSS: usize = 2;
const DOTS_DOWN: usize = 4;
/// Width of the labels of y, characters.
const LABEL: usize = 9;
/// First character of the Braille block: no dot.
const BRAILLE: u32 = 0x2800;
/// Bits of the dots of a character, by row and column (Unicode 15, chapter 21.1).
const DOT_BITS: [[u8; DOTS_ACROSS]; DOTS_DOWN] =
    [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];

/// What is drawn in one character.
#[derive(Clone, Copy, Default)]
struct Cell {
    dots: u8,
    has_reference: bool,
}

impl Cell {
    fn character(self) -> char {
        match self {
            Self {
                dots: 0,
                has_reference: true,
            } => '·',
            Self { dots: 0, .. } => ' ',
            Self { dots, .. } => char::from_u32(BRAILLE + u32::from(dots)).unwrap_or('?'),
        }
    }
}

/// Smallest and largest finite value, apart by at least a little.
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

/// The plotting area.
struct Canvas {
    cells: [[Cell; COLUMNS]; ROWS],
    x: (f64, f64),
    y: (f64, f64),
}

impl Canvas {
    /// Position in dots from the lower left corner.
    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let along = |value: f64, (low, high): (f64, f64), dots: usize| {
            (value - low) / (high - low) * (dots - 1) as f64
        };
        (
            along(x, self.x, COLUMNS * DOTS_ACROSS),
            along(y, self.y, ROWS * DOTS_DOWN),
        )
    }

    /// Calls `mark` for the cell of each dot on the way from point to point, with the dot's bit.
    fn trace(&mut self, points: &[(f64, f64)], mark: impl Fn(&mut Cell, u8)) {
        for pair in points.windows(2) {
            let ((x0, y0), (x1, y1)) = (self.place(pair[0]), self.place(pair[1]));
            if !(x0.is_finite() && y0.is_finite() && x1.is_finite() && y1.is_finite()) {
                continue;
            }
            let dots = (x1 - x0).abs().max((y1 - y0).abs()).ceil().max(1.0);
            for k in 0..=dots as usize {
                let share = k as f64 / dots;
                let column = (x0 + share * (x1 - x0)).round() as usize;
                let row = ROWS * DOTS_DOWN - 1 - (y0 + share * (y1 - y0)).round() as usize;
                let bit = DOT_BITS[row % DOTS_DOWN][column % DOTS_ACROSS];
                mark(&mut self.cells[row / DOTS_DOWN][column / DOTS_ACROSS], bit);
            }
        }
    }
}

/// The picture as lines of text.
pub(super) fn draw(picture: &Picture) -> String {
    let points = || picture.without.iter().chain(&picture.with);
    let mut canvas = Canvas {
        cells: [[Cell::default(); COLUMNS]; ROWS],
        x: range(points().map(|point| point.0)),
        y: range(points().map(|point| point.1)),
    };
    canvas.trace(&picture.without, |cell, _| cell.has_reference = true);
    canvas.trace(&picture.with, |cell, bit| cell.dots |= bit);
    let mut text = format!("{:LABEL$} {}\n", "", picture.y_label);
    let (low, high) = canvas.y;
    for (row, cells) in canvas.cells.iter().enumerate() {
        let label = match row {
            0 => significant(high, 3),
            _ if row == ROWS - 1 => significant(low, 3),
            _ => String::new(),
        };
        let line: String = cells.iter().map(|cell| cell.character()).collect();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{label:>LABEL$} │{}", line.trim_end());
    }
    let _ = writeln!(text, "{:LABEL$} └{}", "", "─".repeat(COLUMNS));
    let (first, last) = (significant(canvas.x.0, 3), significant(canvas.x.1, 3));
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
