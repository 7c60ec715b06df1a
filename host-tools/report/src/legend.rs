//! The legend: which mark is which series, at the place in the plot where it hides least.

use super::canvas::{self, Area, FONT_PX, SCALE, units};
use super::plot::Style;
use super::text;
use super::theme::{Hue, Paint};
use anyhow::Result;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

/// Height of a row, in pixels.
const ROW_PX: f64 = 17.0;

/// Length of the sample of line, in pixels.
const SAMPLE_PX: f64 = 22.0;

/// Distance between the frame and its content, and from the corner of the plot, in pixels.
const PADDING_PX: f64 = 6.0;

/// Largest part of the plot's width that a legend takes.
const LARGEST_PART: f64 = 0.6;

/// Places along an edge that are tried.
const STEPS_ALONG_EDGE: i32 = 16;

/// What a row of the legend stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sample {
    /// A series.
    Series(Style, Hue),
    /// Shaded windows.
    Band(Hue),
}

/// A rectangle in drawing units, absolute in the drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rect {
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) right: i32,
    pub(super) bottom: i32,
}

impl Rect {
    fn contains(&self, (x, y): (i32, i32)) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }

    /// How many of the points lie inside.
    fn covered(&self, points: &[(i32, i32)]) -> usize {
        points.iter().filter(|point| self.contains(**point)).count()
    }

    fn sized(left: i32, top: i32, (width, height): (i32, i32)) -> Self {
        Self {
            left,
            top,
            right: left + width,
            bottom: top + height,
        }
    }
}

/// Draws the rows at the upper or lower edge of `frame`, where they cover the fewest of the `occupied` points.
///
/// Returns whether they cover any.
pub(super) fn draw(
    area: &Area<'_>,
    frame: Rect,
    rows: &[(String, Sample)],
    occupied: &[(i32, i32)],
) -> Result<bool> {
    if rows.is_empty() {
        return Ok(false);
    }
    let frame_width_px = f64::from(frame.right - frame.left) / f64::from(SCALE);
    let limit_px = frame_width_px * LARGEST_PART - SAMPLE_PX - 3.0 * PADDING_PX;
    let names: Vec<String> = rows
        .iter()
        .map(|(name, _)| text::shorten(&text::printable(name), FONT_PX, limit_px))
        .collect();
    let name_px = names
        .iter()
        .map(|name| text::width_px(name, FONT_PX))
        .fold(0.0, f64::max);
    let size = (
        units(name_px + SAMPLE_PX + 3.0 * PADDING_PX),
        units(rows.len() as f64 * ROW_PX + PADDING_PX),
    );
    let place = emptiest_place(frame, size, occupied);
    area.draw(&Rectangle::new(
        [(place.left, place.top), (place.right, place.bottom)],
        Paint::Panel.solid().mix(0.86).filled(),
    ))?;
    let style = canvas::font(FONT_PX, Paint::Ink, HPos::Left, VPos::Center);
    for (row, (name, (_, sample))) in names.iter().zip(rows).enumerate() {
        let y = place.top + units(PADDING_PX / 2.0 + (row as f64 + 0.5) * ROW_PX);
        let x = place.left + units(PADDING_PX);
        draw_sample(area, *sample, (x, y))?;
        area.draw_text(name, &style, (x + units(SAMPLE_PX + PADDING_PX), y))?;
    }
    Ok(place.covered(occupied) > 0)
}

/// Height in pixels of [`draw_above`].
pub(super) fn height_above(rows: &[(String, Sample)], width_px: f64) -> i32 {
    let lines = places_above(rows, width_px)
        .last()
        .map_or(0, |last| last.1 + 1);
    (f64::from(lines) * ROW_PX + PADDING_PX) as i32
}

