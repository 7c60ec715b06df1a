//! How a value falls (or rises) step by step, as the error does when effects are added to a model.

use super::number::{self, Format};
use super::rows::{Row, RowChart};
use super::theme::{Hue, Paint};
use anyhow::Result;

/// The value after one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// What was done in the step; for the first level, where one starts.
    pub label: String,
    /// The value that this left, in the unit of the chart.
    pub value: f64,
    /// The same on other data, drawn as a thin bar below; see [`Waterfall::names`].
    pub second: Option<f64>,
}

impl Level {
    /// A level.
    pub fn new(label: impl Into<String>, value: f64) -> Self {
        Self {
            label: label.into(),
            value,
            second: None,
        }
    }

    /// The same level with its value on other data.
    #[must_use]
    pub fn with_second(mut self, value: f64) -> Self {
        self.second = Some(value);
        self
    }
}

/// A list of levels: the first as a full bar, each other as the difference that its step made, good if it brought
/// the value nearer to zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Waterfall {
    /// What the chart shows.
    pub title: String,
    /// What the values are, with their unit, as in `RMS force error [N]`.
    pub value_label: String,
    /// What the bars and the thin ones below them stand for, if there are both.
    pub names: Option<[String; 2]>,
    /// How the values are written.
    pub format: Format,
    /// The start and the steps, in order.
    pub levels: Vec<Level>,
    /// Width in pixels; the height follows from the number of levels.
    pub width: u32,
}

impl Waterfall {
    /// An empty list of the usual width, 860 pixels.
    pub fn new(title: impl Into<String>, value_label: impl Into<String>, format: Format) -> Self {
        Self {
            title: title.into(),
            value_label: value_label.into(),
            names: None,
            format,
            levels: Vec::new(),
            width: 860,
        }
    }

    /// The list as one SVG element that follows the page's light or dark colours.
    ///
    /// A level that is not finite gets its text and no bar; the next step starts at the last finite level.
    ///
    /// # Errors
    ///
    /// If the plotting library refuses the geometry; no data do that.
    pub fn to_svg(&self) -> Result<String> {
        let mut before = [None; 2];
        let mut rows = Vec::new();
        for level in &self.levels {
            rows.push(self.row(level, before));
            let finite = |value: f64| value.is_finite().then_some(value);
            let after = [finite(level.value), level.second.and_then(finite)];
            before = [after[0].or(before[0]), after[1].or(before[1])];
        }
        RowChart {
            title: &self.title,
            value_label: &self.value_label,
            names: self.names.as_ref(),
            rows,
            connected: true,
            width: self.width,
        }
        .to_svg()
    }

    /// A row; `before` is the last level and the last second level.
    fn row(&self, level: &Level, [before, second_before]: [Option<f64>; 2]) -> Row {
        let from = before.unwrap_or(0.0);
        let paint = match before {
            None => Paint::Hue(Hue::Grey),
            Some(before) if level.value.abs() <= before.abs() => Paint::Good,
            Some(_) => Paint::Bad,
        };
        let mut value = self.format.write(level.value);
        if let Some(change) = change(before, level.value) {
            value += &format!(" ({change})");
        }
        if let Some(second) = level.second {
            value += &format!(" | {}", self.format.write(second));
        }
        let second = level.second.filter(|second| second.is_finite());
        Row {
            label: level.label.clone(),
            value,
            bar: level.value.is_finite().then_some((from, level.value)),
            thin_bar: second.map(|second| (second_before.unwrap_or(0.0), second)),
            interval: None,
            dot: None,
            paint,
        }
    }
}

/// Relative change as `-59 %` or `+12 %`.
fn change(before: Option<f64>, after: f64) -> Option<String> {
    let relative = (after - before?) / before?.abs();
    let sign = if relative > 0.0 { "+" } else { "" };
    relative
        .is_finite()
        .then(|| format!("{sign}{}", number::percent(relative, 0)))
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
}
