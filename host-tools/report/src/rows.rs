//! A drawing of labelled rows, each with a horizontal bar and its value: what bar charts, waterfalls and interval charts
//! share.

use super::axis;
use super::surface::{self as canvas, Area, FONT_PX, SCALE, units};
use super::text;
use super::theme::{Hue, Paint};
use anyhow::Result;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;

/// Height of a row, in pixels.
const ROW_PX: f64 = 25.0;

/// Half the thickness of a bar, in pixels.
const HALF_BAR_PX: f64 = 7.0;

/// Middle and half the thickness of the thin bar below the main one, in pixels from the middle of the row.
const THIN_BAR_PX: (f64, f64) = (7.5, 1.5);

/// By how much the main bar moves up and gets slimmer when a thin one stands below it, in pixels.
const BAR_MAKES_ROOM_PX: f64 = 2.0;

/// Height of the line that names the values, in pixels.
const HEADER_PX: f64 = 20.0;

/// Space at the edges and between the columns, in pixels.
const GAP_PX: f64 = 12.0;

/// Width of a sample of bar in the legend, in pixels.
const NAME_SAMPLE_PX: f64 = 16.0;

/// Largest part of the width that labels take; longer ones are shortened.
const LARGEST_LABEL_PART: f64 = 0.4;

/// Rows that are drawn; the number of the others is said.
const MAX_ROWS: usize = 200;

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) label: String,
    /// Text in the column at the right.
    pub(super) value: String,
    /// Start and end of the bar, in the unit of the values; `None` for a value that cannot be drawn.
    pub(super) bar: Option<(f64, f64)>,
    /// Start and end of the thin bar below it, for the same quantity on other data.
    pub(super) thin_bar: Option<(f64, f64)>,
    /// Ends of an uncertainty interval.
    pub(super) interval: Option<(f64, f64)>,
    /// A dot, in the unit of the values.
    pub(super) dot: Option<f64>,
    pub(super) paint: Paint,
}

/// The rows and what they have in common.
pub(super) struct RowChart<'a> {
    pub(super) title: &'a str,
    /// Name of the values, written above their column.
    pub(super) value_label: &'a str,
    /// What the main and the thin bars stand for.
    pub(super) names: Option<&'a [String; 2]>,
    pub(super) rows: Vec<Row>,
    /// Whether the end of each bar is tied to the next row.
    pub(super) connected: bool,
    /// Width in pixels.
    pub(super) width: u32,
}

/// Where the columns are, in pixels, and what the bars span.
struct Layout {
    top: f64,
    bars: Range<f64>,
    values_right: f64,
    span: Range<f64>,
}

impl Layout {
    /// Horizontal position of a value, in drawing units.
    fn x(&self, value: f64) -> i32 {
        let value = value.clamp(self.span.start, self.span.end);
        let part = (value - self.span.start) / (self.span.end - self.span.start);
        units(self.bars.start + part * (self.bars.end - self.bars.start))
    }

    /// Middle of a row, in drawing units.
    fn y(&self, row: usize) -> i32 {
        units(self.top + (row as f64 + 0.5) * ROW_PX)
    }
}

impl RowChart<'_> {
    /// The rows as one SVG element, as high as they need.
    pub(super) fn to_svg(&self) -> Result<String> {
        let width = self.width.clamp(320, 4000);
        let title_px = f64::from(canvas::title_height(self.title, width));
        let rows = self.rows.len().clamp(1, MAX_ROWS + 1) as f64;
        let height = title_px + HEADER_PX + rows * ROW_PX + GAP_PX / 2.0;
        canvas::draw(self.title, (width, height as u32), |area| {
            self.draw_on(area)
        })
    }

    fn draw_on(&self, area: &Area<'_>) -> Result<()> {
        let title_px = canvas::title(area, self.title)?;
        let layout = self.layout(area, f64::from(title_px));
        let header = canvas::font(FONT_PX, Paint::Muted, HPos::Right, VPos::Center);
        let header_at = (
            units(layout.values_right),
            units(layout.top - HEADER_PX / 2.0),
        );
        area.draw_text(&text::printable(self.value_label), &header, header_at)?;
        if let Some(names) = self.names {
            draw_names(area, (layout.x(layout.span.start), header_at.1), names)?;
        }
        let middle = (layout.x(0.0), layout.y(0));
        if self.rows.is_empty() {
            let style = canvas::font(FONT_PX, Paint::Muted, HPos::Left, VPos::Center);
            return Ok(area.draw_text("no data", &style, middle)?);
        }
        for (index, row) in self.rows.iter().take(MAX_ROWS).enumerate() {
            draw_row(area, &layout, index, row)?;
            let next = self.rows.get(index + 1).filter(|_| index + 1 < MAX_ROWS);
            if let (true, Some((_, end)), Some(_)) = (self.connected, row.bar, next) {
                draw_connector(area, &layout, index, end)?;
            }
        }
        let drawn = self.rows.len().min(MAX_ROWS);
        let bottom = layout.y(drawn) - units(ROW_PX / 2.0);
        let zero = [(middle.0, units(layout.top)), (middle.0, bottom)];
        area.draw(&PathElement::new(
            zero,
            Paint::Muted.solid().stroke_width(SCALE.unsigned_abs()),
        ))?;
        if self.rows.len() > drawn {
            let style = canvas::font(FONT_PX, Paint::Muted, HPos::Left, VPos::Center);
            let note = format!("and {} more", self.rows.len() - drawn);
            area.draw_text(&note, &style, (layout.x(0.0), layout.y(drawn)))?;
        }
        Ok(())
    }

    fn layout(&self, area: &Area<'_>, title_px: f64) -> Layout {
        let width = f64::from(area.dim_in_pixel().0) / f64::from(SCALE);
        let widest = |texts: &mut dyn Iterator<Item = &String>| {
            texts
                .map(|text| text::width_px(text, FONT_PX))
                .fold(0.0, f64::max)
        };
        let label_px =
            widest(&mut self.rows.iter().map(|row| &row.label)).min(width * LARGEST_LABEL_PART);
        let value_px = widest(&mut self.rows.iter().map(|row| &row.value)).min(width * 0.3);
        let ends = self
            .rows
            .iter()
            .flat_map(|row| [row.bar, row.thin_bar, row.interval])
            .flatten();
        // Bars stand on the edge, caps of intervals do not.
        let margin = if self.rows.iter().any(|row| row.dot.is_some()) {
            0.02
        } else {
            0.0
        };
        let span = axis::range_of(ends.flat_map(|(from, to)| [from, to]).chain([0.0]), margin);
        let values_right = width - 2.0;
        let bars_left = label_px + GAP_PX;
        let bars_right = (values_right - value_px - GAP_PX).max(bars_left + 20.0);
        Layout {
            top: title_px + HEADER_PX,
            bars: bars_left..bars_right,
            values_right,
            span,
        }
    }
}

