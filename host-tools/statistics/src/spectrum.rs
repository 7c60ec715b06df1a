//! Spectra.

use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};

/// A series times Hann's window, which confines an oscillation to few lines of its spectrum; white noise keeps its power.
pub(crate) fn hann(series: &[f64]) -> Vec<f64> {
    let count = series.len() as f64;
    // 3/8 is the mean of the window's square.
    let window = |n: usize| (PI * n as f64 / count).sin().powi(2) / 0.375_f64.sqrt();
    let values = series.iter().enumerate();
    values.map(|(n, v)| v * window(n)).collect()
}

/// Power at the frequencies k / (N Ts), k = 1 to N/2, in the square of the series' unit. Its mean is the variance about zero
/// of the known values. Missing values count as zero.
pub fn periodogram(series: &[f64]) -> Vec<f64> {
    let known = series.iter().filter(|v| v.is_finite()).count();
    let power = |line: &Complex<f64>| line.norm_sqr() / known as f64;
    lines(series).iter().map(power).collect()
}

/// Sums of the series times e^(−2π i k n / N) for k = 1 to N/2; none of a series without a known value. Missing values count as
/// zero.
pub(crate) fn lines(series: &[f64]) -> Vec<Complex<f64>> {
    let is_known = series.iter().any(|v| v.is_finite());
    if series.len() < 2 || !is_known {
        return Vec::new();
    }
    let mut buffer: Vec<Complex<f64>> = series
        .iter()
        .map(|v| Complex::new(if v.is_finite() { *v } else { 0.0 }, 0.0))
        .collect();
    FftPlannerScalar::new()
        .plan_fft_forward(series.len())
        .process(&mut buffer);
    buffer[1..=series.len() / 2].to_vec()
}

/// Spectrum of noise with variance 1 and this autocorrelation from lag 1 on, at `cycles` cycles
/// per sample: `1 + 2 Σ ρ(k) cos(2π k f)`.
pub fn shape_of(autocorrelation: &[f64], cycles: f64) -> f64 {
    let parts = autocorrelation.iter().enumerate();
    1.0 + 2.0
        * parts
            .map(|(k, r)| r * (TAU * (k + 1) as f64 * cycles).cos())
            .sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_stands_in_its_bin_with_its_power() {
        let count = 1000;
        let series: Vec<f64> = (0..count)
            .map(|n| 3.0 * (TAU * 20.0 * n as f64 / count as f64).sin())
            .collect();
        let power = periodogram(&series);
        assert_eq!(power.len(), 500);
        let mean = power.iter().sum::<f64>() / 500.0;
        assert!((mean - 4.5).abs() < 1e-9, "{mean}");
        assert!(power[19] > 0.999 * 500.0 * mean);
    }

    #[test]
    fn nothing_has_no_spectrum() {
        assert!(periodogram(&[]).is_empty());
        assert!(periodogram(&[f64::NAN; 9]).is_empty());
    }

    #[test]
    fn a_difference_of_white_noise_has_no_power_at_zero() {
        assert_eq!(shape_of(&[-0.5], 0.0), 0.0);
        assert!((shape_of(&[-0.5], 0.5) - 2.0).abs() < 1e-12);
    }
}
