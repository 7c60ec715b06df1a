//! The restitution at the end of a contact: what noise hides of it, and what the guard holds it to. Both move
//! the model without a measured force; the impulse is in the trace, and each action of the guard is flagged.
//!
//! **Noise.** Impulse matching makes up for the noise of every load but those of the last dead time, to which
//! no command can answer any more: their impulse would stay in the rebound, and in bounces that follow each
//! other become a random walk. The identification knows better, because a contact gives no energy and most give
//! back all they got:
//!
//! ```text
//! P(damped) = 1 / (1 + A exp(−z²/2))            z: damping over its standard deviation
//! v' = v + w (−e V − v)                         e: of the damping times P
//! w  = min(1, σ² n'/Σr²) · ς²/(ς² + δ²)         |e V + v| ≤ 4 ς V
//! ```
//!
//! with r the residuals, n' as many of them as noise may leave, σ the noise of a load, ς that of the rebound by
//! the loads and δ that by the identified direction. Without noise of the sensor the residuals are not noise,
//! and w is 0.
//!
//! **Guard.** A rebound that departs from that of an identified contact is set to it; that of one that was not
//! identified is bounded to what a passive contact can give, 0 ≤ e ≤ 1.

use super::V6;
use super::contact_estimator::{
    DAMPING, Estimate, Information, Prior, Unknowns, covariance_of_damping,
};
use super::reference::KelvinVoigt;
use super::tuning::*;
use crate::delay::status::LawFlags;
use nalgebra::ComplexField;

/// What all loads of a contact say about its restitution.
pub(super) struct RestitutionEstimate {
    /// e, with a damping that is there only if it is likely.
    restitution: f64,
    /// δ V: standard deviation of the velocity after it, by that of the contact's direction, m/s.
    sigma_m_s: f64,
    /// How much of the residuals is noise.
    noise_share: f64,
    /// The contact passes for an undamped one, and with the damping that noise hides it would give back less.
    pub(super) hides_damping: bool,
}

impl RestitutionEstimate {
    /// From velocities of the axes before and after the contact (m/s), the number of loads, and the noise of
    /// one along the contact (N).
    pub(super) fn new(
        information: &Information,
        estimate: &Estimate,
        prior: &Prior,
        (before, after): (&V6, &V6),
        (loads, noise): (f64, f64),
    ) -> Self {
        let gradient = &estimate.gradient;
        let sigma = prior.sigma;
        let (factor, target) = information.normal_equations(prior, gradient.dot(before));
        let units = covariance_of_damping(&factor)[DAMPING];
        let variance = prior.damping_variance(units, estimate.stiffness);
        let damping = factor.solve(&target)[DAMPING].max(0.0);
        let presence = presence(damping * damping / variance.max(f64::MIN_POSITIVE));
        let with = |damping| KelvinVoigt::new(estimate.stiffness, damping, estimate.mass);
        let contact = with(damping * presence);
        let in_noise = ComplexField::sqrt(prior.noise_variance(units, noise, estimate.stiffness));
        let unseen = with(DAMPING_SEEN * in_noise).restitution;
        // e a·V + a·v changes with a, but not with its length, which makes a·d 1.
        let sum = after + before * contact.restitution;
        let mut weights = Unknowns::zeros();
        let turned = sum - estimate.push * gradient.dot(&sum);
        weights.fixed_rows_mut::<6>(0).copy_from(&turned);
        let spread = weights.dot(&factor.solve(&weights)).max(0.0);
        let usual = (loads - FITTED_UNKNOWNS).max(0.0)
            + RESIDUAL_SIGNIFICANCE * ComplexField::sqrt(2.0 * loads);
        let squares = (estimate.error * estimate.error * loads).max(f64::MIN_POSITIVE);
        Self {
            restitution: contact.restitution,
            sigma_m_s: sigma * ComplexField::sqrt(spread) / estimate.stiffness,
            noise_share: (noise * noise * usual / squares).min(1.0),
            hides_damping: presence < 0.5 && unseen < 1.0 - GUARD_GAIN,
        }
    }

    /// What a velocity after the contact lacks of the rebound from `closing`, as far as it is noise, m/s;
    /// `noise` is that of the restitution by the loads.
    fn hidden(&self, closing: f64, after: f64, noise: f64) -> f64 {
        let missing = -self.restitution * closing - after;
        let deviation = noise * closing;
        if missing.abs() > NOISE_EXPLAINS * deviation {
            return 0.0;
        }
        let measured = deviation * deviation;
        let squared = self.sigma_m_s * self.sigma_m_s;
        let sure = measured / (measured + squared).max(f64::MIN_POSITIVE);
        missing * self.noise_share * sure
    }
}

/// Probability that there is a damping, which is found z standard deviations (z² given) from none.
fn presence(squared: f64) -> f64 {
    1.0 / (1.0 + UNDAMPED_ODDS * ComplexField::exp(-0.5 * squared))
}

/// A contact that has ended.
pub(super) struct Outcome {
    /// Velocity of the model along the contact, before and after, m/s.
    pub(super) closing: f64,
    pub(super) after: f64,
    /// Restitution of the identified contact.
    pub(super) restitution: f64,
    /// Misfit of the identification, as a part of the load, and what noise makes of it.
    pub(super) misfit: f64,
    pub(super) noise_misfit: f64,
    /// Standard deviation of the restitution by noise.
    pub(super) noise: f64,
}

impl Outcome {
    /// Whether the identified contact describes the loads.
    pub(super) fn fits(&self) -> bool {
        self.misfit < GUARD_MISFIT + GUARD_MISFIT_NOISE * self.noise_misfit
    }

    /// What the guard adds to the velocity after the contact, m/s, and the flag of that action.
    pub(super) fn guard(&self) -> Option<(f64, LawFlags)> {
        let e = -self.after / self.closing;
        let noise = GUARD_SIGNIFICANCE * self.noise;
        let (velocity, flag, acts) = if self.fits() {
            let known = self.restitution.min(1.0);
            let tolerance = GUARD_TOLERANCE + GUARD_TOLERANCE_OF_MISFIT * self.misfit;
            let off = (e - known).abs() > tolerance.min(GUARD_TOLERANCE_LIMIT) + noise;
            let gains = e > 1.0 + GUARD_GAIN + noise;
            (
                -known * self.closing,
                LawFlags::GUARD_IDENTIFIED,
                gains || off,
            )
        } else {
            let passive = -e.clamp(0.0, 1.0) * self.closing;
            let acts = e > 1.0 + noise || e < 0.0;
            (passive, LawFlags::GUARD_PASSIVE, acts)
        };
        acts.then_some((velocity - self.after, flag))
    }

    /// What noise hides of the velocity after the contact, m/s.
    pub(super) fn hidden(&self, estimate: &RestitutionEstimate) -> f64 {
        estimate.hidden(self.closing, self.after, self.noise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ELASTIC: RestitutionEstimate = RestitutionEstimate {
        restitution: 1.0,
        sigma_m_s: 0.0,
        noise_share: 1.0,
        hides_damping: false,
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
        let misfit = RestitutionEstimate {
            noise_share: 0.0,
            ..ELASTIC
        };
        assert_eq!(misfit.hidden(0.005, -0.00499, 0.005), 0.0);
    }

    /// Two findings of the same doubt each count half.
    #[test]
    fn an_uncertain_direction_counts_less() {
        let doubtful = RestitutionEstimate {
            sigma_m_s: 0.005 * 0.005,
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
