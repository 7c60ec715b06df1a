//! The noise on a series, found from the series itself.

use std::f64::consts::PI;

/// Makes the median absolute deviation of a normal variable its standard deviation.
const MAD_OF_NORMAL: f64 = 0.674_489_750_196_082;
/// Fewer third differences than this say nothing.
const LEAST: usize = 8;

/// Kind of noise that lies on a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// Each value has its own.
    White,
    /// The series is the difference of one with white noise, as a velocity made from positions.
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
    /// Power that it lets through at a frequency, as a share of the sampling rate.
    fn power(&self, frequency: f64) -> f64 {
        let ratio = (PI * frequency).tan() / (PI * self.cutoff).tan();
        (1.0 + ratio.powi(2 * self.order as i32)).powi(-2)
    }
}

impl Noise {
    /// Variance of the third difference of noise with variance 1. Without a filter it is the sum of squares
    /// of the binomials 1 3 3 1, and of 1 4 6 4 1 halved.
    fn of_third_difference(self, filter: Option<LowPassed>) -> f64 {
        /// Frequencies of the sum that stands for an integral.
        const BINS: usize = 1000;
        let (mut of_difference, mut of_noise) = (0.0, 0.0);
        for k in 0..BINS {
            let frequency = (k as f64 + 0.5) / (2 * BINS) as f64;
            let difference = 4.0 * (PI * frequency).sin().powi(2);
            let mut power = filter.map_or(1.0, |filter| filter.power(frequency));
            if self == Self::Differenced {
                power *= difference;
            }
            of_noise += power;
            of_difference += power * difference.powi(3);
        }
        of_difference / of_noise
    }
}

/// Standard deviation of the noise on a smooth series; None if it is too short to say. `filter`: what
/// the series went through, with its noise.
///
/// The median of absolute third differences does not see what is smooth, nor a few jumps: an
/// error of a model does not raise it.
pub fn noise_floor(values: &[f64], noise: Noise, filter: Option<LowPassed>) -> Option<f64> {
    let mut differences: Vec<f64> = values
        .windows(4)
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs())
        .filter(|d| d.is_finite())
        .collect();
    if differences.len() < LEAST {
        return None;
    }
    let scale = MAD_OF_NORMAL * noise.of_third_difference(filter).sqrt();
    median(&mut differences).map(|median| median / scale)
}

/// Median, the upper one of two; the order of the values is lost. None of nothing.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::statistics::RandomStream;

    /// Normally distributed numbers with standard deviation 1.
    pub(in crate::statistics) fn normal(count: usize, seed: u64) -> Vec<f64> {
        let mut random = RandomStream::new(seed, 0);
        (0..count).map(|_| random.normal()).collect()
    }

    /// What a low-pass leaves of noise is found as well as noise that no filter has seen.
    #[test]
    fn noise_behind_a_filter_is_of_its_own_size() {
        let noise = normal(4000, 3);
        let filter = LowPassed {
            order: 4,
            cutoff: 0.12,
        };
        let quiet = crate::import::filter::LowPass::new(4, filter.cutoff).zero_phase(&noise);
        let variance = quiet.iter().map(|v| v * v).sum::<f64>() / quiet.len() as f64;
        let floor = noise_floor(&quiet, Noise::White, Some(filter)).unwrap();
        assert!((floor / variance.sqrt() - 1.0).abs() < 0.05, "{floor}");
        let plain = noise_floor(&quiet, Noise::White, None).unwrap();
        assert!(plain < 0.3 * floor, "{plain}");
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
