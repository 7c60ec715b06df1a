//! Ranked shares as horizontal bars.

use super::number::Format;
use super::rows::{Row, RowChart};
use super::theme::{Hue, Paint};
use anyhow::Result;

/// One bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// What the bar stands for.
    pub label: String,
    /// Its length, in the unit of the chart.
    pub value: f64,
    /// The same quantity on other data, drawn as a thin bar below; see [`BarChart::names`].
    pub second: Option<f64>,
    /// Uncertainty interval (low, high) in the same unit, drawn as a whisker.
    pub interval: Option<(f64, f64)>,
    /// Colour; by default all bars are of one colour.
    pub color: Option<Hue>,
}

impl Bar {
    /// A bar without an interval.
    pub fn new(label: impl Into<String>, value: f64) -> Self {
        Self {
            label: label.into(),
            value,
            second: None,
            interval: None,
            color: None,
        }
    }

    /// The same bar with a thin one below it.
    #[must_use]
    pub fn with_second(mut self, value: f64) -> Self {
        self.second = Some(value);
        self
    }

    /// The same bar with an uncertainty interval.
    #[must_use]
    pub fn with_interval(mut self, low: f64, high: f64) -> Self {
        self.interval = Some((low, high));
        self
    }
}

/// Horizontal bars from zero, one below the other in the order given.
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
    /// The bars, best first.
    pub bars: Vec<Bar>,
    /// Width in pixels; the height follows from the number of bars.
    pub width: u32,
}

impl BarChart {
    /// An empty chart of the usual width, 860 pixels.
    pub fn new(title: impl Into<String>, value_label: impl Into<String>, format: Format) -> Self {
        Self {
            title: title.into(),
            value_label: value_label.into(),
            names: None,
            format,
            bars: Vec::new(),
            width: 860,
        }
    }

    /// The chart as one SVG element that follows the page's light or dark colours.
    ///
    /// A value that is not finite gets its text and no bar.
    ///
    /// # Errors
    ///
    /// If the plotting library refuses the geometry; no data do that.
    pub fn to_svg(&self) -> Result<String> {
        let rows = self.bars.iter().map(|bar| self.row(bar)).collect();
        RowChart {
            title: &self.title,
            value_label: &self.value_label,
            names: self.names.as_ref(),
            rows,
            connected: false,
            width: self.width,
        }
        .to_svg()
    }

    fn row(&self, bar: &Bar) -> Row {
        let interval = bar
            .interval
            .filter(|(low, high)| low.is_finite() && high.is_finite());
        Row {
            label: bar.label.clone(),
            value: self.format.write(bar.value),
            bar: bar.value.is_finite().then_some((0.0, bar.value)),
            thin_bar: bar.second.filter(|v| v.is_finite()).map(|v| (0.0, v)),
            interval,
            dot: None,
            paint: Paint::Hue(bar.color.unwrap_or(Hue::Blue)),
        }
    }
}
