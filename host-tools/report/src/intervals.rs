//! Intervals around estimates of different units: how well the data determine each of them.

use super::number;
use super::rows::{Row, RowChart};
use super::theme::{Hue, Paint};
use anyhow::Result;

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

/// A list of intervals, each relative to its own value, so that units do not matter.
#[derive(Clone, Debug, PartialEq)]
pub struct IntervalChart {
    /// What the chart shows.
    pub title: String,
    /// The intervals, from top to bottom.
    pub intervals: Vec<Interval>,
    /// Width in pixels; the height follows from the number of intervals.
    pub width: u32,
}

impl IntervalChart {
    /// A chart of the usual width, 860 pixels.
    pub fn new(title: impl Into<String>, intervals: Vec<Interval>) -> Self {
        Self {
            title: title.into(),
            intervals,
            width: 860,
        }
    }

    /// The chart as one SVG element that follows the page's light or dark colours.
    ///
    /// The interval of a value that is zero, or one without a finite end, cannot be drawn to the others' scale: it is
    /// written as `n/a`.
    ///
    /// # Errors
    ///
    /// If the plotting library refuses the geometry; no data do that.
    pub fn to_svg(&self) -> Result<String> {
        RowChart {
            title: &self.title,
            value_label: "relative to the value",
            names: None,
            rows: self.intervals.iter().map(row).collect(),
            connected: false,
            width: self.width,
        }
        .to_svg()
    }
}

fn row(interval: &Interval) -> Row {
    let relative = relative(interval);
    Row {
        label: interval.label.clone(),
        value: relative.map_or("n/a".to_owned(), |(low, high)| {
            format!("{} … +{}", percent(low), percent(high))
        }),
        bar: None,
        thin_bar: None,
        interval: relative,
        dot: relative.map(|_| 0.0),
        paint: Paint::Hue(Hue::Blue),
    }
}

/// Ends of the interval in parts of the value's magnitude, from the value.
fn relative(interval: &Interval) -> Option<(f64, f64)> {
    let size = interval.value.abs();
    let ends = (
        (interval.low - interval.value) / size,
        (interval.high - interval.value) / size,
    );
    (ends.0.is_finite() && ends.1.is_finite()).then_some(ends)
}

/// A part in percent with two significant digits.
fn percent(part: f64) -> String {
    format!("{} %", number::significant(part * 100.0, 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(value: f64, low: f64, high: f64) -> Row {
        row(&Interval {
            label: "delay_s".to_owned(),
            value,
            low,
            high,
        })
    }

    #[test]
    fn an_interval_is_relative_to_the_size_of_its_value() {
        let row = of(-2.0, -2.5, -1.8);
        assert_eq!(row.value, "-25 % … +10 %");
        let (low, high) = row.interval.unwrap();
        assert!((low + 0.25).abs() < 1e-12 && (high - 0.1).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_drawn_to_scale_is_said() {
        for row in [of(0.0, -1.0, 1.0), of(1.0, 0.5, f64::INFINITY)] {
            assert_eq!(
                (row.value.as_str(), row.interval, row.dot),
                ("n/a", None, None)
            );
        }
    }
}