/// Draws the rows side by side on as many lines as they need, from `(left, top)` in drawing units.
pub(super) fn draw_above(
    area: &Area<'_>,
    (left, top): (i32, i32),
    rows: &[(String, Sample)],
    width_px: f64,
) -> Result<()> {
    let style = canvas::font(FONT_PX, Paint::Ink, HPos::Left, VPos::Center);
    for ((name, sample), (x_px, line)) in rows.iter().zip(places_above(rows, width_px)) {
        let at = (
            left + units(x_px),
            top + units((f64::from(line) + 0.5) * ROW_PX),
        );
        draw_sample(area, *sample, at)?;
        let name = name_above(name, width_px);
        area.draw_text(&name, &style, (at.0 + units(SAMPLE_PX + PADDING_PX), at.1))?;
    }
    Ok(())
}

/// Where each row begins above the plot: pixels from the left, and line.
fn places_above(rows: &[(String, Sample)], width_px: f64) -> Vec<(f64, i32)> {
    let (mut x_px, mut line) = (0.0, 0);
    let mut places = Vec::new();
    for (name, _) in rows {
        let needed = SAMPLE_PX + PADDING_PX + text::width_px(&name_above(name, width_px), FONT_PX);
        if x_px > 0.0 && x_px + needed > width_px {
            (x_px, line) = (0.0, line + 1);
        }
        places.push((x_px, line));
        x_px += needed + 3.0 * PADDING_PX;
    }
    places
}

fn name_above(name: &str, width_px: f64) -> String {
    let limit_px = width_px - SAMPLE_PX - PADDING_PX;
    text::shorten(&text::printable(name), FONT_PX, limit_px)
}

fn draw_sample(area: &Area<'_>, sample: Sample, (x, y): (i32, i32)) -> Result<()> {
    let end = x + units(SAMPLE_PX);
    match sample {
        Sample::Series(Style::Points, hue) => {
            let marker = Paint::Hue(hue).solid().filled();
            area.draw(&Circle::new(((x + end) / 2, y), units(3.0), marker))?;
        }
        Sample::Series(style, hue) => {
            area.draw(&PathElement::new([(x, y), (end, y)], style.stroke(hue)))?;
        }
        Sample::Band(hue) => {
            let half = units(5.0);
            let fill = Paint::Hue(hue).solid().mix(0.35).filled();
            area.draw(&Rectangle::new([(x, y - half), (end, y + half)], fill))?;
        }
    }
    Ok(())
}

/// The place along the upper or lower edge that covers the fewest points; corners first, where they are as good.
fn emptiest_place(frame: Rect, size: (i32, i32), occupied: &[(i32, i32)]) -> Rect {
    let gap = units(PADDING_PX);
    let (left, right) = (frame.left + gap, frame.right - gap - size.0);
    let (top, bottom) = (frame.top + gap, frame.bottom - gap - size.1);
    let between =
        (1..STEPS_ALONG_EDGE).map(|step| right - (right - left) * step / STEPS_ALONG_EDGE);
    [right, left]
        .into_iter()
        .chain(between)
        .flat_map(|x| [Rect::sized(x, top, size), Rect::sized(x, bottom, size)])
        .min_by_key(|place| place.covered(occupied))
        .unwrap_or(Rect::sized(right, top, size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_above_the_plot_wrap() {
        let rows =
            ["measured", "model", "noise"].map(|name| (name.to_owned(), Sample::Band(Hue::Blue)));
        let lines = |width_px| -> Vec<i32> {
            let places = places_above(&rows, width_px);
            places.iter().map(|place| place.1).collect()
        };
        assert_eq!(lines(800.0), [0, 0, 0]);
        assert_eq!(lines(200.0), [0, 0, 1]);
        assert_eq!(lines(0.0), [0, 1, 2]);
        assert!(height_above(&rows, 200.0) > height_above(&rows, 800.0));
    }

    #[test]
    fn the_legend_avoids_the_data() {
        let frame = Rect {
            left: 0,
            top: 0,
            right: 1000,
            bottom: 1000,
        };
        let free = emptiest_place(frame, (200, 100), &[]);
        assert_eq!((free.right, free.top), (976, 24));
        let moved = emptiest_place(
            frame,
            (200, 100),
            &[(900, 60), (100, 60), (600, 60), (900, 950)],
        );
        assert_eq!((moved.left, moved.bottom), (24, 976));
    }
}
