//! Whether a richer structure is worth its parameters.

use super::misfit::Fit;
use softdock_statistics::{Noise, correlated_cycles, noise_floor};

/// Least gain of 2 log L by a parameter.
const PRICE: f64 = 12.0;
/// No simulation of a robot is better than this, m or rad: a tenth of a millisecond at 20 mm/s.
const LEAST_ERROR: f64 = 2e-6;
/// Ratio of rms residual to noise from which on limits are tried.
const UNEXPLAINED: f64 = 1.2;

/// Judges fits of one recording by their likelihood.
pub(super) struct Judge {
    /// Number of independent values.
    independent: f64,
    /// Neighbouring values that count as one.
    correlated: f64,
    /// Sum of squares that even a right simulation may leave; it is added to that of each fit.
    least: f64,
}

impl Judge {
    pub(super) fn new(fits: &[Fit]) -> Self {
        let best = fits
            .iter()
            .min_by(|a, b| a.squares().total_cmp(&b.squares()));
        let (count, correlated) = best.map_or((1, 1.0), |fit| {
            (fit.residual.len(), correlated_cycles(fit.of_positions()))
        });
        Self {
            independent: count as f64 / correlated,
            correlated,
            least: count as f64 * LEAST_ERROR * LEAST_ERROR,
        }
    }

    /// 2 log L, up to a constant.
    fn likelihood(&self, fit: &Fit) -> f64 {
        -self.independent * (fit.squares() + self.least).ln()
    }

    /// Likelihood less the price of the parameters.
    fn worth(&self, fit: &Fit) -> f64 {
        self.likelihood(fit) - PRICE * fit.values.len() as f64
    }

    pub(super) fn choose(&self, fits: &[Fit]) -> Fit {
        let best = fits
            .iter()
            .max_by(|a, b| self.worth(a).total_cmp(&self.worth(b)));
        // There are always three fits at least.
        best.unwrap_or(&fits[0]).clone()
    }

    /// Whether a fit explains the recording about as well as the chosen one.
    pub(super) fn as_good(&self, fit: &Fit, chosen: &Fit) -> bool {
        self.likelihood(fit) > self.likelihood(chosen) - PRICE
    }

    /// Variance of a position, enlarged by the correlation of neighbouring positions.
    pub(super) fn variance(&self, fit: &Fit) -> f64 {
        let freedom = (fit.residual.len() as f64 - fit.values.len() as f64).max(1.0);
        self.correlated * (fit.squares() + self.least) / freedom
    }

    /// Whether a fit with as many parameters is clearly better than another.
    pub(super) fn is_better(&self, fit: &Fit, other: &Fit) -> bool {
        self.likelihood(fit) > self.likelihood(other) + PRICE
    }
}

/// Whether the residual is larger than its noise.
pub(super) fn leaves_more_than_noise(fit: &Fit) -> bool {
    fit.rms() > UNEXPLAINED * noise_of(fit)
}

/// Noise of the positions, estimated from their residual.
pub(super) fn noise_of(fit: &Fit) -> f64 {
    let noise = noise_floor(&fit.left, Noise::White, None).unwrap_or(0.0);
    noise.hypot(LEAST_ERROR)
}
