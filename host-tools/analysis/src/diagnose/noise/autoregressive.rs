//! Autoregressive noise model, by which residuals and columns are whitened.
//!
//! A noise model that is fitted to the plain residual would include the missing effect, which is slow, and whitening would remove
//! it. So the spectrum is taken where effects are not: as a running median, which ignores single lines, and what lies below
//! [`SLOW_HZ`] is replaced by the level just above.

use super::structure::SLOW_HZ;
use softdock_statistics::{median, periodogram};

/// Order of the model.
pub(crate) const ORDER: usize = 4;
/// Smallest noise of a log that is accepted, over that of the model file: a signal that was rounded or filtered may show none at
/// all.
pub(crate) const LEAST: f64 = 0.3;
/// Width of the band whose level replaces that of the slow part, Hz.
const JUST_ABOVE_HZ: f64 = 6.0;
/// Bins of the running median on either side.
const REACH: usize = 12;
/// Ratio of median to mean of an exponential variable, the distribution of a periodogram's bins.
const MEDIAN_OF_EXPONENTIAL: f64 = std::f64::consts::LN_2;

/// Noise as an autoregression: `e(n) = r(n) − Σ a(k) r(n−k)` is white.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AutoregressiveNoise {
    /// Coefficients, of the newest value first.
    pub coefficients: [f64; ORDER],
    /// Standard deviation of e.
    pub sigma: f64,
    /// Standard deviation of the noise itself.
    pub level: f64,
}

impl AutoregressiveNoise {
    /// White noise.
    pub(crate) fn white(sigma: f64) -> Self {
        Self {
            coefficients: [0.0; ORDER],
            sigma,
            level: sigma,
        }
    }

    /// Estimates the noise from a residual. White with `at_least` if it holds less; white with its own level, but not less, if it
    /// is too short for a spectrum. Missing values are NaN. `cutoff_hz` is that of the low-pass which the log went through: the
    /// band above is not taken for a quiet one, in which small errors would have much weight.
    pub(crate) fn of(
        residual: &[f64],
        cycle_s: f64,
        at_least: f64,
        cutoff_hz: Option<f64>,
    ) -> Self {
        if residual.len() < 256 {
            let known = residual.iter().filter(|r| r.is_finite());
            let (count, squares) = known.fold((0, 0.0), |(n, sum), r| (n + 1, sum + r * r));
            let level = (squares / f64::from(count.max(1))).sqrt();
            return Self::white(level.max(at_least));
        }
        let mut spectrum = noise_spectrum(residual, cycle_s);
        if let Some(cutoff_hz) = cutoff_hz {
            continue_above(&mut spectrum, (2.0 * cutoff_hz * cycle_s).min(1.0));
        }
        let correlation = autocorrelation(&spectrum);
        let level = correlation[0].sqrt();
        if !level.is_finite() || level < at_least {
            return Self::white(at_least);
        }
        let (coefficients, share) = levinson(&correlation);
        Self {
            coefficients,
            sigma: level * share.sqrt(),
            level,
        }
    }

    /// Whitens a series and divides it by the standard deviation of the innovations.
    pub(crate) fn whiten(&self, series: &[f64]) -> Vec<f64> {
        let scale = 1.0 / self.sigma;
        let before_first = |n: usize| {
            let past = series[..n].iter().rev().zip(&self.coefficients);
            past.fold(series[n], |value, (before, a)| value - a * before)
        };
        let mut out = Vec::with_capacity(series.len());
        out.extend((0..series.len().min(ORDER)).map(|n| before_first(n) * scale));
        let [a, b, c, d] = self.coefficients;
        let whole = |[fourth, third, second, first, now]: &[f64; ORDER + 1]| {
            (now - a * first - b * second - c * third - d * fourth) * scale
        };
        out.extend(series.array_windows().map(whole));
        out
    }
}

/// Median of values; 0 if there are none.
fn middle(values: &[f64]) -> f64 {
    median(&mut values.to_vec()).unwrap_or(0.0)
}

