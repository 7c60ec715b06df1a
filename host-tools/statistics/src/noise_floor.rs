//! Noise floor of a series, estimated from the series itself.

use super::spectrum::{hann, periodogram};
use std::f64::consts::PI;

/// Median absolute deviation of a normal variable with standard deviation 1.
const MAD_OF_NORMAL: f64 = 0.674_489_750_196_082;
/// Fewest differences for an estimate.
const LEAST: usize = 8;
/// Orders of the differences: a motion that is fast relative to the sampling rate still shows in those of low order.
const ORDERS: [i32; 4] = [3, 5, 7, 9];

/// Number of frequencies in a sum that approximates an integral.
const BINS: usize = 1000;

/// Kind of noise on a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// White noise.
    White,
    /// Differences of white noise, as in a velocity computed from positions.
    Differenced,
}

/// A zero-phase low-pass through which a series went: a Butterworth filter forwards and backwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPassed {
    /// Order of one pass.
    pub order: u32,
    /// Cutoff of one pass, as a share of the sampling rate.
    pub cutoff: f64,
}

impl LowPassed {
    /// Power gain, as a function of the frequency relative to the sampling rate.
    fn power(self) -> impl Fn(f64) -> f64 {
        let (cutoff, order) = ((PI * self.cutoff).tan(), self.order as i32);
        move |frequency| (1.0 + ((PI * frequency).tan() / cutoff).powi(2 * order)).powi(-2)
    }

    /// Autocorrelation of filtered white noise at lags 0, 1, .. `lags` - 1.
    pub fn correlations(&self, lags: usize) -> Vec<f64> {
        let power = self.power();
        let mut together = vec![0.0; lags];
        for frequency in frequencies() {
            let passed = power(frequency);
            for (lag, sum) in together.iter_mut().enumerate() {
                *sum += passed * (2.0 * PI * frequency * lag as f64).cos();
            }
        }
        let power = together.first().copied().unwrap_or(1.0);
        together.iter().map(|sum| sum / power).collect()
    }
}

/// Frequencies of a sum that covers the band of a series, relative to the sampling rate.
fn frequencies() -> impl Iterator<Item = f64> {
    (0..BINS).map(|k| (k as f64 + 0.5) / (2 * BINS) as f64)
}

impl Noise {
    /// Power density at a frequency relative to the sampling rate; 1 for white noise of variance 1.
    fn density(self) -> impl Fn(f64) -> f64 {
        move |frequency| match self {
            Self::White => 1.0,
            Self::Differenced => 4.0 * (PI * frequency).sin().powi(2),
        }
    }

    /// Variance of the `order`-th difference of noise with variance 1. For white noise without a filter, that of the third
    /// difference is the sum of squares of the binomials 1 3 3 1; for differenced noise it is that of 1 4 6 4 1, halved.
    fn of_difference(self, order: i32, filter: Option<LowPassed>) -> f64 {
        let (mut of_difference, mut of_noise) = (0.0, 0.0);
        let (passed, density) = (filter.map(LowPassed::power), self.density());
        for frequency in frequencies() {
            let difference = 4.0 * (PI * frequency).sin().powi(2);
            let power =
                density(frequency) * passed.as_ref().map_or(1.0, |passed| passed(frequency));
            of_noise += power;
            of_difference += power * difference.powi(order);
        }
        of_difference / of_noise
    }
}

/// Standard deviation of the noise on a smooth series; None if the series is too short. `filter` is the low-pass through
/// which series and noise went, if any.
///
/// The median of absolute differences is insensitive to everything smooth and to a few jumps, so that an error of a model
/// does not raise it. The smallest estimate of all orders is taken: of an oscillation at a ninth of the sampling rate the
/// third difference keeps a third, the ninth difference a thousandth of what it makes of noise. After a filter there is no
/// noise at the frequencies that high orders measure, and the quietest part of the band is used in their place.
pub fn noise_floor(values: &[f64], noise: Noise, filter: Option<LowPassed>) -> Option<f64> {
    let orders = if filter.is_some() {
        &ORDERS[..1]
    } else {
        &ORDERS
    };
    let mut differences = values.to_vec();
    let mut order = 0;
    let floors = orders.iter().map_while(|wanted| {
        while order < *wanted {
            differences = differences.windows(2).map(|w| w[1] - w[0]).collect();
            order += 1;
        }
        let sizes = differences.iter().map(|d| d.abs());
        let mut sizes: Vec<f64> = sizes.filter(|d| d.is_finite()).collect();
        let scale = MAD_OF_NORMAL * noise.of_difference(order, filter).sqrt();
        let median = median(&mut sizes).filter(|_| sizes.len() >= LEAST)?;
        Some(median / scale)
    });
    let quiet = filter.and_then(|filter| quietest_of_band(values, noise, &filter));
    floors.chain(quiet).reduce(f64::min)
}

