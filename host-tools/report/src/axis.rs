//! A linear axis: the range of the data, and the numbers written along it.

use super::number;
use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// Largest magnitude that an axis shows; beyond it the span of a range could overflow.
pub(super) const LARGEST: f64 = 1e150;

/// Spans below this part of the magnitude are only rounding noise.
const SMALLEST_RELATIVE_SPAN: f64 = 1e-9;

/// Below this step neither a span nor a tick step can be divided any further.
const SMALLEST_SPAN: f64 = 1e-290;

/// Axis numbers outside this range are written in units of a power of a thousand.
const PLAIN: Range<f64> = 1e-2..1e5;

const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// A linear axis over a range that is finite and not empty.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// Range of the axis, in the unit of the data.
    pub(super) range: Range<f64>,
    /// Largest number of ticks.
    pub(super) most_ticks: usize,
    /// The numbers on the axis are the data divided by ten to this power, a multiple of three.
    exponent: i32,
    decimals: usize,
}

impl Axis {
    /// An axis with at most this many ticks.
    pub(super) fn new(range: Range<f64>, most_ticks: usize) -> Self {
        let magnitude = range.start.abs().max(range.end.abs());
        let exponent = if PLAIN.contains(&magnitude) {
            0
        } else {
            (magnitude.log10() / 3.0).floor() as i32 * 3
        };
        let mut axis = Self {
            range,
            most_ticks: most_ticks.max(2),
            exponent,
            decimals: 0,
        };
        if let [first, second, ..] = axis.ticks()[..] {
            let step: f64 = second - first;
            axis.decimals = (-step.log10() - 1e-6).ceil().clamp(0.0, 12.0) as usize;
        }
        axis
    }

    /// Position of a value: 0 at the start of the range, 1 at its end.
    pub(super) fn part(&self, value: f64) -> f64 {
        (value - self.range.start) / (self.range.end - self.range.start)
    }

    /// The range in the unit of the numbers on the axis.
    pub(super) fn shown_range(&self) -> Range<f64> {
        let unit = 10f64.powi(-self.exponent);
        self.range.start * unit..self.range.end * unit
    }

    /// Round numbers along the axis, as plotters chooses them.
    fn ticks(&self) -> Vec<f64> {
        RangedCoordf64::from(self.shown_range()).key_points(self.most_ticks)
    }

    /// A number on the axis, with a true minus sign.
    pub(super) fn label(&self, shown: f64) -> String {
        number::fixed(shown, self.decimals).replace('-', "−")
    }

    /// Length of the longest label, in characters.
    pub(super) fn longest_label(&self) -> usize {
        let labels = self.ticks().into_iter().map(|tick| self.label(tick));
        labels.map(|label| label.chars().count()).max().unwrap_or(1)
    }

    /// Puts the power of ten into the unit of an axis label: `force [N]` becomes `force [10³ N]`.
    pub(super) fn with_exponent(&self, axis_label: &str) -> String {
        if self.exponent == 0 {
            return axis_label.to_owned();
        }
        let exponent = self.exponent.to_string();
        let superscript = |c: char| c.to_digit(10).map_or('⁻', |d| SUPERSCRIPTS[d as usize]);
        let power: String = exponent.chars().map(superscript).collect();
        match axis_label.rsplit_once('[') {
            Some((name, unit)) => format!("{name}[10{power} {unit}"),
            None => format!("{axis_label} [10{power}]").trim_start().to_owned(),
        }
    }
}

/// Range that shows all `values` with a margin of `margin` of the span at both ends; never empty.
///
/// Values that are not finite are left out. Constant data get a range around them, no data get 0 to 1.
pub(super) fn range_of(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .map(|value| value.clamp(-LARGEST, LARGEST))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low > high {
        return 0.0..1.0;
    }
    let magnitude = low.abs().max(high.abs());
    let span = high - low;
    if span > magnitude * SMALLEST_RELATIVE_SPAN && span >= SMALLEST_SPAN {
        low - span * margin..high + span * margin
    } else if magnitude < SMALLEST_SPAN {
        low - 1.0..high + 1.0
    } else {
        low - magnitude * 0.1..high + magnitude * 0.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(range: Range<f64>, most: usize) -> Vec<String> {
        let axis = Axis::new(range, most);
        axis.ticks()
            .into_iter()
            .map(|tick| axis.label(tick))
            .collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(0.0..10.0, 6), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(
            labels(-0.13..0.12, 5),
            ["−0.10", "−0.05", "0.00", "0.05", "0.10"]
        );
        assert_eq!(labels(0.0..0.004, 5), ["0", "1", "2", "3", "4"]);
        assert_eq!(labels(0.0..250_000.0, 3), ["0", "100", "200"]);
    }

    #[test]
    fn the_power_of_ten_goes_into_the_unit() {
        let on_axis = |end, label| Axis::new(0.0..end, 4).with_exponent(label);
        assert_eq!(on_axis(0.004, "velocity [m/s]"), "velocity [10⁻³ m/s]");
        assert_eq!(on_axis(2.5e7, "stiffness"), "stiffness [10⁶]");
        assert_eq!(on_axis(10.0, "force [N]"), "force [N]");
    }

    #[test]
    fn degenerate_data_get_a_range() {
        let of = |values: &[f64]| range_of(values.iter().copied(), 0.05);
        assert_eq!(of(&[]), 0.0..1.0);
        assert_eq!(of(&[f64::NAN, f64::INFINITY]), 0.0..1.0);
        assert_eq!(of(&[0.0, 0.0]), -1.0..1.0);
        assert_eq!(of(&[10.0]), 9.0..11.0);
    }

    proptest! {
        #[test]
        fn any_data_get_a_few_ticks_inside_a_proper_range(
            values in proptest::collection::vec(proptest::num::f64::ANY, 0..6),
            most in 2usize..12,
        ) {
            let range = range_of(values.into_iter(), 0.05);
            prop_assert!(range.start.is_finite() && range.end.is_finite() && range.start < range.end);
            let axis = Axis::new(range, most);
            prop_assert!(axis.ticks().len() <= most);
            prop_assert!(axis.longest_label() <= 20);
        }
    }
}