fn noise_spectrum(residual: &[f64], cycle_s: f64) -> Vec<f64> {
    let power = periodogram(residual);
    let smooth: Vec<f64> = (0..power.len())
        .map(|k| {
            let from = k.saturating_sub(REACH);
            let to = (k + REACH + 1).min(power.len());
            middle(&power[from..to]) / MEDIAN_OF_EXPONENTIAL
        })
        .collect();
    let bin_hz = 1.0 / (cycle_s * residual.len() as f64);
    let bin = |hz: f64| ((hz / bin_hz) as usize).min(smooth.len().saturating_sub(1));
    // A slow log has its noise where a fast one has its effects.
    let slow = bin(SLOW_HZ).min(smooth.len() / 4);
    let above = (slow + bin(JUST_ABOVE_HZ).max(1)).min(smooth.len());
    let level = middle(&smooth[slow..above]);
    let mut out = smooth;
    out[..slow].fill(level);
    out
}

/// Replaces a spectrum above a share of its band by the level in the upper half of that share.
fn continue_above(spectrum: &mut [f64], share: f64) {
    let end = ((share * spectrum.len() as f64) as usize).min(spectrum.len());
    let level = middle(&spectrum[end / 2..end]);
    spectrum[end..].fill(level);
}

/// Autocorrelation up to the order, from a one-sided spectrum.
fn autocorrelation(spectrum: &[f64]) -> [f64; ORDER + 1] {
    let bins = spectrum.len() as f64;
    std::array::from_fn(|lag| {
        spectrum
            .iter()
            .enumerate()
            .map(|(k, power)| {
                power * (std::f64::consts::PI * (k + 1) as f64 / bins * lag as f64).cos()
            })
            .sum::<f64>()
            / bins
    })
}

/// Levinson's recursion: coefficients, and the share of the variance that is not predicted.
fn levinson(correlation: &[f64; ORDER + 1]) -> ([f64; ORDER], f64) {
    let mut coefficients = [0.0; ORDER];
    let mut error = correlation[0];
    for order in 0..ORDER {
        let mut reflection = correlation[order + 1];
        for k in 0..order {
            reflection -= coefficients[k] * correlation[order - k];
        }
        reflection /= error;
        let before = coefficients;
        for k in 0..order {
            coefficients[k] = before[k] - reflection * before[order - 1 - k];
        }
        coefficients[order] = reflection;
        error *= 1.0 - reflection * reflection;
    }
    (coefficients, (error / correlation[0]).clamp(1e-6, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fixed pseudo-random sequence, uniform in −0.5 to 0.5.
    fn white(count: usize) -> Vec<f64> {
        let mut state = 12345_u64;
        (0..count)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            })
            .collect()
    }

    #[test]
    fn white_noise_is_found_white_beside_a_slow_error() {
        let noise: Vec<f64> = white(2500)
            .iter()
            .enumerate()
            .map(|(n, w)| w + 3.0 * (n as f64 * 0.02).sin())
            .collect();
        let noise_model = AutoregressiveNoise::of(&noise, 0.004, 0.01, None);
        assert!(
            (noise_model.sigma * 12.0_f64.sqrt() - 1.0).abs() < 0.05,
            "{noise_model:?}"
        );
        assert!(
            noise_model.coefficients.iter().all(|a| a.abs() < 0.1),
            "{noise_model:?}"
        );
    }

    /// White noise behind a low-pass that leaves the lowest quarter of the band is white up to the cutoff.
    #[test]
    fn a_filtered_noise_is_white_up_to_the_cutoff() {
        let filter = softdock_statistics::LowPass::new(4, 0.125);
        let noise = filter.zero_phase(&white(5000));
        let noise_model = AutoregressiveNoise::of(&noise, 0.004, 0.01, Some(31.25));
        let plain = AutoregressiveNoise::of(&noise, 0.004, 0.01, None);
        assert!(
            noise_model.coefficients.iter().all(|a| a.abs() < 0.3),
            "{noise_model:?}"
        );
        assert!(plain.coefficients[0] > 1.5, "{plain:?}");
        assert!(
            (noise_model.sigma * 12.0_f64.sqrt() - 0.9).abs() < 0.15,
            "{noise_model:?}"
        );
    }

    #[test]
    fn an_autoregressive_noise_gives_its_coefficient() {
        let mut last = 0.0;
        let noise: Vec<f64> = white(2500)
            .iter()
            .map(|w| {
                last = 0.5 * last + w;
                last
            })
            .collect();
        let noise_model = AutoregressiveNoise::of(&noise, 0.004, 0.01, None);
        assert!(
            (noise_model.coefficients[0] - 0.5).abs() < 0.12,
            "{noise_model:?}"
        );
        assert!(
            (noise_model.sigma * 12.0_f64.sqrt() - 1.0).abs() < 0.06,
            "{noise_model:?}"
        );
    }
}