/// Noise after a filter, from the quietest tenth of the spectral lines that the filter passes. None if there are too few
/// lines.
fn quietest_of_band(values: &[f64], noise: Noise, filter: &LowPassed) -> Option<f64> {
    /// Smallest power gain of a line that counts as passed.
    const KEPT: f64 = 0.5;
    let passed = filter.power();
    let density = noise.density();
    let behind = |frequency: f64| passed(frequency) * density(frequency);
    let quiet = quietest(values, behind, |frequency| passed(frequency) > KEPT)?;
    Some((quiet * mean(behind)).sqrt())
}

/// Standard deviation of the noise that remains on `values`, which are not filtered yet, after a filter. White noise is
/// assumed. None if the band above that of the filter is too narrow for an estimate.
///
/// The band of the filter may contain nothing but motion. So the noise level is that of the quietest tenth of the lines above
/// it, up to four times the cutoff.
pub fn noise_let_through(values: &[f64], filter: LowPassed) -> Option<f64> {
    // A cutoff is usually set to about where the motion ends.
    let above = (1.5 * filter.cutoff)..(4.0 * filter.cutoff).min(0.5);
    let quiet = quietest(values, |_| 1.0, |frequency| above.contains(&frequency))?;
    Some((quiet * mean(filter.power())).sqrt())
}

/// Power density of the quietest tenth of the lines for which `chosen` holds, in units of `density`. Frequencies are 0 to
/// 0.5. None if there are too few lines.
fn quietest(
    values: &[f64],
    density: impl Fn(f64) -> f64,
    chosen: impl Fn(f64) -> bool,
) -> Option<f64> {
    /// Lines below this number contain leakage of the window.
    const FIRST: usize = 4;
    let count = values.len() as f64;
    let windowed = hann(values);
    let frequency = |line: usize| (line + 1) as f64 / count;
    let mut lines: Vec<f64> = periodogram(&windowed)
        .iter()
        .enumerate()
        .skip(FIRST)
        .filter(|(line, _)| chosen(frequency(*line)))
        .map(|(line, power)| power / density(frequency(line)))
        .collect();
    let tenth = lines.len() / 10;
    if tenth < LEAST {
        return None;
    }
    // The power of a line of noise is exponentially distributed.
    Some(*lines.select_nth_unstable_by(tenth, f64::total_cmp).1 / -0.9_f64.ln())
}

/// Mean of a density over the band of a series.
fn mean(density: impl Fn(f64) -> f64) -> f64 {
    frequencies().map(density).sum::<f64>() / BINS as f64
}

