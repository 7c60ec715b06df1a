//! Charts of labelled rows: ranked bars, a value that falls step by step, and intervals around estimates.

use super::axis;
use super::canvas::{self, Canvas, FONT_PX, SCALE, WIDTH_PX, hairline, units};
use super::number::{self, Format};
use super::text;
use super::theme::{Hue, Paint};
use anyhow::Result;
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;

/// Height of a row, in pixels.
const ROW_PX: f64 = 25.0;

/// Half the thickness of a bar, in pixels.
const HALF_BAR_PX: f64 = 7.0;

/// Middle and half the thickness of the thin bar below the main one, in pixels from the middle of the row.
const THIN_BAR_PX: (f64, f64) = (7.5, 1.5);

/// Distance by which the main bar moves up, and by which it becomes thinner, if there is a thin bar below it, in pixels.
const BAR_MAKES_ROOM_PX: f64 = 2.0;

/// Height of the line that names the values, in pixels.
const HEADER_PX: f64 = 20.0;

/// Space at the edges and between the columns, in pixels.
const GAP_PX: f64 = 12.0;

/// Width of a sample of bar in the legend, in pixels.
const NAME_SAMPLE_PX: f64 = 16.0;

/// Largest parts of the width that labels and values take; longer labels are shortened.
const LARGEST_PARTS: (f64, f64) = (0.4, 0.3);

/// One bar of a [`BarChart`].
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// What the bar stands for; in a waterfall what was done in the step, or where one starts.
    pub label: String,
    /// Its value, in the unit of the chart.
    pub value: f64,
    /// The same quantity on other data, drawn as a thin bar below; see [`BarChart::names`].
    pub second: Option<f64>,
    /// Colour; by default all bars are of one colour, and steps show whether they were good.
    pub color: Option<Hue>,
}

impl Bar {
    /// A bar in the default colour.
    pub fn new(label: impl Into<String>, value: f64) -> Self {
        Self {
            label: label.into(),
            value,
            second: None,
            color: None,
        }
    }

    /// The same bar with a thin one below it.
    #[must_use]
    pub fn with_second(mut self, value: f64) -> Self {
        self.second = Some(value);
        self
    }

    /// The same bar in this colour.
    #[must_use]
    pub fn colored(mut self, hue: Hue) -> Self {
        self.color = Some(hue);
        self
    }
}

/// Horizontal bars, one below the other in the order given.
#[derive(Clone, Debug, PartialEq)]
pub struct BarChart {
    /// What the chart shows.
    pub title: String,
    /// What the values are, with their unit, as in `share of the squared error`.
    pub value_label: String,
    /// What the bars and the thin ones below them stand for, if there are both.
    pub names: Option<[String; 2]>,
    /// How the values are written.
    pub format: Format,
    /// The bars, from top to bottom.
    pub bars: Vec<Bar>,
    /// Whether the bars are the levels of a waterfall: the first starts at zero, each other where the one before it
    /// ends, and is good if it brings the value nearer to zero.
    pub waterfall: bool,
}

impl BarChart {
    /// An empty chart of bars that start at zero.
    pub fn new(title: impl Into<String>, value_label: impl Into<String>, format: Format) -> Self {
        Self {
            title: title.into(),
            value_label: value_label.into(),
            names: None,
            format,
            bars: Vec::new(),
            waterfall: false,
        }
    }

    /// An empty waterfall: how a value falls (or rises) step by step, as the error does when effects are added.
    pub fn waterfall(
        title: impl Into<String>,
        value_label: impl Into<String>,
        format: Format,
    ) -> Self {
        Self {
            waterfall: true,
            ..Self::new(title, value_label, format)
        }
    }

    /// The chart as one SVG element that follows the page's light or dark colours.
    ///
    /// A value that is not finite gets its text and no bar; the next step starts at the last finite value.
    ///
    /// # Errors
    ///
    /// If the plotting library refuses the geometry; no data do that.
    pub fn to_svg(&self) -> Result<String> {
        let rows = if self.waterfall {
            self.steps()
        } else {
            let blue = Paint::Hue(Hue::Blue);
            let bars = self.bars.iter();
            bars.map(|bar| self.row(bar, [0.0; 2], blue)).collect()
        };
        draw(&self.title, &self.value_label, self.names.as_ref(), &rows)
    }

