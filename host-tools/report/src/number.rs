//! Numbers as text: significant digits, engineering exponents, percentages; never "-0.000".

/// How a chart or a table writes a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// This many significant digits, see [`significant`].
    Significant(usize),
    /// The number is a fraction of one; written in percent with this many decimals, see [`percent`].
    Percent(usize),
    /// This many decimals, see [`fixed`].
    Fixed(usize),
}

impl Format {
    /// Writes `value` in this format.
    pub fn write(self, value: f64) -> String {
        match self {
            Self::Significant(digits) => significant(value, digits),
            Self::Percent(decimals) => percent(value, decimals),
            Self::Fixed(decimals) => fixed(value, decimals),
        }
    }
}

/// Most significant digits that an f64 carries through text and back.
const MAX_DIGITS: usize = 15;

/// By how much of the last digit a decimal number may miss its digits because it is stored in binary.
const BINARY: f64 = 1e-3;

/// Percentages from here on are written with an exponent instead of a row of digits.
const LARGE_PERCENT: f64 = 1e6;

/// Writes `value` rounded to `digits` significant digits (1 to 15).
///
/// From 0.001 up to a million in plain decimals, outside with an exponent that is a multiple of three
/// (`12.3e-6`), as prefixes of units are. A value that is not a number is `n/a`.
pub fn significant(value: f64, digits: usize) -> String {
    if let Some(text) = not_finite(value) {
        return text;
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let last_digit = digits.clamp(1, MAX_DIGITS) - 1;
    // The standard formatter rounds first and finds the exponent after that, so that 9.996 becomes 1.00e1.
    let scientific = format!("{value:.last_digit$e}");
    let Some((mantissa, exponent)) = split_exponent(&scientific) else {
        return scientific;
    };
    let decimals = |shift: usize| last_digit.saturating_sub(shift);
    match exponent {
        -3..0 => fixed(value, last_digit + exponent.unsigned_abs() as usize),
        0..6 => {
            let rounded = scientific.parse().unwrap_or(value);
            fixed(rounded, decimals(exponent.unsigned_abs() as usize))
        }
        _ => {
            let shift = exponent.rem_euclid(3);
            let scaled = mantissa * 10f64.powi(shift);
            format!(
                "{}e{}",
                fixed(scaled, decimals(shift.unsigned_abs() as usize)),
                exponent - shift
            )
        }
    }
}

/// Writes `value` with exactly `decimals` decimals; a value that rounds to zero has no sign.
pub fn fixed(value: f64, decimals: usize) -> String {
    if let Some(text) = not_finite(value) {
        return text;
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if !zero.contains(|c: char| ('1'..='9').contains(&c)) => zero.to_owned(),
        _ => text,
    }
}

/// Writes the fraction `fraction` (1 is the whole) in percent with `decimals` decimals: `0.123` is `12.3 %`.
pub fn percent(fraction: f64, decimals: usize) -> String {
    let percent = fraction * 100.0;
    if percent.is_nan() {
        "n/a".to_owned()
    } else if percent.abs() < LARGE_PERCENT {
        format!("{} %", fixed(percent, decimals))
    } else {
        format!("{} %", significant(percent, 3))
    }
}

/// Writes an interval with as many decimals as show its width with `digits` significant digits: `[28.1, 35.2]`,
/// `[225.4e-6, 226.2e-6]`.
///
/// The bounds of a narrow interval around a large value therefore still differ in print. They are rounded outwards, so that what is
/// inside stays inside. An interval that excludes 0 shows that: `[0.02, 1.13]`, unless it does so by less than a ten-thousandth of its
/// width.
pub fn interval(low: f64, high: f64, digits: usize) -> String {
    let width = (high - low).abs();
    let largest = low.abs().max(high.abs());
    if !width.is_finite() || width == 0.0 {
        return format!(
            "[{}, {}]",
            significant(low, digits),
            significant(high, digits)
        );
    }
    // Where [`significant`] writes an exponent, both bounds have that of the larger one.
    let exponent = match largest {
        1e-3..1e6 => 0,
        _ => largest.log10().floor() as i32,
    };
    let exponent = exponent - exponent.rem_euclid(3);
    let scale = 10f64.powi(-exponent);
    let digits = digits.clamp(1, MAX_DIGITS) as f64;
    let place = |value: f64| -(value * scale).abs().log10().floor();
    let plain = digits - 1.0 + place(width);
    let nearest = low.abs().min(high.abs());
    let shown = match low * high > 0.0 && nearest > 1e-4 * width {
        true => plain.max(place(nearest)),
        false => plain,
    };
    let decimals = shown.clamp(0.0, 12.0) as usize;
    let bound = |value: f64, outwards: fn(f64) -> f64, slack: f64| {
        let digit = 10f64.powi(-(decimals as i32));
        let rounded = outwards(value * scale / digit + slack) * digit;
        match exponent {
            0 => fixed(rounded, decimals),
            _ => format!("{}e{exponent}", fixed(rounded, decimals)),
        }
    };
    format!(
        "[{}, {}]",
        bound(low, f64::floor, BINARY),
        bound(high, f64::ceil, -BINARY)
    )
}

fn not_finite(value: f64) -> Option<String> {
    if value.is_nan() {
        Some("n/a".to_owned())
    } else if value.is_infinite() {
        Some(if value > 0.0 { "inf" } else { "-inf" }.to_owned())
    } else {
        None
    }
}

fn split_exponent(scientific: &str) -> Option<(f64, i32)> {
    let (mantissa, exponent) = scientific.split_once('e')?;
    Some((mantissa.parse().ok()?, exponent.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn significant_digits_read_as_an_engineer_writes_them() {
        let cases = [
            (0.0, 3, "0"),
            (-0.0, 3, "0"),
            (1.0, 3, "1.00"),
            (9.996, 3, "10.0"),
            (-12.345, 3, "-12.3"),
            (12_345.0, 3, "12300"),
            (999_999.0, 3, "1.00e6"),
            (0.001_234, 3, "0.00123"),
            (0.000_999_96, 3, "0.00100"),
            (0.000_012_34, 3, "12.3e-6"),
            (-2.5e9, 2, "-2.5e9"),
            (123_456_789.0, 2, "120e6"),
            (f64::NAN, 3, "n/a"),
            (f64::NEG_INFINITY, 3, "-inf"),
        ];
        for (value, digits, expected) in cases {
            assert_eq!(significant(value, digits), expected, "{value} to {digits}");
        }
    }

    #[test]
    fn nothing_is_minus_zero() {
        assert_eq!(fixed(-0.0004, 3), "0.000");
        assert_eq!(fixed(-0.0006, 3), "-0.001");
        assert_eq!(percent(-0.000_04, 1), "0.0 %");
    }

    #[test]
    fn percentages_are_fractions_of_one() {
        assert_eq!(percent(0.1234, 1), "12.3 %");
        assert_eq!(percent(-0.59, 0), "-59 %");
        assert_eq!(percent(f64::NAN, 1), "n/a");
        assert_eq!(percent(1e9, 1), "100e9 %");
    }

    #[test]
    fn bounds_of_a_narrow_interval_differ_in_print() {
        assert_eq!(interval(28.1, 35.2, 2), "[28.1, 35.2]");
        assert_eq!(interval(1000.01, 1000.05, 2), "[1000.010, 1000.050]");
        assert_eq!(interval(1e-5, 2e-5, 2), "[10e-6, 20e-6]");
        assert_eq!(interval(0.023, 1.126, 2), "[0.02, 1.13]");
        assert_eq!(interval(-1.126, -0.023, 2), "[-1.13, -0.02]");
        assert_eq!(interval(0.0, 1.126, 2), "[0.0, 1.2]");
        assert_eq!(interval(-0.003, 1.126, 2), "[-0.1, 1.2]");
        assert_eq!(interval(1e-6, 1.126, 2), "[0.0, 1.2]");
        assert_eq!(interval(0.0894, 0.09915, 2), "[0.0894, 0.0992]");
        assert_eq!(interval(1.0, f64::INFINITY, 2), "[1.0, inf]");
    }

    proptest! {
        #[test]
        fn significant_reads_back_within_half_a_digit(value in proptest::num::f64::NORMAL, digits in 1usize..=15) {
            // Rounded up it would be beyond the largest number.
            prop_assume!(value.abs() < 1e308);
            let text = significant(value, digits);
            let read: f64 = text.parse().unwrap();
            let tolerance = 0.500_001 * 10f64.powi(1 - digits as i32) + 1e-15;
            prop_assert!(((read - value) / value).abs() <= tolerance, "{value} became {text}");
        }

        #[test]
        fn any_bits_are_written_without_panic(bits in any::<u64>(), other in any::<u64>(), digits in 0usize..40) {
            let value = f64::from_bits(bits);
            for text in [significant(value, digits), percent(value, digits), interval(value, f64::from_bits(other), digits)] {
                prop_assert!(!text.is_empty());
            }
        }
    }
}
