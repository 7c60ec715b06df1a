//! A plot of curves over one axis, drawn as SVG.

use super::axis::Axis;
use super::canvas::{self, Area, FONT_PX, SCALE, units};
use super::decimate::{self, Point};
use super::legend::{self, Rect, Sample};
use super::text;
use super::theme::{Hue, Paint};
use super::ticks;
use super::{bands, curves};
use anyhow::Result;
use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::PathElement;
use plotters::prelude::SVGBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, ShapeStyle};
use std::ops::Range;

/// Margin at the right edge, where half of the last tick label stands, in pixels.
const RIGHT_MARGIN_PX: i32 = 12;

/// Height of the row above the frame where shaded windows are named, in pixels.
const BAND_LABEL_PX: i32 = 17;

/// Height of the x axis with its label, in pixels.
const X_AXIS_PX: i32 = 42;

/// Width of the y axis without its tick labels, in pixels.
const Y_AXIS_PX: f64 = 32.0;

/// Distance between ticks, in pixels.
const TICK_PX: (u32, u32) = (105, 48);

/// Part of the span of y that stays free above and below the curves.
const Y_MARGIN: f64 = 0.06;

/// A chart on the SVG canvas.
pub(super) type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

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
}

/// A shaded window: a phase of the docking, or where something fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Start, in the unit of the x axis.
    pub from: f64,
    /// End, in the unit of the x axis.
    pub to: f64,
    /// Name; windows of one name share a tint. Written above a window that is wide enough, else in the legend.
    pub label: String,
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
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Whether the y axis has to include zero.
    pub y_from_zero: bool,
}