fn draw_row(area: &Area<'_>, layout: &Layout, index: usize, row: &Row) -> Result<()> {
    let y = layout.y(index);
    let label_px = layout.bars.start - GAP_PX;
    let label = text::shorten(&text::printable(&row.label), FONT_PX, label_px.max(40.0));
    let label_style = canvas::font(FONT_PX, Paint::Ink, HPos::Right, VPos::Center);
    area.draw_text(
        &label,
        &label_style,
        (units(layout.bars.start - GAP_PX / 2.0), y),
    )?;
    let value_style = canvas::font(FONT_PX, Paint::Ink, HPos::Right, VPos::Center);
    area.draw_text(
        &row.value.replace('-', "−"),
        &value_style,
        (units(layout.values_right), y),
    )?;
    if let Some((from, to)) = row.bar {
        let (left, right) = (layout.x(from.min(to)), layout.x(from.max(to)));
        let (up, half) = match row.thin_bar {
            Some(_) => (
                units(BAR_MAKES_ROOM_PX),
                units(HALF_BAR_PX - BAR_MAKES_ROOM_PX),
            ),
            None => (0, units(HALF_BAR_PX)),
        };
        // A share too small to see still leaves a line.
        let corners = [
            (left, y - up - half),
            (right.max(left + SCALE), y - up + half),
        ];
        area.draw(&Rectangle::new(
            corners,
            row.paint.solid().mix(0.85).filled(),
        ))?;
    }
    if let Some((from, to)) = row.thin_bar {
        let (left, right) = (layout.x(from.min(to)), layout.x(from.max(to)));
        draw_thin_bar(area, (left, right.max(left + SCALE)), y)?;
    }
    if let Some((low, high)) = row.interval {
        draw_whisker(area, (layout.x(low), layout.x(high)), y)?;
    }
    if let Some(value) = row.dot {
        let dot = Circle::new((layout.x(value), y), units(4.0), row.paint.solid().filled());
        area.draw(&dot)?;
    }
    Ok(())
}

fn draw_thin_bar(area: &Area<'_>, (left, right): (i32, i32), y: i32) -> Result<()> {
    let (middle, half) = (y + units(THIN_BAR_PX.0), units(THIN_BAR_PX.1));
    let corners = [(left, middle - half), (right, middle + half)];
    area.draw(&Rectangle::new(corners, Paint::Muted.solid().filled()))?;
    Ok(())
}

/// The legend of main and thin bars, from `x` to the right.
fn draw_names(area: &Area<'_>, (mut x, y): (i32, i32), names: &[String; 2]) -> Result<()> {
    let style = canvas::font(FONT_PX, Paint::Muted, HPos::Left, VPos::Center);
    for (index, name) in names.iter().enumerate() {
        let end = x + units(NAME_SAMPLE_PX);
        if index == 0 {
            let half = units(HALF_BAR_PX - BAR_MAKES_ROOM_PX);
            let sample = Rectangle::new(
                [(x, y - half), (end, y + half)],
                Paint::Hue(Hue::Grey).solid().mix(0.85).filled(),
            );
            area.draw(&sample)?;
        } else {
            draw_thin_bar(area, (x, end), y - units(THIN_BAR_PX.0))?;
        }
        let name = text::printable(name);
        area.draw_text(&name, &style, (end + units(GAP_PX / 2.0), y))?;
        x = end + units(text::width_px(&name, FONT_PX) + 2.0 * GAP_PX);
    }
    Ok(())
}

fn draw_whisker(area: &Area<'_>, (left, right): (i32, i32), y: i32) -> Result<()> {
    let style = Paint::Ink.solid().stroke_width(units(1.4).unsigned_abs());
    let cap = units(3.5);
    area.draw(&PathElement::new([(left, y), (right, y)], style))?;
    for end in [left, right] {
        area.draw(&PathElement::new([(end, y - cap), (end, y + cap)], style))?;
    }
    Ok(())
}

fn draw_connector(area: &Area<'_>, layout: &Layout, index: usize, end: f64) -> Result<()> {
    let x = layout.x(end);
    let half = units(HALF_BAR_PX);
    let line = [(x, layout.y(index) + half), (x, layout.y(index + 1) - half)];
    area.draw(&PathElement::new(
        line,
        Paint::Muted.solid().stroke_width(SCALE.unsigned_abs()),
    ))?;
    Ok(())
}
