//! Residuals of rounded readings.
//!
//! A rounded reading says that the value lies within half a step of it, no more. Its residual is
//! therefore a quantile of the noise's distribution between the two ends, drawn at random
//! (Dunn and Smyth, Randomized quantile residuals, J. Comput. Graph. Stat. 5, 1996): white and of
//! unit size if nothing but noise is left, however coarse the step. The draw is a fixed sequence,
//! so that a diagnosis repeats.

use softdock_physics::optimise::brent;
use statrs::distribution::{ContinuousCDF, Normal};

/// Largest residual, in σ: far tails have no digits left.
const FARTHEST: f64 = 8.0;
/// Range in which the noise is searched, over that of the data sheet.
const NOISE: (f64, f64) = (0.5, 1.35);
/// Relative precision with which it is found.
const TOLERANCE: f64 = 0.01;

/// Rounded readings against a prediction.
pub(crate) struct Rounded {
    /// Residuals in units of the noise.
    pub white: Vec<f64>,
    /// Noise before rounding.
    pub sigma: f64,
    /// −log L.
    pub cost: f64,
}

impl Rounded {
    /// `raw` are residuals to the middles of the intervals for which readings stand, `half` is half the width of these.
    /// `sheet_sigma` is the noise by data sheet, which is adjusted within [`NOISE`].
    pub(crate) fn new(raw: &[f64], half: f64, sheet_sigma: f64) -> Self {
        let cost = |scale: f64| -> f64 {
            let sigma = scale * sheet_sigma;
            let likelihood = |r: &f64| between((r - half) / sigma, (r + half) / sigma);
            raw.iter().map(|r| -likelihood(r).max(1e-14).ln()).sum()
        };
        let (scale, cost) = brent((NOISE.0, 1.0, NOISE.1), TOLERANCE, cost);
        let sigma = scale * sheet_sigma;
        let mut draw = 0.5;
        let white = raw.iter().map(|r| {
            // The golden ratio spreads the draws evenly.
            draw = (draw + 0.618_033_988_749_895_f64).fract();
            quantile((r - half) / sigma, (r + half) / sigma, scrambled(draw))
        });
        Self {
            white: white.collect(),
            sigma,
            cost,
        }
    }
}

/// A hash of each draw, which removes the order of the sequence.
fn scrambled(draw: f64) -> f64 {
    let mut bits = draw.to_bits();
    bits = (bits ^ (bits >> 31)).wrapping_mul(0x7fb5_d329_728e_a185);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x81da_def4_bc2d_d44d);
    bits ^= bits >> 33;
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// Probability that a standard normal value lies between two ends.
fn between(low: f64, high: f64) -> f64 {
    let normal = Normal::standard();
    if low > 0.0 {
        normal.sf(low) - normal.sf(high)
    } else {
        normal.cdf(high) - normal.cdf(low)
    }
}

/// The standard normal value up to which lies this share of the probability between two ends.
fn quantile(low: f64, high: f64, share: f64) -> f64 {
    if low > 0.0 {
        return -quantile(-high, -low, 1.0 - share);
    }
    let normal = Normal::standard();
    let (from, to) = (normal.cdf(low), normal.cdf(high));
    let at = from + share * (to - from);
    if at > 1e-15 {
        normal.inverse_cdf(at).clamp(-FARTHEST, FARTHEST)
    } else {
        high.clamp(-FARTHEST, FARTHEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_statistics::rms;

    fn noise(count: usize) -> Vec<f64> {
        let normal = Normal::standard();
        (0..count)
            .map(|n| normal.inverse_cdf(scrambled(0.1 + n as f64 / (2.0 * count as f64))))
            .collect()
    }

    #[test]
    fn rounding_of_any_coarseness_leaves_noise_of_unit_size() {
        for step in [0.5, 3.0, 25.0] {
            let raw: Vec<f64> = noise(2500)
                .iter()
                .enumerate()
                .map(|(n, e)| {
                    let load = 40.0 * (n as f64 * 0.004).sin();
                    ((load + e) / step).round() * step - load
                })
                .collect();
            let found = Rounded::new(&raw, 0.5 * step, 1.0);
            let size = rms(&found.white);
            assert!((size - 1.0).abs() < 0.08, "{step}: {size} {}", found.sigma);
        }
    }

    #[test]
    fn an_error_beyond_the_step_stays_one() {
        let raw: Vec<f64> = noise(2500).iter().map(|e| e.round() + 6.0).collect();
        let found = Rounded::new(&raw, 0.5, 1.0);
        assert!(rms(&found.white) * found.sigma > 5.0);
    }
}