    fn steps(&self) -> Vec<Row> {
        let mut before = None;
        let mut start = [0.0; 2];
        let mut rows: Vec<Row> = Vec::new();
        for bar in &self.bars {
            let paint = match before {
                None => Paint::Hue(Hue::Grey),
                Some(before) if bar.value.abs() <= f64::abs(before) => Paint::Good,
                Some(_) => Paint::Bad,
            };
            let mut row = self.row(bar, start, paint);
            row.is_tied = !rows.is_empty();
            if let Some(change) = change(before, bar.value) {
                row.value += &format!(" ({change})");
            }
            if let Some(second) = bar.second {
                row.value += &format!(" | {}", self.format.write(second));
            }
            before = row.bar.map(|(_, end)| end).or(before);
            let ends = [row.bar, row.thin_bar];
            start = [0, 1].map(|i| ends[i].map_or(start[i], |(_, end)| end));
            rows.push(row);
        }
        rows
    }

    /// The row of a bar; `start` has the starts of the bar and of the thin one below it.
    fn row(&self, bar: &Bar, start: [f64; 2], paint: Paint) -> Row {
        let finite = |from: f64, to: f64| to.is_finite().then_some((from, to));
        Row {
            label: bar.label.clone(),
            value: self.format.write(bar.value),
            bar: finite(start[0], bar.value),
            thin_bar: bar.second.and_then(|second| finite(start[1], second)),
            interval: None,
            paint: bar.color.map_or(paint, Paint::Hue),
            is_tied: false,
        }
    }
}

/// Relative change as `-59 %` or `+12 %`.
fn change(before: Option<f64>, after: f64) -> Option<String> {
    let relative = (after - before?) / before?.abs();
    let sign = if relative > 0.0 { "+" } else { "" };
    let percent = || format!("{sign}{}", number::percent(relative, 0));
    relative.is_finite().then(percent)
}

/// An estimate and its interval, in any unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval {
    /// What was estimated.
    pub label: String,
    /// Best value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    fn row(&self) -> Row {
        let relative = self.relative();
        Row {
            label: self.label.clone(),
            value: relative.map_or("n/a".to_owned(), |(low, high)| {
                let percent = |part: f64| number::significant(part * 100.0, 2);
                format!("{} % … +{} %", percent(low), percent(high))
            }),
            bar: None,
            thin_bar: None,
            interval: relative,
            paint: Paint::Hue(Hue::Blue),
            is_tied: false,
        }
    }

    /// The row of an interval in the unit of the value.
    fn row_in_its_unit(&self) -> Row {
        let [low, high] = [self.low, self.high].map(|end| end - self.value);
        let finite = low.is_finite() && high.is_finite();
        let ends = |low: f64, high: f64| {
            let digits = |value| number::significant(value, 2);
            format!("{} … +{}", digits(low), digits(high))
        };
        Row {
            value: if finite {
                ends(low, high)
            } else {
                "n/a".to_owned()
            },
            interval: finite.then_some((low, high)),
            ..self.row()
        }
    }

    /// Ends of the interval relative to the value, in units of its magnitude; None if they are not finite.
    fn relative(&self) -> Option<(f64, f64)> {
        let [low, high] = [self.low, self.high].map(|end| (end - self.value) / self.value.abs());
        (low.is_finite() && high.is_finite()).then_some((low, high))
    }
}

/// Intervals, each relative to its own value, so that units do not matter, as one SVG element.
///
/// The interval of a value that is zero, or one without a finite end, cannot be drawn to the others' scale: it is
/// written as `n/a`.
pub(super) fn intervals(title: &str, intervals: &[Interval]) -> Result<String> {
    let rows: Vec<Row> = intervals.iter().map(Interval::row).collect();
    draw(title, "relative to the value", None, &rows)
}

/// Intervals of one unit, each around its own value, as one SVG element.
pub(super) fn intervals_in(title: &str, unit: &str, intervals: &[Interval]) -> Result<String> {
    let rows: Vec<Row> = intervals.iter().map(Interval::row_in_its_unit).collect();
    draw(title, &format!("around the value [{unit}]"), None, &rows)
}

