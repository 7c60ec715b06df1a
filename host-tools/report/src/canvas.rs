//! The drawing surface: plotters' SVG backend at four units per pixel, made theme-aware and scalable.

use super::text;
use super::theme::{self, Paint};
use anyhow::{Context, Result};
use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::prelude::{DrawingArea, IntoDrawingArea, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, IntoFont, ShapeStyle, TextStyle};

/// Width of a drawing that fills the page, in pixels.
pub(super) const WIDTH_PX: u32 = 860;

/// Drawing units per pixel. Plotters rounds to whole units; a quarter of a pixel keeps slopes smooth.
pub(super) const SCALE: i32 = 4;

/// Font size of axes, legends and rows, in pixels.
pub(super) const FONT_PX: f64 = 12.0;

/// Font size of titles, in pixels.
const TITLE_FONT_PX: f64 = 13.5;

/// Height of a line of the title, in pixels.
const TITLE_LINE_PX: i32 = 19;

/// Attributes with default values, which are removed: they would be a third of a cloud of markers. Text is not affected,
/// since its quotes are escaped.
const DEFAULTS: [&str; 3] = [
    " opacity=\"1\"",
    " stroke=\"none\" stroke-width=\"1\"",
    " stroke=\"none\"",
];

/// Plotters' SVG backend divides font sizes by this factor.
const PLOTTERS_FONT_FACTOR: f64 = 1.24;

/// A place in drawing units, from the upper left corner.
pub(super) type Spot = (i32, i32);

/// A surface to draw on, in units of 1/[`SCALE`] pixel.
pub(super) struct Canvas<'a> {
    pub(super) area: DrawingArea<SVGBackend<'a>, Shift>,
    /// Height that the title takes, in pixels.
    pub(super) title_px: i32,
}

/// Draws an SVG of this width and height in pixels below a title, whose height is added.
pub(super) fn draw(
    title: &str,
    (width, height): (u32, i32),
    content: impl FnOnce(&Canvas<'_>) -> Result<()>,
) -> Result<String> {
    let lines = text::wrap(&text::printable(title), TITLE_FONT_PX, f64::from(width));
    let title_px = lines.len() as i32 * TITLE_LINE_PX + 4;
    let height = (height + title_px).unsigned_abs();
    let units = (width * SCALE as u32, height * SCALE as u32);
    let mut drawn = String::new();
    {
        let area = SVGBackend::with_string(&mut drawn, units).into_drawing_area();
        let canvas = Canvas { area, title_px };
        let style = font(TITLE_FONT_PX, FontStyle::Bold, Paint::Ink);
        for (line, text) in lines.iter().enumerate() {
            let at = (0, (2 + line as i32 * TITLE_LINE_PX) * SCALE);
            canvas.area.draw_text(text, &style, at)?;
        }
        content(&canvas)?;
        canvas.area.present()?;
    }
    let body = drawn.split_once('>').map(|(_, body)| body.trim()).context(
        "the plot backend wrote no <svg> element; please report this with the command you ran",
    )?;
    let mut body = theme::themed(body);
    for default in DEFAULTS {
        body = body.replace(default, "");
    }
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"{}\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {} {}\" stroke-linejoin=\"round\" stroke-linecap=\"butt\">\n{body}\n",
        text::escape(title),
        units.0,
        units.1
    ))
}

impl Canvas<'_> {
    /// A text of [`FONT_PX`], anchored at the given point of its box.
    pub(super) fn write(
        &self,
        text: &str,
        paint: Paint,
        (horizontal, vertical): (HPos, VPos),
        at: Spot,
    ) -> Result<()> {
        let style = label_font(paint).pos(Pos::new(horizontal, vertical));
        Ok(self.area.draw_text(&text::printable(text), &style, at)?)
    }

    /// A filled rectangle between two corners; `opacity` from 0 to 1.
    pub(super) fn fill(&self, corners: [Spot; 2], paint: Paint, opacity: f64) -> Result<()> {
        let style = paint.solid().mix(opacity).filled();
        Ok(self.area.draw(&Rectangle::new(corners, style))?)
    }

    /// A line from point to point.
    pub(super) fn line(&self, points: impl Into<Vec<Spot>>, style: ShapeStyle) -> Result<()> {
        Ok(self.area.draw(&PathElement::new(points.into(), style))?)
    }

    /// A filled circle.
    pub(super) fn dot(&self, at: Spot, radius_px: f64, paint: Paint, opacity: f64) -> Result<()> {
        let style = paint.solid().mix(opacity).filled();
        Ok(self.area.draw(&Circle::new(at, units(radius_px), style))?)
    }
}

/// Pixels to drawing units.
pub(super) fn units(pixels: f64) -> i32 {
    (pixels * f64::from(SCALE)).round() as i32
}

/// Style of a line one pixel wide; `opacity` from 0 to 1.
pub(super) fn hairline(paint: Paint, opacity: f64) -> ShapeStyle {
    let color = paint.solid().mix(opacity);
    color.stroke_width(SCALE.unsigned_abs())
}

/// Style of a text of [`FONT_PX`].
pub(super) fn label_font(paint: Paint) -> TextStyle<'static> {
    font(FONT_PX, FontStyle::Normal, paint)
}

fn font(font_px: f64, style: FontStyle, paint: Paint) -> TextStyle<'static> {
    let size = font_px * PLOTTERS_FONT_FACTOR * f64::from(SCALE);
    let font = ("sans-serif", size, style).into_font();
    font.color(&paint.solid().to_rgba())
}
