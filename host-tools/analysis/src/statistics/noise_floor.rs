//! The noise on a series, found from the series itself.

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

impl Noise {
    /// Variance of the third difference of noise with variance 1: the sum of squares of the
    /// binomials 1 3 3 1, and of 1 4 6 4 1 halved.
    fn of_third_difference(self) -> f64 {
        match self {
            Self::White => 20.0,
            Self::Differenced => 35.0,
        }
    }
}

/// Standard deviation of the noise on a smooth series; None if it is too short to say.
///
/// The median of absolute third differences does not see what is smooth, nor a few jumps: an
/// error of a model does not raise it.
pub fn noise_floor(values: &[f64], noise: Noise) -> Option<f64> {
    let mut differences: Vec<f64> = values
        .windows(4)
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs())
        .filter(|d| d.is_finite())
        .collect();
    if differences.len() < LEAST {
        return None;
    }
    let scale = MAD_OF_NORMAL * noise.of_third_difference().sqrt();
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

    #[test]
    fn smooth_errors_and_jumps_do_not_raise_the_floor() {
        let noise = normal(4000, 1);
        let dirty: Vec<f64> = noise
            .iter()
            .enumerate()
            .map(|(n, v)| v + 300.0 * (n as f64 * 0.01).sin() + (n / 700) as f64 * 50.0)
            .collect();
        let floor = noise_floor(&dirty, Noise::White).unwrap();
        assert!((floor - 1.0).abs() < 0.06, "{floor}");
    }

    #[test]
    fn a_difference_has_its_own_factor() {
        let noise = normal(8000, 2);
        let steps: Vec<f64> = noise.windows(2).map(|w| w[1] - w[0]).collect();
        let floor = noise_floor(&steps, Noise::Differenced).unwrap();
        assert!((floor - 2.0_f64.sqrt()).abs() < 0.06, "{floor}");
    }

    #[test]
    fn little_or_nothing_has_no_floor() {
        assert_eq!(noise_floor(&[1.0; 10], Noise::White), None);
        assert_eq!(noise_floor(&[f64::NAN; 100], Noise::White), None);
        assert_eq!(noise_floor(&[1.0; 100], Noise::White), Some(0.0));
    }
}
