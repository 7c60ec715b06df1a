//! Dependence of a series on the present or a past value of another one.

use super::correlation::autocorrelation;
use super::significance::normal_p;

/// Longest lag of the input, in samples.
const LAGS: usize = 25;
/// Longest lag up to which the autocorrelation of the residual is taken into account.
const MEMORY: usize = 150;
/// Fewer pairs than this are not tested.
const LEAST_PAIRS: usize = 50;

/// Result of an independence test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dependence {
    /// Magnitude of the regression coefficient over its standard error, at the lag with the largest correlation.
    pub statistic: f64,
    /// That lag: the number of samples by which the series follows the input.
    pub lag: usize,
    /// p-value: probability of at least this statistic for an independent series, corrected for the number of lags.
    pub p: f64,
}

/// Tests whether a series depends on the past of an input, at that lag of 0 to 25 with the largest correlation.
///
/// The standard error is that of a regression with an autocorrelated residual (Newey and West 1987). Otherwise a slow error
/// that is unrelated to a slow input would become significant merely by the number of values. None if there are too few
/// values, or the input is constant.
pub fn dependence(series: &[f64], input: &[f64]) -> Option<Dependence> {
    let input = about_mean(input)?;
    let by_correlation = |lag: &usize| regression(series, &input, *lag).map_or(0.0, |r| r.strength);
    let lag = (0..=LAGS).max_by(|a, b| by_correlation(a).total_cmp(&by_correlation(b)))?;
    let fit = regression(series, &input, lag)?;
    let remainder: Vec<f64> = pairs(series, &input, lag)
        .map(|(value, u)| value - fit.coefficient * u)
        .collect();
    let shifted: Vec<f64> = pairs(series, &input, lag).map(|(_, u)| u).collect();
    let error = standard_error(&remainder, &shifted, fit.squares);
    let statistic = fit.coefficient.abs() / error;
    if !statistic.is_finite() {
        return None;
    }
    Some(Dependence {
        statistic,
        lag,
        p: (normal_p(statistic) * (LAGS + 1) as f64).min(1.0),
    })
}

fn about_mean(input: &[f64]) -> Option<Vec<f64>> {
    let known = || input.iter().filter(|v| v.is_finite());
    let mean = known().sum::<f64>() / known().count().max(1) as f64;
    let centred: Vec<f64> = input.iter().map(|v| v - mean).collect();
    let largest = known().fold(0.0, |m: f64, v| m.max(v.abs()));
    let changes = centred.iter().any(|v| v.abs() > 1e-9 * largest);
    changes.then_some(centred)
}

/// Pairs of a value and the input `lag` values earlier.
fn pairs<'a>(
    series: &'a [f64],
    input: &'a [f64],
    lag: usize,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    series.iter().skip(lag).copied().zip(input.iter().copied())
}

struct Regression {
    coefficient: f64,
    /// Sum of squares of the input.
    squares: f64,
    /// Correlation, 0 to 1.
    strength: f64,
}

fn regression(series: &[f64], input: &[f64], lag: usize) -> Option<Regression> {
    let (mut products, mut squares, mut own, mut count) = (0.0, 0.0, 0.0, 0);
    for (value, u) in pairs(series, input, lag) {
        if value.is_finite() && u.is_finite() {
            products += value * u;
            squares += u * u;
            own += value * value;
            count += 1;
        }
    }
    (count >= LEAST_PAIRS && squares > 0.0 && own > 0.0).then(|| Regression {
        coefficient: products / squares,
        squares,
        strength: products.abs() / (squares * own).sqrt(),
    })
}

/// Standard error of the coefficient: `√(Σ w(k) γ(k) R(k)) / R(0)` with the autocovariance γ of the residual, the sums R(k)
/// of products of the input at lag k, and weights w that fall linearly to zero.
fn standard_error(remainder: &[f64], input: &[f64], squares: f64) -> f64 {
    let count = remainder.iter().filter(|v| v.is_finite()).count();
    let known = remainder.iter().filter(|v| v.is_finite());
    let variance = known.map(|v| v * v).sum::<f64>() / count.max(1) as f64;
    let memory = MEMORY.min(count / 4);
    let of_remainder = autocorrelation(remainder, memory);
    let of_input = autocorrelation(input, memory);
    let weighted = (1..=memory).map(|k| {
        let weight = 1.0 - k as f64 / (memory + 1) as f64;
        2.0 * weight * of_remainder[k] * of_input[k]
    });
    // Never less than with a white residual, even if the residual alternates.
    let inflation = (1.0 + weighted.sum::<f64>()).max(1.0);
    (variance * inflation / squares).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::noise_floor::tests::normal;
    use super::*;

    fn slow(count: usize, rate: f64) -> Vec<f64> {
        (0..count).map(|n| (n as f64 * rate).sin()).collect()
    }

    #[test]
    fn a_delayed_tenth_of_the_input_is_found_with_its_lag() {
        let input = normal(2500, 1);
        let series: Vec<f64> = normal(2500, 2)
            .iter()
            .enumerate()
            .map(|(n, v)| v + if n >= 7 { 0.2 * input[n - 7] } else { 0.0 })
            .collect();
        let found = dependence(&series, &input).unwrap();
        assert_eq!(found.lag, 7);
        assert!(found.p < 1e-9, "{found:?}");
    }

    #[test]
    fn noise_depends_on_nothing() {
        let input = slow(1500, 0.02);
        let significant = |seed: &u64| dependence(&normal(1500, *seed), &input).unwrap().p < 0.01;
        assert!((0..100_u64).filter(significant).count() <= 4);
    }

    #[test]
    fn a_slow_error_is_not_blamed_on_another_slow_signal() {
        let error: Vec<f64> = slow(2500, 0.0031)
            .iter()
            .zip(normal(2500, 3))
            .map(|(s, v)| 3.0 * s + v)
            .collect();
        let found = dependence(&error, &slow(2500, 0.0137)).unwrap();
        assert!(found.p > 0.01, "{found:?}");
    }

    #[test]
    fn a_constant_input_says_nothing() {
        assert_eq!(dependence(&normal(500, 1), &[3.0; 500]), None);
        assert_eq!(dependence(&normal(500, 1), &[f64::NAN; 500]), None);
        assert_eq!(dependence(&[0.0; 500], &normal(500, 1)), None);
    }
}
