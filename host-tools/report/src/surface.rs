//! The drawing surface: plotters' SVG backend at four units per pixel, made theme-aware and scalable.

use super::text;
use super::theme::{self, Paint};
use anyhow::{Context, Result};
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, IntoDrawingArea, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, IntoFont, TextStyle};

/// Drawing units per pixel. Plotters rounds to whole units; a quarter of a pixel keeps slopes smooth.
pub(super) const SCALE: i32 = 4;

/// Font size of axes, legends and rows, in pixels.
pub(super) const FONT_PX: f64 = 12.0;

/// Font size of titles, in pixels.
const TITLE_FONT_PX: f64 = 13.5;

/// Height of a line of the title, in pixels.
const TITLE_LINE_PX: i32 = 19;

/// Widths in pixels that a drawing can have; what lies outside is clamped.
const WIDTH_PX: std::ops::RangeInclusive<u32> = 200..=4000;

/// Heights in pixels that a drawing can have.
const HEIGHT_PX: std::ops::RangeInclusive<u32> = 40..=8000;

/// Attributes that say what holds anyway. They would be a third of a cloud of markers. Text cannot be hit, since its
/// quotes are escaped.
const DEFAULTS: [&str; 3] = [
    " opacity=\"1\"",
    " stroke=\"none\" stroke-width=\"1\"",
    " stroke=\"none\"",
];

/// Plotters' SVG backend divides font sizes by this factor.
const PLOTTERS_FONT_FACTOR: f64 = 1.24;

/// A surface to draw on, in units of 1/[`SCALE`] pixel.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws an SVG of `width` by `height` pixels (clamped to what can be laid out); `title` is what a screen reader says.
pub(super) fn draw(
    title: &str,
    (width, height): (u32, u32),
    content: impl FnOnce(&Area<'_>) -> Result<()>,
) -> Result<String> {
    let width = width.clamp(*WIDTH_PX.start(), *WIDTH_PX.end());
    let height = height.clamp(*HEIGHT_PX.start(), *HEIGHT_PX.end());
    let units = (width * SCALE as u32, height * SCALE as u32);
    let mut drawn = String::new();
    {
        let area = SVGBackend::with_string(&mut drawn, units).into_drawing_area();
        content(&area)?;
        area.present()?;
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

/// Pixels to drawing units.
pub(super) fn units(pixels: f64) -> i32 {
    (pixels * f64::from(SCALE)).round() as i32
}

/// Style of a text of `font_px` pixels, anchored at the given point of its box.
pub(super) fn font(
    font_px: f64,
    paint: Paint,
    horizontal: HPos,
    vertical: VPos,
) -> TextStyle<'static> {
    (
        "sans-serif",
        font_px * PLOTTERS_FONT_FACTOR * f64::from(SCALE),
    )
        .into_font()
        .color(&paint.solid().to_rgba())
        .pos(Pos::new(horizontal, vertical))
}

/// Lines that a title takes on a drawing of `width_px`.
fn title_lines(title: &str, width_px: f64) -> Vec<String> {
    text::wrap(&text::printable(title), TITLE_FONT_PX, width_px)
}

/// Height of a title on a drawing of `width` pixels, in pixels.
pub(super) fn title_height(title: &str, width: u32) -> i32 {
    title_lines(title, f64::from(width)).len() as i32 * TITLE_LINE_PX + 4
}

/// Writes `title` at the top left, on as many lines as it needs, and returns the height taken in pixels.
pub(super) fn title(area: &Area<'_>, title: &str) -> Result<i32> {
    let width = area.dim_in_pixel().0 / SCALE.unsigned_abs();
    let style = (
        "sans-serif",
        TITLE_FONT_PX * PLOTTERS_FONT_FACTOR * f64::from(SCALE),
        FontStyle::Bold,
    )
        .into_font()
        .color(&Paint::Ink.solid().to_rgba());
    for (line, text) in title_lines(title, f64::from(width)).iter().enumerate() {
        area.draw_text(text, &style, (0, (2 + line as i32 * TITLE_LINE_PX) * SCALE))?;
    }
    Ok(title_height(title, width))
}