/// One row; positions in the unit of the values, `None` for what is not there or cannot be drawn.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    label: String,
    /// Text in the column at the right.
    value: String,
    /// Start and end of the bar.
    bar: Option<(f64, f64)>,
    /// Start and end of the thin bar below it, for the same quantity on other data.
    thin_bar: Option<(f64, f64)>,
    /// Ends of an interval around zero, where a dot stands.
    interval: Option<(f64, f64)>,
    paint: Paint,
    /// Whether a line ties its start to the row above.
    is_tied: bool,
}

/// Rows as one SVG element, as high as they need; `names` says what main and thin bars stand for.
fn draw(
    title: &str,
    value_label: &str,
    names: Option<&[String; 2]>,
    rows: &[Row],
) -> Result<String> {
    let height = HEADER_PX + rows.len().max(1) as f64 * ROW_PX + GAP_PX / 2.0;
    canvas::draw(title, (WIDTH_PX, height as i32), |canvas| {
        let chart = RowChart::new(canvas, rows);
        let header = units(chart.top_px - HEADER_PX / 2.0);
        let at = (units(chart.values_right_px), header);
        canvas.write(value_label, Paint::Muted, (HPos::Right, VPos::Center), at)?;
        if let Some(names) = names {
            chart.draw_names((chart.x(chart.span.start), header), names)?;
        }
        if rows.is_empty() {
            let at = (chart.x(0.0), chart.y(0));
            return canvas.write("no data", Paint::Muted, (HPos::Left, VPos::Center), at);
        }
        for (index, row) in rows.iter().enumerate() {
            chart.draw_row(index, row)?;
        }
        let (zero, bottom) = (chart.x(0.0), chart.y(rows.len()) - units(ROW_PX / 2.0));
        let axis = [(zero, units(chart.top_px)), (zero, bottom)];
        canvas.line(axis, hairline(Paint::Muted, 1.0))
    })
}

/// Positions of the columns of a chart, in pixels, and the range of the bars.
struct RowChart<'a, 'b> {
    canvas: &'a Canvas<'b>,
    top_px: f64,
    bars_px: Range<f64>,
    values_right_px: f64,
    span: Range<f64>,
}

impl<'a, 'b> RowChart<'a, 'b> {
    fn new(canvas: &'a Canvas<'b>, rows: &[Row]) -> Self {
        let width = f64::from(WIDTH_PX);
        let widest = |text: fn(&Row) -> &str| {
            let widths = rows.iter().map(|row| text::width_px(text(row), FONT_PX));
            widths.fold(0.0, f64::max)
        };
        let label_px = widest(|row| &row.label).min(width * LARGEST_PARTS.0);
        let value_px = widest(|row| &row.value).min(width * LARGEST_PARTS.1);
        let values_right_px = width - 2.0;
        let ends = rows.iter().flat_map(|r| [r.bar, r.thin_bar, r.interval]);
        let ends = ends.flatten().flat_map(|(from, to)| [from, to]);
        // Bars start at the edge; the caps of intervals need a margin.
        let has_intervals = rows.iter().any(|row| row.interval.is_some());
        let margin = if has_intervals { 0.02 } else { 0.0 };
        Self {
            canvas,
            top_px: f64::from(canvas.title_px) + HEADER_PX,
            bars_px: label_px + GAP_PX..values_right_px - value_px - GAP_PX,
            values_right_px,
            span: axis::range_of(ends.chain([0.0]), margin),
        }
    }

    /// Horizontal position of a value, in drawing units.
    fn x(&self, value: f64) -> i32 {
        let value = value.clamp(self.span.start, self.span.end);
        let part = (value - self.span.start) / (self.span.end - self.span.start);
        units(self.bars_px.start + part * (self.bars_px.end - self.bars_px.start))
    }

    /// Middle of a row, in drawing units.
    fn y(&self, row: usize) -> i32 {
        units(self.top_px + (row as f64 + 0.5) * ROW_PX)
    }

