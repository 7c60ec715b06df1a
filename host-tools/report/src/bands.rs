//! Shaded windows behind the curves: the phases of a docking, or where something fails; and the band of the noise.

use super::canvas::{self, Area, FONT_PX, SCALE, units};
use super::legend::{Rect, Sample};
use super::plot::{Band, Chart};
use super::text;
use super::theme::{Hue, Paint};
use anyhow::Result;
use plotters::element::{PathElement, Rectangle};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

/// Font size of the names above the frame, in pixels.
const LABEL_FONT_PX: f64 = FONT_PX - 1.0;

/// Colour of the band along x; not one of the first tints of windows.
const CORRIDOR: Hue = Hue::Blue;

/// Start and end of a window, in drawing units.
type Window = (i32, i32);

/// Tints the windows and writes their names above the frame; returns the legend rows of names that had no room.
pub(super) fn draw(
    area: &Area<'_>,
    chart: &Chart<'_, '_>,
    frame: Rect,
    shaded: &[Band],
) -> Result<Vec<(String, Sample)>> {
    let mut labels: Vec<&str> = Vec::new();
    for band in shaded {
        if !labels.contains(&band.label.as_str()) {
            labels.push(&band.label);
        }
    }
    let style = canvas::font(LABEL_FONT_PX, Paint::Muted, HPos::Center, VPos::Bottom);
    let mut written: Vec<Window> = Vec::new();
    let mut legend = Vec::new();
    for (index, label) in labels.into_iter().enumerate() {
        let hue = Hue::of_band(index);
        let label = text::printable(label);
        let label_width = units(text::width_px(&label, LABEL_FONT_PX));
        let mut named = label.is_empty();
        for window @ (from, to) in windows(shaded, &label, chart, frame) {
            tint(area, frame, window, hue)?;
            let free = written.iter().all(|other| to <= other.0 || from >= other.1);
            if !label.is_empty() && label_width <= to - from && free {
                area.draw_text(&label, &style, ((from + to) / 2, frame.top - units(3.0)))?;
                written.push(window);
                named = true;
            }
        }
        if !named {
            legend.push((label, Sample::Band(hue)));
        }
    }
    Ok(legend)
}

/// Tints a band along x between two clear edges; returns its legend row, or nothing if it is not in view.
pub(super) fn corridor(
    area: &Area<'_>,
    chart: &Chart<'_, '_>,
    frame: Rect,
    band: &Band,
) -> Result<Option<(String, Sample)>> {
    let (x, y) = (chart.x_range().start, chart.y_range());
    let (low, high) = (band.from.min(band.to), band.from.max(band.to));
    if !(low < y.end && high > y.start) {
        return Ok(None);
    }
    let at = |value: f64| chart.backend_coord(&(x, value.clamp(y.start, y.end))).1;
    let color = Paint::Hue(CORRIDOR).solid();
    let field = [(frame.left, at(high)), (frame.right, at(low))];
    area.draw(&Rectangle::new(field, color.mix(0.13).filled()))?;
    for value in [low, high].into_iter().filter(|value| y.contains(value)) {
        let edge = [(frame.left, at(value)), (frame.right, at(value))];
        let style = color.mix(0.55).stroke_width(SCALE.unsigned_abs());
        area.draw(&PathElement::new(edge, style))?;
    }
    let label = text::printable(&band.label);
    Ok((!label.is_empty()).then_some((label, Sample::Band(CORRIDOR))))
}

/// A faint field over the height of the frame, and a clear bar on its upper edge that survives a bad printer.
fn tint(area: &Area<'_>, frame: Rect, (from, to): Window, hue: Hue) -> Result<()> {
    let color = Paint::Hue(hue).solid();
    let field = [(from, frame.top), (to, frame.bottom)];
    area.draw(&Rectangle::new(field, color.mix(0.13).filled()))?;
    let edge = [(from, frame.top - units(2.0)), (to, frame.top)];
    area.draw(&Rectangle::new(edge, color.mix(0.8).filled()))?;
    Ok(())
}

/// Windows of one label, clipped to the frame, at least a pixel wide, merged where they overlap.
fn windows(shaded: &[Band], label: &str, chart: &Chart<'_, '_>, frame: Rect) -> Vec<Window> {
    let (x_range, y_range) = (chart.x_range(), chart.y_range());
    let in_view = |x: f64| {
        let x = x.clamp(x_range.start, x_range.end);
        chart.backend_coord(&(x, y_range.start)).0
    };
    let mut windows: Vec<Window> = shaded
        .iter()
        .filter(|band| text::printable(&band.label) == label)
        .filter(|band| !band.from.is_nan() && !band.to.is_nan())
        .map(|band| (band.from.min(band.to), band.from.max(band.to)))
        .filter(|&(from, to)| to >= x_range.start && from <= x_range.end)
        .map(|(from, to)| (in_view(from).min(frame.right - SCALE), in_view(to)))
        .map(|(from, to)| (from, to.max(from + SCALE)))
        .collect();
    windows.sort_unstable();
    merge(&windows)
}

/// Joins overlapping windows of a sorted list.
fn merge(sorted: &[Window]) -> Vec<Window> {
    let mut merged: Vec<Window> = Vec::new();
    for &(from, to) in sorted {
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
        assert_eq!(merge(&[(0, 4), (2, 3), (3, 9), (9, 10)]), [(0, 9), (9, 10)]);
    }
}