/// Median, of two middle values the upper one; None for an empty slice. The values are reordered.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::RandomStream;

    /// Normally distributed numbers with standard deviation 1.
    pub(crate) fn normal(count: usize, seed: u64) -> Vec<f64> {
        let mut random = RandomStream::new(seed, 0);
        (0..count).map(|_| random.normal()).collect()
    }

    /// The floor after a filter is that of the filtered noise.
    #[test]
    fn noise_behind_a_filter_is_of_its_own_size() {
        let noise = normal(4000, 3);
        let filter = LowPassed {
            order: 4,
            cutoff: 0.12,
        };
        let quiet = crate::LowPass::new(4, filter.cutoff).zero_phase(&noise);
        let variance = quiet.iter().map(|v| v * v).sum::<f64>() / quiet.len() as f64;
        let floor = noise_floor(&quiet, Noise::White, Some(filter)).unwrap();
        assert!((floor / variance.sqrt() - 1.0).abs() < 0.05, "{floor}");
        let plain = noise_floor(&quiet, Noise::White, None).unwrap();
        assert!(plain < 0.3 * floor, "{plain}");
        let expected = filter.correlations(9);
        for lag in [1, 3, 8] {
            let together = quiet.iter().zip(&quiet[lag..]).map(|(a, b)| a * b);
            let correlation = together.sum::<f64>() / 4000.0 / variance;
            assert!(
                (expected[lag] - correlation).abs() < 0.07,
                "{lag}: {correlation}"
            );
        }
    }

    #[test]
    fn smooth_errors_and_jumps_do_not_raise_the_floor() {
        let noise = normal(4000, 1);
        let dirty: Vec<f64> = noise
            .iter()
            .enumerate()
            .map(|(n, v)| v + 300.0 * (n as f64 * 0.01).sin() + (n / 700) as f64 * 50.0)
            .collect();
        let floor = noise_floor(&dirty, Noise::White, None).unwrap();
        assert!((floor - 1.0).abs() < 0.06, "{floor}");
    }

    /// The oscillation is 500 times as large as the noise, at 67 Hz of 610 Hz.
    #[test]
    fn a_fast_swing_does_not_raise_the_floor() {
        let noise = normal(4000, 4);
        let swinging: Vec<f64> = noise
            .iter()
            .enumerate()
            .map(|(n, v)| v + 500.0 * (n as f64 * 0.69).sin())
            .collect();
        let floor = noise_floor(&swinging, Noise::White, None).unwrap();
        assert!((1.0..1.5).contains(&floor), "{floor}");
    }

    /// The oscillation fills the band of the filter except for gaps between its lines.
    #[test]
    fn behind_a_filter_the_quiet_lines_tell() {
        let noise = normal(4096, 5);
        let line = |k: f64, n: usize| (std::f64::consts::TAU * k * n as f64 / 4096.0 + k * k).sin();
        let lines = |n: usize| (20..80).map(|k| line(5.0 * f64::from(k), n)).sum::<f64>();
        let swinging: Vec<f64> = (0..noise.len())
            .map(|n| noise[n] + 5.0 * lines(n))
            .collect();
        let filter = LowPassed {
            order: 6,
            cutoff: 0.1,
        };
        let filtered = |values: &[f64]| {
            let low_pass = crate::LowPass::new(filter.order, filter.cutoff);
            low_pass.zero_phase(values)
        };
        let quiet = filtered(&noise);
        let rms = (quiet.iter().map(|v| v * v).sum::<f64>() / 4096.0).sqrt();
        let floor = noise_floor(&filtered(&swinging), Noise::White, Some(filter)).unwrap();
        // Two thirds of the band are filled: its quietest tenth is the quietest third of the lines of noise.
        assert!((0.8..2.0).contains(&(floor / rms)), "{floor} {rms}");
    }

    /// Motion fills the whole band of the filter. After the filter it looks like noise of ten times the size.
    #[test]
    fn above_the_band_the_noise_is_seen_before_it_is_filtered() {
        let low_pass = crate::LowPass::new(4, 0.06);
        let filter = LowPassed {
            order: 4,
            cutoff: 0.06,
        };
        let noise = normal(8000, 6);
        let motion = low_pass.zero_phase(&normal(8000, 7));
        let raw: Vec<f64> = noise
            .iter()
            .zip(&motion)
            .map(|(n, m)| n + 10.0 * m)
            .collect();
        let quiet = low_pass.zero_phase(&noise);
        let rms = (quiet.iter().map(|v| v * v).sum::<f64>() / 8000.0).sqrt();
        let behind = noise_floor(&low_pass.zero_phase(&raw), Noise::White, Some(filter)).unwrap();
        assert!(behind > 5.0 * rms, "{behind} {rms}");
        let before = noise_let_through(&raw, filter).unwrap();
        assert!((0.8..1.25).contains(&(before / rms)), "{before} {rms}");
        let wide = LowPassed {
            order: 4,
            cutoff: 0.34,
        };
        assert_eq!(noise_let_through(&raw, wide), None);
    }

    #[test]
    fn a_difference_has_its_own_factor() {
        let noise = normal(8000, 2);
        let steps: Vec<f64> = noise.windows(2).map(|w| w[1] - w[0]).collect();
        let floor = noise_floor(&steps, Noise::Differenced, None).unwrap();
        assert!((floor - 2.0_f64.sqrt()).abs() < 0.06, "{floor}");
    }

    #[test]
    fn little_or_nothing_has_no_floor() {
        assert_eq!(noise_floor(&[1.0; 10], Noise::White, None), None);
        assert_eq!(noise_floor(&[f64::NAN; 100], Noise::White, None), None);
        assert_eq!(noise_floor(&[1.0; 100], Noise::White, None), Some(0.0));
    }
}
