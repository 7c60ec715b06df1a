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

/// Margin at the left edge: glyphs of the turned label reach a little over its line, in pixels.
const LEFT_MARGIN_PX: i32 = 3;

/// Width of the y axis without its tick labels, in pixels.
const Y_AXIS_PX: f64 = 32.0;

/// Characters of tick labels that every y axis has room for, so that the x axes of most plots stand below each other.
const TICK_LABEL_LENGTH: usize = 6;

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
    /// A band along x behind the curves, from and to in the unit of y, as ±2 σ of the noise.
    pub corridor: Option<Band>,
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
            corridor: None,
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
        let mut hidden = None;
        let svg = canvas::draw(&self.title, size, |area| {
            hidden = self.draw_on(area, &[])?;
            Ok(())
        })?;
        match hidden {
            // A second attempt with the legend above the frame, as long as that leaves half of the height to the plot.
            Some(legend) if legend::height_above(&legend, f64::from(width)) < height as i32 / 2 => {
                canvas::draw(&self.title, size, |area| {
                    self.draw_on(area, &legend).map(|_| ())
                })
            }
            _ => Ok(svg),
        }
    }

    /// Draws everything, with this legend above the frame, or without one with a legend inside; returns the legend if
    /// it hides a curve there.
    fn draw_on(
        &self,
        area: &Area<'_>,
        above: &[(String, Sample)],
    ) -> Result<Option<Vec<(String, Sample)>>> {
        let width_px = f64::from(area.dim_in_pixel().0) / f64::from(SCALE);
        let title_px = canvas::title(area, &self.title)?;
        let legend_px = match above {
            [] => 0,
            rows => legend::height_above(rows, width_px),
        };
        let band_px = if self.shaded.is_empty() {
            4
        } else {
            BAND_LABEL_PX
        };
        let mut chart = self.axes(area, title_px + legend_px + band_px)?;
        let (x_pixels, y_pixels) = chart.plotting_area().get_pixel_range();
        let frame = Rect {
            left: x_pixels.start,
            right: x_pixels.end,
            top: y_pixels.start,
            bottom: y_pixels.end,
        };
        let unnamed_bands = bands::draw(area, &chart, frame, &self.shaded)?;
        let corridor = match &self.corridor {
            Some(band) => bands::corridor(area, &chart, frame, band)?,
            None => None,
        };
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
        rows.extend(corridor);
        rows.extend(unnamed_bands);
        if occupied.is_empty() {
            let style = canvas::font(FONT_PX, Paint::Muted, HPos::Center, VPos::Center);
            let middle = (
                (frame.left + frame.right) / 2,
                (frame.top + frame.bottom) / 2,
            );
            area.draw_text("no data", &style, middle)?;
        }
        legend::draw_above(area, (0, title_px * SCALE), above, width_px)?;
        let hides = above.is_empty() && legend::draw(area, frame, &rows, &occupied)?;
        Ok(hides.then_some(rows))
    }

    /// Frame, grid, ticks and axis labels, below `top_px` pixels.
    fn axes<'a, 'b>(&self, area: &'a Area<'b>, top_px: i32) -> Result<Chart<'a, 'b>> {
        let (width, height) = area.dim_in_pixel();
        let x = Axis::new(self.x_range(), (width / SCALE as u32 / TICK_PX.0) as usize);
        let y = Axis::new(self.y_range(), (height / SCALE as u32 / TICK_PX.1) as usize);
        let label_length = y.ticks.longest_label().max(TICK_LABEL_LENGTH);
        let label_px = text::width_px(&"0".repeat(label_length), FONT_PX);
        let x_label = x.ticks.with_exponent(&text::printable(&self.x_label));
        let y_label = y.ticks.with_exponent(&text::printable(&self.y_label));
        let spans_zero = y.spans_zero();
        let mut chart = ChartBuilder::on(area)
            .margin_left(LEFT_MARGIN_PX * SCALE)
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
            // A gap at the ends is a part of the record too.
            let points = self.series.iter().flat_map(|series| &series.points);
            let x = points.map(|point| point.0);
            ticks::range_of(x.filter(|x| x.abs() <= ticks::LARGEST), margin)
        } else {
            ticks::range_of(
                self.shaded.iter().flat_map(|band| [band.from, band.to]),
                margin,
            )
        }
    }

    fn y_range(&self) -> Range<f64> {
        let lowest = self
            .drawable_points()
            .map(|point| point.1)
            .fold(f64::INFINITY, f64::min);
        let zero = self.y_from_zero.then_some(0.0);
        let corridor = self.corridor.iter().flat_map(|band| [band.from, band.to]);
        let corridor = corridor.filter(|value| value.abs() <= ticks::LARGEST);
        let shown = self.drawable_points().map(|point| point.1);
        let range = ticks::range_of(shown.chain(zero).chain(corridor), Y_MARGIN);
        // Magnitudes stand on the axis, without a margin below it.
        let stands_on_zero = self.y_from_zero && lowest >= 0.0 && range.end > 0.0;
        let start = if stands_on_zero { 0.0 } else { range.start };
        start..range.end
    }
}
