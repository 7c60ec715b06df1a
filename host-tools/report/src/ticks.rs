//! Axis ticks at round numbers, with a common power of a thousand where the numbers are large or small.

use super::number;
use std::ops::Range;

/// Largest magnitude that an axis shows; beyond it the span of a range could overflow.
pub(super) const LARGEST: f64 = 1e150;

/// Spans below this part of the magnitude are only rounding noise.
const SMALLEST_RELATIVE_SPAN: f64 = 1e-9;

/// Axis numbers outside this range are written in units of a power of a thousand.
const PLAIN: Range<f64> = 1e-2..1e5;

/// Round numbers along an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    /// Positions in the units of the data.
    pub(super) values: Vec<f64>,
    /// Labels are `value / 10^exponent`; a multiple of three.
    pub(super) exponent: i32,
    decimals: usize,
}

impl Ticks {
    /// Chooses about `wanted` ticks at steps of 1, 2 or 5 times a power of ten inside `range`.
    pub(super) fn new(range: &Range<f64>, wanted: usize) -> Self {
        let step = round_step((range.end - range.start) / wanted.max(1) as f64);
        let first = (range.start / step - 1e-6).ceil() as i64;
        let last = (range.end / step + 1e-6).floor() as i64;
        let values = (first..=last.min(first.saturating_add(100)))
            .map(|index| index as f64 * step)
            .collect();
        let magnitude = range.start.abs().max(range.end.abs());
        let exponent = if PLAIN.contains(&magnitude) {
            0
        } else {
            (magnitude.log10() / 3.0).floor() as i32 * 3
        };
        let decimals = (f64::from(exponent) - step.log10() - 1e-9)
            .ceil()
            .clamp(0.0, 12.0) as usize;
        Self {
            values,
            exponent,
            decimals,
        }
    }

    /// The label of the tick at `value`, with a true minus sign.
    pub(super) fn label(&self, value: f64) -> String {
        number::fixed(value * 10f64.powi(-self.exponent), self.decimals).replace('-', "−")
    }

    /// Length of the longest label, in characters.
    pub(super) fn longest_label(&self) -> usize {
        let lengths = self
            .values
            .iter()
            .map(|value| self.label(*value).chars().count());
        lengths.max().unwrap_or(1)
    }

    /// Puts the power of ten into the unit of an axis label: `force [N]` becomes `force [10³ N]`.
    pub(super) fn with_exponent(&self, axis_label: &str) -> String {
        if self.exponent == 0 {
            return axis_label.to_owned();
        }
        let power: String = format!("10{}", self.exponent)
            .chars()
            .enumerate()
            .map(superscript)
            .collect();
        match axis_label.rsplit_once('[') {
            Some((name, unit)) => format!("{name}[{power} {unit}"),
            None => format!("{axis_label} [{power}]").trim_start().to_owned(),
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
    // Below the smallest normal step neither the span nor a tick step can be divided any further.
    if span <= magnitude * SMALLEST_RELATIVE_SPAN || span < 1e-290 {
        let half = if magnitude < 1e-290 {
            1.0
        } else {
            magnitude * 0.1
        };
        return low - half..high + half;
    }
    low - span * margin..high + span * margin
}

/// The step of 1, 2 or 5 times a power of ten that is nearest to `rough` (by ratio).
fn round_step(rough: f64) -> f64 {
    let power = 10f64.powf(rough.log10().floor());
    let factor = match rough / power {
        ..1.414 => 1.0,
        ..3.162 => 2.0,
        ..7.071 => 5.0,
        _ => 10.0,
    };
    factor * power
}

fn superscript((index, c): (usize, char)) -> char {
    match (index, c) {
        // The base "10" stays on the line.
        (0 | 1, c) => c,
        (_, '-') => '⁻',
        (_, '1') => '¹',
        (_, '2') => '²',
        (_, '3') => '³',
        (_, c) => c
            .to_digit(10)
            .and_then(|digit| char::from_u32(0x2070 + digit))
            .unwrap_or(c),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(range: Range<f64>, wanted: usize) -> Vec<String> {
        let ticks = Ticks::new(&range, wanted);
        ticks
            .values
            .iter()
            .map(|value| ticks.label(*value))
            .collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(0.0..10.0, 5), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(
            labels(-0.13..0.12, 5),
            ["−0.10", "−0.05", "0.00", "0.05", "0.10"]
        );
        assert_eq!(labels(0.0..0.004, 4), ["0", "1", "2", "3", "4"]);
        assert_eq!(labels(0.0..250_000.0, 3), ["0", "100", "200"]);
    }

    #[test]
    fn the_power_of_ten_goes_into_the_unit() {
        let small = Ticks::new(&(0.0..0.004), 4);
        assert_eq!(small.with_exponent("velocity [m/s]"), "velocity [10⁻³ m/s]");
        assert_eq!(
            Ticks::new(&(0.0..2.5e7), 4).with_exponent("stiffness"),
            "stiffness [10⁶]"
        );
        assert_eq!(
            Ticks::new(&(0.0..10.0), 4).with_exponent("force [N]"),
            "force [N]"
        );
    }

    #[test]
    fn degenerate_data_get_a_range() {
        assert_eq!(range_of([].into_iter(), 0.05), 0.0..1.0);
        assert_eq!(
            range_of([f64::NAN, f64::INFINITY].into_iter(), 0.05),
            0.0..1.0
        );
        assert_eq!(range_of([0.0, 0.0].into_iter(), 0.05), -1.0..1.0);
        assert_eq!(range_of([10.0].into_iter(), 0.05), 9.0..11.0);
    }

    proptest! {
        #[test]
        fn any_data_get_a_few_ticks_inside_a_proper_range(
            values in proptest::collection::vec(proptest::num::f64::ANY, 0..6),
            wanted in 1usize..12,
        ) {
            let range = range_of(values.into_iter(), 0.05);
            prop_assert!(range.start.is_finite() && range.end.is_finite() && range.start < range.end);
            let ticks = Ticks::new(&range, wanted);
            prop_assert!(!ticks.values.is_empty() || wanted < 2);
            prop_assert!(ticks.values.len() <= 2 * wanted + 2);
            prop_assert!(ticks.longest_label() <= 20);
        }
    }
}