impl Plot {
    /// An empty plot of the usual size, 860 by 300 pixels.
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
            width: 860,
            height: 300,
            y_from_zero: false,
        }
    }

    /// The plot as one SVG element that follows the page's light or dark colours.
    ///
    /// # Errors
    ///
    /// If the plotting library refuses the geometry; no data do that.
    pub fn to_svg(&self) -> Result<String> {
        self.to_svg_sized(self.width, self.height)
    }

    /// The plot in another size, in pixels.
    pub(super) fn to_svg_sized(&self, width: u32, height: u32) -> Result<String> {
        let size = (width, height.max(140));
        let mut needed = None;
        let svg = canvas::draw(&self.title, size, |area| {
            needed = self.draw_on(area, 0.0)?;
            Ok(())
        })?;
        match needed {
            // A second attempt with room for the legend above the curves, unless it would take half of the plot.
            Some(part) if part < 0.5 => canvas::draw(&self.title, size, |area| {
                self.draw_on(area, part).map(|_| ())
            }),
            _ => Ok(svg),
        }
    }

    /// Draws everything, with this part of the height left free above the curves; returns the part that the legend
    /// would need, if it hides a curve.
    fn draw_on(&self, area: &Area<'_>, free_part: f64) -> Result<Option<f64>> {
        let title_px = canvas::title(area, &self.title)?;
        let band_px = if self.shaded.is_empty() {
            4
        } else {
            BAND_LABEL_PX
        };
        let mut chart = self.axes(area, title_px + band_px, free_part)?;
        let (x_pixels, y_pixels) = chart.plotting_area().get_pixel_range();
        let frame = Rect {
            left: x_pixels.start,
            right: x_pixels.end,
            top: y_pixels.start,
            bottom: y_pixels.end,
        };
        let unnamed_bands = bands::draw(area, &chart, frame, &self.shaded)?;
        let mut rows = Vec::new();
        let mut occupied = Vec::new();
        for (index, series) in self.series.iter().enumerate() {
            let hue = series.color.unwrap_or(Hue::of_series(index));
            let passed = curves::draw(&mut chart, series, hue)?;
            if !series.name.is_empty() {
                let note = if passed.is_empty() { " (no data)" } else { "" };
                rows.push((
                    format!("{}{note}", series.name),
                    Sample::Series(series.style, hue),
                ));
            }
            occupied.extend(passed);
        }
        rows.extend(unnamed_bands);
        if occupied.is_empty() {
            let style = canvas::font(FONT_PX, Paint::Muted, HPos::Center, VPos::Center);
            let middle = (
                (frame.left + frame.right) / 2,
                (frame.top + frame.bottom) / 2,
            );
            area.draw_text("no data", &style, middle)?;
        }
        legend::draw(area, frame, &rows, &occupied)
    }

    /// Frame, grid, ticks and axis labels, below `top_px` pixels and with a part of the height free of data.
    fn axes<'a, 'b>(
        &self,
        area: &'a Area<'b>,
        top_px: i32,
        free_part: f64,
    ) -> Result<Chart<'a, 'b>> {
        let (width, height) = area.dim_in_pixel();
        let x = Axis::new(self.x_range(), (width / SCALE as u32 / TICK_PX.0) as usize);
        let y = Axis::new(
            self.y_range(free_part),
            (height / SCALE as u32 / TICK_PX.1) as usize,
        );
        let label_px = text::width_px(&"0".repeat(y.ticks.longest_label()), FONT_PX);
        let x_label = x.ticks.with_exponent(&text::printable(&self.x_label));
        let y_label = y.ticks.with_exponent(&text::printable(&self.y_label));
        let spans_zero = y.spans_zero();
        let mut chart = ChartBuilder::on(area)
            .margin_right(RIGHT_MARGIN_PX * SCALE)
            .margin_top(top_px * SCALE)
            .margin_bottom(2 * SCALE)
            .x_label_area_size(X_AXIS_PX * SCALE)
            .y_label_area_size(units(label_px + Y_AXIS_PX))
            .build_cartesian_2d(x, y)?;
        let label = canvas::font(FONT_PX, Paint::Ink, HPos::Center, VPos::Top);
        let tick = canvas::font(FONT_PX, Paint::Muted, HPos::Center, VPos::Top);
        chart
            .configure_mesh()
            .bold_line_style(Paint::Grid.solid().stroke_width(SCALE.unsigned_abs()))
            .axis_style(Paint::Muted.solid().stroke_width(SCALE.unsigned_abs()))
            .set_all_tick_mark_size(units(3.5))
            .label_style(tick)
            .axis_desc_style(label)
            .x_desc(x_label)
            .y_desc(y_label)
            .draw()?;
        if spans_zero {
            let x = chart.x_range();
            let zero = [(x.start, 0.0), (x.end, 0.0)];
            let style = Paint::Muted
                .solid()
                .mix(0.55)
                .stroke_width(SCALE.unsigned_abs());
            chart.draw_series([PathElement::new(zero, style)])?;
        }
        Ok(chart)
    }

    fn drawable_points(&self) -> impl Iterator<Item = &Point> {
        let points = self.series.iter().flat_map(|series| &series.points);
        points.filter(|point| decimate::drawable(point))
    }

    fn x_range(&self) -> Range<f64> {
        let has_markers = self
            .series
            .iter()
            .any(|series| series.style == Style::Points);
        let margin = if has_markers { 0.02 } else { 0.0 };
        if self.drawable_points().next().is_some() {
            ticks::range_of(self.drawable_points().map(|point| point.0), margin)
        } else {
            ticks::range_of(
                self.shaded.iter().flat_map(|band| [band.from, band.to]),
                margin,
            )
        }
    }

    fn y_range(&self, free_part: f64) -> Range<f64> {
        let lowest = self
            .drawable_points()
            .map(|point| point.1)
            .fold(f64::INFINITY, f64::min);
        let zero = self.y_from_zero.then_some(0.0);
        let range = ticks::range_of(
            self.drawable_points().map(|point| point.1).chain(zero),
            Y_MARGIN,
        );
        // Magnitudes stand on the axis, without a margin below it.
        let stands_on_zero = self.y_from_zero && lowest >= 0.0 && range.end > 0.0;
        let start = if stands_on_zero { 0.0 } else { range.start };
        start..start + (range.end - start) / (1.0 - free_part)
    }
}
