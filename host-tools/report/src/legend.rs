//! The legend: which sample stands for which series or window, in lines above the plot, where it hides nothing.

use super::canvas::{Canvas, FONT_PX, Spot, units};
use super::curve::Style;
use super::text;
use super::theme::{Hue, Paint};
use anyhow::Result;
use plotters::style::text_anchor::{HPos, VPos};

/// Height of a line, in pixels.
const LINE_PX: f64 = 17.0;

/// Length of a sample of line, in pixels.
const SAMPLE_PX: f64 = 22.0;

/// Distance between a sample and its name, and below the last line, in pixels.
const PADDING_PX: f64 = 6.0;

/// Distance between a name and the next sample, in pixels.
const GAP_PX: f64 = 18.0;

/// What an entry of the legend stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sample {
    /// A series.
    Series(Style, Hue),
    /// Shaded windows.
    Band(Hue),
}

/// The entries, side by side on as many lines as they need.
pub(super) struct Legend {
    /// Name, sample, pixels from the left and line of each entry.
    entries: Vec<(String, Sample, f64, i32)>,
}

impl Legend {
    /// Lays out the entries that have a name within this width.
    pub(super) fn new(named: Vec<(String, Sample)>, width_px: f64) -> Self {
        let (mut x_px, mut line) = (0.0, 0);
        let mut entries = Vec::new();
        for (name, sample) in named {
            if name.is_empty() {
                continue;
            }
            let limit_px = width_px - SAMPLE_PX - PADDING_PX;
            let name = text::shorten(&text::printable(&name), FONT_PX, limit_px);
            let needed_px = SAMPLE_PX + PADDING_PX + text::width_px(&name, FONT_PX);
            if x_px > 0.0 && x_px + needed_px > width_px {
                (x_px, line) = (0.0, line + 1);
            }
            entries.push((name, sample, x_px, line));
            x_px += needed_px + GAP_PX;
        }
        Self { entries }
    }

    /// Height in pixels.
    pub(super) fn height_px(&self) -> i32 {
        let lines = self.entries.last().map(|(.., line)| f64::from(line + 1));
        lines.map_or(0, |lines| (lines * LINE_PX + PADDING_PX) as i32)
    }

    /// Draws the legend from the left edge down from `top_px`.
    pub(super) fn draw(&self, canvas: &Canvas<'_>, top_px: i32) -> Result<()> {
        for (name, sample, x_px, line) in &self.entries {
            let y = units(f64::from(top_px) + (f64::from(*line) + 0.5) * LINE_PX);
            sample.draw(canvas, (units(*x_px), y))?;
            let at = (units(x_px + SAMPLE_PX + PADDING_PX), y);
            canvas.write(name, Paint::Ink, (HPos::Left, VPos::Center), at)?;
        }
        Ok(())
    }
}

impl Sample {
    fn draw(self, canvas: &Canvas<'_>, (x, y): Spot) -> Result<()> {
        let end = x + units(SAMPLE_PX);
        match self {
            Self::Series(Style::Points, hue) => {
                canvas.dot(((x + end) / 2, y), 3.0, Paint::Hue(hue), 1.0)
            }
            Self::Series(style, hue) => canvas.line([(x, y), (end, y)], style.stroke(hue)),
            Self::Band(hue) => {
                let half = units(5.0);
                canvas.fill([(x, y - half), (end, y + half)], Paint::Hue(hue), 0.35)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_wrap() {
        let legend = |width_px| {
            let names = ["measured", "", "model", "noise"];
            let named = names.map(|name| (name.to_owned(), Sample::Band(Hue::Blue)));
            Legend::new(named.into(), width_px)
        };
        let lines = |width_px| -> Vec<i32> {
            let entries = legend(width_px).entries;
            entries.iter().map(|(.., line)| *line).collect()
        };
        assert_eq!(lines(800.0), [0, 0, 0]);
        assert_eq!(lines(200.0), [0, 0, 1]);
        assert_eq!(lines(0.0), [0, 1, 2]);
        assert!(legend(200.0).height_px() > legend(800.0).height_px());
        assert_eq!(Legend::new(Vec::new(), 800.0).height_px(), 0);
    }
}
