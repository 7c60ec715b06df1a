//! A plot of curves over one axis, with shaded windows behind them, drawn as SVG.

use super::axis::{self, Axis};
use super::canvas::{self, Canvas, FONT_PX, SCALE, WIDTH_PX, hairline, label_font, units};
use super::curve::{Series, Style};
use super::frame::Frame;
use super::legend::{Legend, Sample};
use super::text;
use super::theme::{Hue, Paint};
use anyhow::Result;
use plotters::chart::ChartBuilder;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Margin at the right edge, where half of the last tick label stands, in pixels.
const RIGHT_MARGIN_PX: i32 = 12;

/// Margin at the left edge: glyphs of the turned label reach a little over its line, in pixels.
const LEFT_MARGIN_PX: i32 = 3;

/// Height of the x axis with its label, in pixels.
const X_AXIS_PX: i32 = 42;

/// Width of the y axis without its tick labels, in pixels.
const Y_AXIS_PX: f64 = 32.0;

/// Characters of tick labels that every y axis has room for, so that the x axes of most plots stand below each other.
const TICK_LABEL_LENGTH: usize = 6;

/// Smallest distance between ticks, in pixels.
const TICK_PX: (i32, i32) = (80, 36);

/// Part of the span of y that stays free above and below the curves.
const Y_MARGIN: f64 = 0.06;

/// Colour of the band along x; not one of the first tints of windows.
const CORRIDOR: Hue = Hue::Blue;

/// Opacity of shaded windows.
const TINT: f64 = 0.13;

/// A shaded window, such as a phase of the docking or a time of large error.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Start, in the unit of the x axis.
    pub from: f64,
    /// End, in the unit of the x axis.
    pub to: f64,
    /// Name in the legend; windows of one name share a tint.
    pub label: String,
    /// Its tint; by default one after the other.
    pub hue: Option<Hue>,
}

impl Band {
    /// The part of the window within `range`; None if there is none.
    fn within(&self, range: &Range<f64>) -> Option<(f64, f64)> {
        let (from, to) = (self.from.min(self.to), self.from.max(self.to));
        let known = !self.from.is_nan() && !self.to.is_nan();
        (known && to >= range.start && from <= range.end)
            .then(|| (from.max(range.start), to.min(range.end)))
    }
}

/// A plot of curves over one x axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What the plot shows; wrapped if it is long.
    pub title: String,
    /// Quantity and unit of x, as in `time [s]`. The unit in brackets takes up a power of ten if one is needed.
    pub x_label: String,
    /// Quantity and unit of y, as in `force [N]`.
    pub y_label: String,
    /// Curves, in drawing order.
    pub series: Vec<Series>,
    /// Shaded windows behind the curves.
    pub shaded: Vec<Band>,
    /// A horizontal band behind the curves, with limits in the unit of y, such as ±2 σ of the noise.
    pub corridor: Option<Band>,
    /// Height without title and legend, in pixels from 100 to 4000.
    pub height: u32,
    /// Whether the y axis has to include zero.
    pub y_from_zero: bool,
}

/// All windows of one name within the plotted range.
struct Windows<'a> {
    label: &'a str,
    tint: Hue,
    spans: Vec<(f64, f64)>,
}