    fn draw_row(&self, index: usize, row: &Row) -> Result<()> {
        let (canvas, y) = (self.canvas, self.y(index));
        let at_right = (HPos::Right, VPos::Center);
        let label = text::shorten(&row.label, FONT_PX, self.bars_px.start - GAP_PX);
        let label_right = units(self.bars_px.start - GAP_PX / 2.0);
        canvas.write(&label, Paint::Ink, at_right, (label_right, y))?;
        let value = row.value.replace('-', "−");
        canvas.write(
            &value,
            Paint::Ink,
            at_right,
            (units(self.values_right_px), y),
        )?;
        let half = units(HALF_BAR_PX);
        if let Some((start, end)) = row.bar {
            let makes_room = row.thin_bar.map_or(0, |_| units(BAR_MAKES_ROOM_PX));
            let (top, bottom) = (y - half, y + half - 2 * makes_room);
            let (left, right) = self.columns((start, end));
            canvas.fill([(left, top), (right, bottom)], row.paint, 0.85)?;
            if row.is_tied {
                let x = self.x(start);
                let tie = [(x, self.y(index.saturating_sub(1)) + half), (x, y - half)];
                canvas.line(tie, hairline(Paint::Muted, 1.0))?;
            }
        }
        if let Some(ends) = row.thin_bar {
            self.draw_thin_bar(self.columns(ends), y)?;
        }
        if let Some((low, high)) = row.interval {
            let stroke = Paint::Ink.solid().stroke_width(units(1.4).unsigned_abs());
            let (low, high, cap) = (self.x(low), self.x(high), units(3.5));
            canvas.line([(low, y), (high, y)], stroke)?;
            for end in [low, high] {
                canvas.line([(end, y - cap), (end, y + cap)], stroke)?;
            }
            canvas.dot((self.x(0.0), y), 4.0, row.paint, 1.0)?;
        }
        Ok(())
    }

    /// Left and right edge of a bar; a share too small to see still leaves a line.
    fn columns(&self, (start, end): (f64, f64)) -> (i32, i32) {
        let (left, right) = (self.x(start.min(end)), self.x(start.max(end)));
        (left, right.max(left + SCALE))
    }

    fn draw_thin_bar(&self, (left, right): (i32, i32), y: i32) -> Result<()> {
        let (middle, half) = (y + units(THIN_BAR_PX.0), units(THIN_BAR_PX.1));
        let corners = [(left, middle - half), (right, middle + half)];
        self.canvas.fill(corners, Paint::Muted, 1.0)
    }

    /// The legend of main and thin bars, from `x` to the right.
    fn draw_names(&self, (mut x, y): (i32, i32), names: &[String; 2]) -> Result<()> {
        for (index, name) in names.iter().enumerate() {
            let end = x + units(NAME_SAMPLE_PX);
            if index == 0 {
                let half = units(HALF_BAR_PX - BAR_MAKES_ROOM_PX);
                let corners = [(x, y - half), (end, y + half)];
                self.canvas.fill(corners, Paint::Hue(Hue::Grey), 0.85)?;
            } else {
                self.draw_thin_bar((x, end), y - units(THIN_BAR_PX.0))?;
            }
            let at = (end + units(GAP_PX / 2.0), y);
            self.canvas
                .write(name, Paint::Muted, (HPos::Left, VPos::Center), at)?;
            x = end + units(text::width_px(name, FONT_PX) + 2.0 * GAP_PX);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_measured_against_the_last_level() {
        assert_eq!(change(Some(12.0), 3.0).as_deref(), Some("-75 %"));
        assert_eq!(change(Some(3.0), 4.0).as_deref(), Some("+33 %"));
        assert_eq!(change(None, 4.0), None);
        assert_eq!(change(Some(0.0), 4.0), None);
    }

    fn interval(value: f64, low: f64, high: f64) -> Row {
        let label = "delay_s".to_owned();
        Interval {
            label,
            value,
            low,
            high,
        }
        .row()
    }

    #[test]
    fn an_interval_is_relative_to_the_size_of_its_value() {
        let row = interval(-2.0, -2.5, -1.8);
        assert_eq!(row.value, "-25 % … +10 %");
        let (low, high) = row.interval.unwrap();
        assert!((low + 0.25).abs() < 1e-12 && (high - 0.1).abs() < 1e-12);
    }

    #[test]
    fn an_interval_that_cannot_be_drawn_to_scale_says_so() {
        for row in [interval(0.0, -1.0, 1.0), interval(1.0, 0.5, f64::INFINITY)] {
            assert_eq!((row.value.as_str(), row.interval), ("n/a", None));
        }
    }
}
