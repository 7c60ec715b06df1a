//! The rebound as far as noise of the sensor hides it: what the loads of the whole contact say about it,
//! and how sure that is.
//!
//! The balance makes up for the noise of every load but those of the last dead time, to which no command
//! can answer any more: their impulse would stay in the rebound, and in bounces that follow each other
//! become a random walk. The identification knows better, because a contact gives no energy and most give
//! back all they got:
//!
//! ```text
//! P(damped) = 1 / (1 + A exp(−z²/2))            z: damping over its standard deviation
//! v' = v + w (−e V − v)                         e: of the damping times P
//! w  = min(1, σ² n'/Σr²) · ς²/(ς² + δ²)         |e V + v| ≤ 4 ς V
//! ```
//!
//! with r the residuals, σ the noise of a load, ς the noise of the rebound by the loads and δ that by the
//! identified direction. Without noise of the sensor the residuals are not noise, and w is 0.

use super::V6;
use super::identify::{DAMPING, Estimate, Evidence, Expected, Row};
use super::reference::Spring;
use nalgebra::ComplexField;

/// A: how much more likely no damping is than one that happens to lie where it is found.
const ABSENT: f64 = 1000.0;
/// Unknowns that a fit takes from its loads.
const FITTED: f64 = 3.0;
/// Standard deviations of a mean square that are still noise.
const USUAL: f64 = 3.0;
/// Largest departure that noise explains, in its standard deviations.
const EXPLAINED: f64 = 4.0;

/// What all loads of a contact say about its rebound.
pub(super) struct Rebound {
    /// Restitution, with a damping that is there only if it is likely.
    pub(super) restitution: f64,
    /// Standard deviation of the velocity after it, by that of the contact's direction, m/s.
    pub(super) doubt: f64,
    /// How much of the residuals is noise.
    pub(super) noise_share: f64,
}

/// A contact that is over, and what was measured of it.
pub(super) struct Measured<'a> {
    pub(super) evidence: &'a Evidence,
    pub(super) estimate: &'a Estimate,
    pub(super) expected: &'a Expected,
    /// Velocities of the axes before and after, m/s.
    pub(super) before: &'a V6,
    pub(super) after: &'a V6,
    /// Number of loads, and the standard deviation of one along the contact, N.
    pub(super) loads: f64,
    pub(super) noise: f64,
}

impl Rebound {
    pub(super) fn new(of: &Measured<'_>) -> Self {
        let Estimate {
            stiffness,
            mass,
            ref gradient,
            ref push,
            error,
            ..
        } = *of.estimate;
        let sigma = of.expected.sigma;
        let (factor, target) = of.evidence.normal(of.expected, gradient.dot(of.before));
        let mut unit = Row::zeros();
        unit[DAMPING] = 1.0;
        let variance = factor.solve(&unit)[DAMPING] * sigma * sigma;
        let damping = factor.solve(&target)[DAMPING].max(0.0);
        let likely = damping * presence(damping * damping / variance.max(f64::MIN_POSITIVE));
        let restitution = Spring::new(stiffness, likely, mass).restitution;
        // e a·V + a·v changes with a, but not with its length, which makes a·push 1.
        let sum = of.after + of.before * restitution;
        let mut weights = Row::zeros();
        let turned = sum - push * gradient.dot(&sum);
        weights.fixed_rows_mut::<6>(0).copy_from(&turned);
        let spread = weights.dot(&factor.solve(&weights)).max(0.0);
        let usual = (of.loads - FITTED).max(0.0) + USUAL * ComplexField::sqrt(2.0 * of.loads);
        let squares = (error * error * of.loads).max(f64::MIN_POSITIVE);
        Self {
            restitution,
            doubt: sigma * ComplexField::sqrt(spread) / stiffness,
            noise_share: (of.noise * of.noise * usual / squares).min(1.0),
        }
    }

    /// What a velocity after the contact lacks of the rebound from `closing`, as far as it is noise, m/s;
    /// `noise` is that of the restitution by the loads.
    pub(super) fn hidden(&self, closing: f64, after: f64, noise: f64) -> f64 {
        let missing = -self.restitution * closing - after;
        let deviation = noise * closing;
        if missing.abs() > EXPLAINED * deviation {
            return 0.0;
        }
        let measured = deviation * deviation;
        let sure = measured / (measured + self.doubt * self.doubt).max(f64::MIN_POSITIVE);
        missing * self.noise_share * sure
    }
}

/// Probability that there is a damping, which is found z standard deviations (z² given) from none.
fn presence(squared: f64) -> f64 {
    1.0 / (1.0 + ABSENT * ComplexField::exp(-0.5 * squared))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ELASTIC: Rebound = Rebound {
        restitution: 1.0,
        doubt: 0.0,
        noise_share: 1.0,
    };

    #[test]
    fn what_noise_hides_is_made_up_for() {
        assert!((ELASTIC.hidden(0.005, -0.00499, 0.005) + 1e-5).abs() < 1e-15);
        assert!((ELASTIC.hidden(0.005, -0.00501, 0.005) - 1e-5).abs() < 1e-15);
    }

    #[test]
    fn what_noise_does_not_explain_stays() {
        // Five standard deviations; no noise; residuals that are none.
        assert_eq!(ELASTIC.hidden(0.005, -0.004875, 0.005), 0.0);
        assert_eq!(ELASTIC.hidden(0.005, -0.00499, 0.0), 0.0);
        let misfit = Rebound {
            noise_share: 0.0,
            ..ELASTIC
        };
        assert_eq!(misfit.hidden(0.005, -0.00499, 0.005), 0.0);
    }

    /// Two findings of the same doubt each count half.
    #[test]
    fn an_uncertain_direction_counts_less() {
        let doubtful = Rebound {
            doubt: 0.005 * 0.005,
            ..ELASTIC
        };
        assert!((doubtful.hidden(0.005, -0.00499, 0.005) + 5e-6).abs() < 1e-12);
    }

    #[test]
    fn a_damping_is_there_when_it_stands_out() {
        assert!(presence(0.0) < 0.001 && presence(4.0) < 0.01);
        assert!(presence(25.0) > 0.99 && presence(100.0) > 0.999_999);
    }
}
