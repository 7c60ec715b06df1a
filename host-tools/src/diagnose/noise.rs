//! The noise floor of a series, found from the series itself.

/// Makes the median absolute deviation of a normal variable its standard deviation.
const MAD_OF_NORMAL: f64 = 0.674_489_750_196_082;
/// Sum of squares of the binomials of a third difference: 1, 3, 3, 1.
const THIRD_DIFFERENCE: f64 = 20.0;
/// The same if the noise is itself the difference of white noise: 70 / 2.
const OF_DIFFERENCES: f64 = 35.0;

/// Standard deviation of the white noise on a smooth series; NaN below eight values.
///
/// The median absolute deviation of third differences does not see what is smooth, nor a few
/// jumps: an error of the model does not raise the floor.
pub(crate) fn floor(values: &[f64], noise_is_differenced: bool) -> f64 {
    let mut differences: Vec<f64> = values
        .windows(4)
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs())
        .filter(|d| d.is_finite())
        .collect();
    if differences.len() < 5 {
        return f64::NAN;
    }
    let factor = if noise_is_differenced {
        OF_DIFFERENCES
    } else {
        THIRD_DIFFERENCE
    };
    median(&mut differences) / (MAD_OF_NORMAL * factor.sqrt())
}

/// Median; the order of the values is lost. NaN of nothing.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    *median
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_smooth_error_does_not_raise_the_floor() {
        // A fixed, roughly uniform sequence with standard deviation 1/sqrt(12).
        let noise = |n: usize| {
            ((n as f64 * 0.754_877_666 + 0.3).fract()
                + (n as f64 * n as f64 * 0.569_840_290_998).fract())
            .fract()
                - 0.5
        };
        let clean: Vec<f64> = (0..4000).map(noise).collect();
        let dirty: Vec<f64> = (0..4000)
            .map(|n| noise(n) + 300.0 * (n as f64 * 0.01).sin())
            .collect();
        let (a, b) = (floor(&clean, false), floor(&dirty, false));
        assert!((a / b - 1.0).abs() < 0.02, "{a} {b}");
        assert!((a * 12.0_f64.sqrt() - 1.0).abs() < 0.25, "{a}");
    }
}