impl Plot {
    /// An empty plot of the usual height, 275 pixels.
    pub fn new(
        title: impl Into<String>,
        x_label: impl Into<String>,
        y_label: impl Into<String>,
    ) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            series: Vec::new(),
            shaded: Vec::new(),
            corridor: None,
            height: 275,
            y_from_zero: false,
        }
    }

    /// The plot as one SVG element that follows the page's light or dark colours.
    ///
    /// # Errors
    ///
    /// If the plotting library refuses the geometry; no data do that.
    pub fn to_svg(&self) -> Result<String> {
        self.to_svg_sized((WIDTH_PX, self.height))
    }

    /// The plot in this width and this height without title and legend, in pixels.
    pub(super) fn to_svg_sized(&self, (width, height): (u32, u32)) -> Result<String> {
        let legend = Legend::new(self.legend(), f64::from(width));
        let height = height.clamp(100, 4000) as i32;
        let x = Axis::new(self.x_range(), width as usize / TICK_PX.0 as usize);
        let y = Axis::new(self.y_range(), (height / TICK_PX.1) as usize);
        canvas::draw(
            &self.title,
            (width, height + legend.height_px()),
            |canvas| {
                legend.draw(canvas, canvas.title_px)?;
                let frame = self.axes(canvas, (x, y), canvas.title_px + legend.height_px())?;
                self.draw_in(canvas, &frame)
            },
        )
    }

    /// Names and samples of everything that is drawn.
    fn legend(&self) -> Vec<(String, Sample)> {
        let series = self.hues().map(|(series, hue)| {
            let no_data = !series.name.is_empty() && series.drawable().next().is_none();
            let note = if no_data { " (no data)" } else { "" };
            let name = format!("{}{note}", series.name);
            (name, Sample::Series(series.style, hue))
        });
        let corridor = self
            .corridor
            .iter()
            .filter(|band| band.within(&self.y_range()).is_some());
        let corridor = corridor.map(|band| (band.label.clone(), Sample::Band(CORRIDOR)));
        let windows = self.windows().into_iter();
        let windows = windows.map(|w| (w.label.to_owned(), Sample::Band(w.tint)));
        series.chain(corridor).chain(windows).collect()
    }

    /// Frame, grid, ticks and axis labels, below `top_px` pixels.
    fn axes(&self, canvas: &Canvas<'_>, (x, y): (Axis, Axis), top_px: i32) -> Result<Frame> {
        let label_length = y.longest_label().max(TICK_LABEL_LENGTH);
        let label_px = text::width_px(&"0".repeat(label_length), FONT_PX);
        let mut chart = ChartBuilder::on(&canvas.area)
            .margin_left(LEFT_MARGIN_PX * SCALE)
            .margin_right(RIGHT_MARGIN_PX * SCALE)
            .margin_top((top_px + 4) * SCALE)
            .margin_bottom(2 * SCALE)
            .x_label_area_size(X_AXIS_PX * SCALE)
            .y_label_area_size(units(label_px + Y_AXIS_PX))
            .build_cartesian_2d(x.shown_range(), y.shown_range())?;
        let below = Pos::new(HPos::Center, VPos::Top);
        chart
            .configure_mesh()
            .x_labels(x.most_ticks)
            .y_labels(y.most_ticks)
            .max_light_lines(0)
            .x_label_formatter(&|value| x.label(*value))
            .y_label_formatter(&|value| y.label(*value))
            .bold_line_style(hairline(Paint::Grid, 1.0))
            .axis_style(hairline(Paint::Muted, 1.0))
            .set_all_tick_mark_size(units(3.5))
            .label_style(label_font(Paint::Muted).pos(below))
            .axis_desc_style(label_font(Paint::Ink).pos(below))
            .x_desc(x.with_exponent(&text::printable(&self.x_label)))
            .y_desc(y.with_exponent(&text::printable(&self.y_label)))
            .draw()?;
        let (columns, rows) = chart.plotting_area().get_pixel_range();
        Ok(Frame {
            x,
            y,
            columns,
            rows,
        })
    }

    /// Draws the content of the frame: windows, the zero line, and the curves.
    fn draw_in(&self, canvas: &Canvas<'_>, frame: &Frame) -> Result<()> {
        let (columns, rows) = (&frame.columns, &frame.rows);
        for windows in self.windows() {
            let paint = Paint::Hue(windows.tint);
            for (from, to) in merged(&windows.spans, frame) {
                canvas.fill([(from, rows.start), (to, rows.end)], paint, TINT)?;
                // An opaque bar at the upper edge, which is visible in a bad print, too.
                let edge = [(from, rows.start - units(2.0)), (to, rows.start)];
                canvas.fill(edge, paint, 0.8)?;
            }
        }
        let across = |y: f64| {
            let row = frame.at((frame.x.range.start, y)).1;
            [(columns.start, row), (columns.end, row)]
        };
        if let Some(band) = &self.corridor
            && let Some((low, high)) = band.within(&frame.y.range)
        {
            let paint = Paint::Hue(CORRIDOR);
            canvas.fill([across(high)[0], across(low)[1]], paint, TINT)?;
            for edge in [low, high] {
                canvas.line(across(edge), hairline(paint, 0.55))?;
            }
        }
        if frame.y.range.start < 0.0 && frame.y.range.end > 0.0 {
            canvas.line(across(0.0), hairline(Paint::Muted, 0.55))?;
        }
        for (series, hue) in self.hues() {
            series.draw(canvas, frame, hue)?;
        }
        if self.drawable().next().is_none() {
            let middle = (
                (columns.start + columns.end) / 2,
                (rows.start + rows.end) / 2,
            );
            canvas.write(
                "no data",
                Paint::Muted,
                (HPos::Center, VPos::Center),
                middle,
            )?;
        }
        Ok(())
    }

    /// The series with their colours.
    fn hues(&self) -> impl Iterator<Item = (&Series, Hue)> {
        let numbered = self.series.iter().enumerate();
        numbered.map(|(index, series)| (series, series.color.unwrap_or(Hue::of_series(index))))
    }

    /// The windows in view by their names.
    fn windows(&self) -> Vec<Windows<'_>> {
        let range = self.x_range();
        let mut named: Vec<Windows<'_>> = Vec::new();
        for band in &self.shaded {
            let Some(span) = band.within(&range) else {
                continue;
            };
            match named.iter_mut().find(|known| known.label == band.label) {
                Some(known) => known.spans.push(span),
                None => named.push(Windows {
                    label: &band.label,
                    tint: band.hue.unwrap_or(Hue::of_band(named.len())),
                    spans: vec![span],
                }),
            }
        }
        named
    }

    fn drawable(&self) -> impl Iterator<Item = &(f64, f64)> {
        self.series.iter().flat_map(Series::drawable)
    }

    fn x_range(&self) -> Range<f64> {
        let has_markers = self.series.iter().any(|s| s.style == Style::Points);
        let margin = if has_markers { 0.02 } else { 0.0 };
        if self.drawable().next().is_some() {
            // A gap at either end belongs to the recorded time, too.
            let points = self.series.iter().flat_map(|series| &series.points);
            let x = points.map(|point| point.0);
            axis::range_of(x.filter(|x| x.abs() <= axis::LARGEST), margin)
        } else {
            let ends = self.shaded.iter().flat_map(|band| [band.from, band.to]);
            axis::range_of(ends, margin)
        }
    }

    fn y_range(&self) -> Range<f64> {
        let zero = self.y_from_zero.then_some(0.0);
        let corridor = self.corridor.iter().flat_map(|band| [band.from, band.to]);
        let corridor = corridor.filter(|value| value.abs() <= axis::LARGEST);
        let shown = self.drawable().map(|point| point.1);
        let range = axis::range_of(shown.chain(zero).chain(corridor), Y_MARGIN);
        // Values that cannot be negative begin at the axis, without a margin below.
        let stands_on_zero =
            self.y_from_zero && range.end > 0.0 && self.drawable().all(|point| point.1 >= 0.0);
        let start = if stands_on_zero { 0.0 } else { range.start };
        start..range.end
    }
}

/// Windows in drawing units, at least a pixel wide; where they overlap they become one.
fn merged(windows: &[(f64, f64)], frame: &Frame) -> Vec<(i32, i32)> {
    let column = |x: f64| frame.at((x, frame.y.range.start)).0;
    let mut sorted: Vec<(i32, i32)> = windows
        .iter()
        .map(|&(from, to)| (column(from).min(frame.columns.end - SCALE), column(to)))
        .map(|(from, to)| (from, to.max(from + SCALE)))
        .collect();
    sorted.sort_unstable();
    let mut merged: Vec<(i32, i32)> = Vec::new();
    for (from, to) in sorted {
        match merged.last_mut() {
            Some(last) if from < last.1 => last.1 = last.1.max(to),
            _ => merged.push((from, to)),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_windows_become_one() {
        let frame = Frame {
            x: Axis::new(0.0..10.0, 2),
            y: Axis::new(0.0..1.0, 2),
            columns: 0..100,
            rows: 0..10,
        };
        let windows = [(9.0, 10.0), (0.0, 4.0), (2.0, 3.0), (3.0, 9.0)];
        assert_eq!(merged(&windows, &frame), [(0, 90), (90, 100)]);
    }
}
