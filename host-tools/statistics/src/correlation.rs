//! Autocorrelation of a series.

use super::significance::chi_square_p;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex;

/// Number of lags of the whiteness test.
const TESTED_LAGS: usize = 25;
/// Series with fewer known values than this are not tested.
const LEAST_PAIRS: usize = 50;
/// A sum of autocorrelations is cut where the lag exceeds so many times the sum (Sokal 1997).
const SOKAL_WINDOW: f64 = 5.0;

/// Autocorrelation about zero at the lags 0 to `lags`; all zero for a series of zeros.
///
/// It is taken about zero and not about the mean, as an error with a constant mean is not noise.
pub fn autocorrelation(series: &[f64], lags: usize) -> Vec<f64> {
    let squares = product_sum(series, 0);
    (0..=lags)
        .map(|lag| {
            if squares > 0.0 {
                product_sum(series, lag) / squares
            } else {
                0.0
            }
        })
        .collect()
}

/// Sum of products of values that are `lag` apart.
fn product_sum(series: &[f64], lag: usize) -> f64 {
    let later = series.get(lag..).unwrap_or_default();
    let products = series.iter().zip(later).map(|(a, b)| a * b);
    products.filter(|p| p.is_finite()).sum()
}

/// [`product_sum`] at all lags at once, by FFT: an error that lasts long needs thousands of lags. Missing values count as
/// zero. The series is padded with at least as many zeros as it has values, so that its end does not wrap around to its
/// beginning.
fn product_sums(series: &[f64]) -> Vec<f64> {
    let count = series.len();
    let known = series.iter().map(|v| if v.is_finite() { *v } else { 0.0 });
    let mut buffer: Vec<Complex<f64>> = known.map(|v| Complex::new(v, 0.0)).collect();
    buffer.resize((2 * count).next_power_of_two(), Complex::default());
    let mut planner = FftPlannerScalar::new();
    planner.plan_fft_forward(buffer.len()).process(&mut buffer);
    buffer
        .iter_mut()
        .for_each(|c| *c = Complex::new(c.norm_sqr(), 0.0));
    planner.plan_fft_inverse(buffer.len()).process(&mut buffer);
    let size = buffer.len() as f64;
    buffer[..count].iter().map(|c| c.re / size).collect()
}

/// Integrated autocorrelation time: the number of successive values that carry as much information as one independent value,
/// at least 1. It is `1 + 2 Σ ρ(k)`, cut by Sokal's window (1997), or after a quarter of the series.
pub fn correlated_cycles(series: &[f64]) -> f64 {
    if product_sum(series, 0) <= 0.0 {
        return 1.0;
    }
    let products = product_sums(series);
    let mut sum = 1.0_f64;
    for (lag, product) in products.iter().enumerate().take(series.len() / 4).skip(1) {
        sum += 2.0 * product / products[0];
        if lag as f64 >= SOKAL_WINDOW * sum.max(1.0) {
            break;
        }
    }
    sum.max(1.0)
}

/// Result of a whiteness test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whiteness {
    /// Sum of the squared autocorrelations times the number of values, scaled so that its
    /// expectation for noise is the number of lags.
    pub statistic: f64,
    /// p-value: probability of at least this statistic for noise.
    pub p: f64,
    /// Standard deviation of one autocorrelation of noise.
    pub band: f64,
}

/// Test of Box and Pierce (1970) against noise that may be correlated over at most `correlated_lags` lags, as by differences
/// and a sensor's filter. The 25 lags after these are tested.
///
/// For such noise the autocorrelations at later lags have the covariance `Σ ρ(i) ρ(i + k − l) / N` (Bartlett 1946), with the
/// estimated ρ up to `correlated_lags`. Their sum of squares is approximately a chi-square variable with the same mean and
/// variance (Satterthwaite 1946).
///
/// None for a series that is too short, or that is zero.
pub fn whiteness(series: &[f64], correlated_lags: usize) -> Option<Whiteness> {
    let count = series.iter().filter(|v| v.is_finite()).count();
    let first = correlated_lags + 1;
    let lags = TESTED_LAGS.min(count / 4);
    if count < LEAST_PAIRS || product_sum(series, 0) <= 0.0 {
        return None;
    }
    let found = autocorrelation(series, first + lags - 1);
    let sum: f64 = found[first..].iter().map(|r| r * r).sum::<f64>() * count as f64;
    let covariance = |apart: i64| -> f64 {
        let noise = &found[..first];
        let q = correlated_lags as i64;
        (-q..=q)
            .map(|i| of_noise(noise, i) * of_noise(noise, i + apart))
            .sum()
    };
    let mean = lags as f64 * covariance(0);
    let half_variance: f64 = (0..lags as i64)
        .flat_map(|k| (0..lags as i64).map(move |l| k - l))
        .map(|apart| covariance(apart).powi(2))
        .sum();
    let scale = half_variance / mean;
    Some(Whiteness {
        statistic: sum / covariance(0),
        p: chi_square_p(sum / scale, mean / scale),
        band: (covariance(0) / count as f64).sqrt(),
    })
}

/// Autocorrelation of the noise at a lag; zero beyond its correlated lags.
fn of_noise(noise: &[f64], lag: i64) -> f64 {
    let lag = lag.unsigned_abs() as usize;
    noise.get(lag).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::noise_floor::tests::normal;
    use super::*;

    /// Number of series, of 200, that the test rejects at 1 %.
    fn rejected(series: impl Fn(u64) -> Vec<f64>) -> usize {
        let rejects = |seed: &u64| whiteness(&series(*seed), 2).unwrap().p < 0.01;
        (0..200_u64).filter(rejects).count()
    }

    #[test]
    fn noise_is_white_as_often_as_it_says() {
        assert!(rejected(|seed| normal(800, seed)) <= 7);
    }

    #[test]
    fn correlation_over_two_lags_is_still_noise() {
        let steps = |seed| -> Vec<f64> {
            let noise = normal(801, seed);
            noise.windows(2).map(|w| w[1] - w[0]).collect()
        };
        let filtered = |seed| -> Vec<f64> {
            let noise = normal(802, seed);
            noise.windows(3).map(|w| w[0] + w[1] + w[2]).collect()
        };
        assert!(rejected(filtered) <= 7);
        assert!(rejected(steps) <= 7);
    }

    #[test]
    fn a_slow_error_of_half_the_noise_is_found() {
        let series: Vec<f64> = normal(2000, 3)
            .iter()
            .enumerate()
            .map(|(n, v)| v + 0.5 * (n as f64 * 0.02).sin())
            .collect();
        assert!(whiteness(&series, 2).unwrap().p < 1e-6);
        assert!(correlated_cycles(&series) > 3.0);
        assert!(correlated_cycles(&normal(2000, 3)) < 1.5);
    }

    #[test]
    fn sums_by_way_of_the_spectrum_are_those_of_the_products() {
        let mut series = normal(300, 5);
        series[20] = f64::NAN;
        for (lag, sum) in product_sums(&series).into_iter().enumerate() {
            assert!((sum - product_sum(&series, lag)).abs() < 1e-9, "{lag}");
        }
    }

    #[test]
    fn gaps_and_zeros_are_no_evidence() {
        let mut series = normal(800, 4);
        series[100..200].fill(f64::NAN);
        assert!(whiteness(&series, 2).unwrap().p > 1e-3);
        assert_eq!(whiteness(&[0.0; 800], 2), None);
        assert_eq!(whiteness(&[f64::NAN; 800], 2), None);
        assert_eq!(correlated_cycles(&[]), 1.0);
    }
}
