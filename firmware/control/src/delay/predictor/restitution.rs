//! The restitution at the end of a contact, and the part of it that noise hides. The correction moves the model without a
//! measured force; its impulse is in the trace.
//!
//! Impulse matching corrects the noise of every load but those of the last dead time, to which no command can respond any more:
//! their impulse would stay in the rebound, and would add up to a random walk over successive bounces. The identification knows
//! better, because a contact gives no energy and most give back all they got:
//!
//! ```text
//! P(damped) = 1 / (1 + A exp(−z²/2))            z: damping over its standard deviation
//! v' = v + w (−e V − v)                         e: of the damping times P
//! w  = min(1, σ² n'/Σr²) · ς²/(ς² + δ²)         |e V + v| ≤ 4 ς V
//! ```
//!
//! with r the residuals, n' the sum of their squares that noise may leave (in units of σ²), σ the noise of a load, ς the standard
//! deviation of the restitution from the noise of the loads and δ that from the identified direction. Without noise of the sensor
//! the residuals are not noise, and w is 0.

use super::V6;
use super::contact_estimator::{
    DAMPING, Estimate, Information, Prior, Unknowns, covariance_of_damping,
};
use super::guard::Outcome;
use super::kelvin_voigt::KelvinVoigt;
use super::tuning::*;
use nalgebra::ComplexField;

/// The restitution that follows from all loads of a contact.
pub(super) struct RestitutionEstimate {
    /// e, with the damping weighted by its probability.
    restitution: f64,
    /// δ V: standard deviation of the rebound velocity that follows from that of the contact's direction, m/s.
    sigma_m_s: f64,
    /// Fraction of the squared residuals that noise explains.
    noise_share: f64,
    /// The contact counts as undamped, but with the largest damping that noise may hide it would give back less.
    pub(super) hides_damping: bool,
}

impl RestitutionEstimate {
    /// From velocities of the axes before and after the contact (m/s), the number of loads, and the noise of a load along the
    /// contact (N).
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
        // e a·V + a·v depends on the direction of a, but not on its length, which a·d = 1 fixes.
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

    /// The correction of the velocity after a contact towards the identified rebound, as far as noise explains the difference,
    /// m/s.
    pub(super) fn hidden(&self, contact: &Outcome) -> f64 {
        let missing = -self.restitution * contact.closing - contact.after;
        let deviation = contact.noise * contact.closing;
        if missing.abs() > NOISE_EXPLAINS * deviation {
            return 0.0;
        }
        let measured = deviation * deviation;
        let squared = self.sigma_m_s * self.sigma_m_s;
        let sure = measured / (measured + squared).max(f64::MIN_POSITIVE);
        missing * self.noise_share * sure
    }
}

/// Probability that there is a damping if its estimate is z standard deviations from zero; `squared` is z².
fn presence(squared: f64) -> f64 {
    1.0 / (1.0 + UNDAMPED_ODDS * ComplexField::exp(-0.5 * squared))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::contact_estimator::UNKNOWNS;
    use crate::delay::predictor::least_squares::Ldlt;
    use crate::delay::predictor::oblique::{direction, sample, way};

    const ELASTIC: RestitutionEstimate = RestitutionEstimate {
        restitution: 1.0,
        sigma_m_s: 0.0,
        noise_share: 1.0,
        hides_damping: false,
    };

    #[test]
    fn what_noise_hides_is_made_up_for() {
        assert!((hidden(&ELASTIC, -0.00499, 0.005) + 1e-5).abs() < 1e-15);
        assert!((hidden(&ELASTIC, -0.00501, 0.005) - 1e-5).abs() < 1e-15);
    }

    #[test]
    fn what_noise_does_not_explain_stays() {
        // Five standard deviations off; no noise; residuals that are not noise.
        assert_eq!(hidden(&ELASTIC, -0.004875, 0.005), 0.0);
        assert_eq!(hidden(&ELASTIC, -0.00499, 0.0), 0.0);
        let misfit = RestitutionEstimate {
            noise_share: 0.0,
            ..ELASTIC
        };
        assert_eq!(hidden(&misfit, -0.00499, 0.005), 0.0);
    }

    /// Two estimates of the same variance count half each.
    #[test]
    fn an_uncertain_direction_counts_less() {
        let doubtful = RestitutionEstimate {
            sigma_m_s: 0.005 * 0.005,
            ..ELASTIC
        };
        assert!((hidden(&doubtful, -0.00499, 0.005) + 5e-6).abs() < 1e-12);
    }

    #[test]
    fn a_damping_is_there_when_it_stands_out() {
        assert!(presence(0.0) < 0.001 && presence(4.0) < 0.01);
        assert!(presence(25.0) > 0.99 && presence(100.0) > 0.999_999);
    }

    /// The correction for this velocity after a contact at 5 mm/s, m/s, and this noise of the restitution.
    fn hidden(estimate: &RestitutionEstimate, after: f64, noise: f64) -> f64 {
        estimate.hidden(&Outcome {
            closing: 0.005,
            after,
            restitution: 1.0,
            misfit: 0.0,
            noise_misfit: noise,
            noise,
        })
    }

    /// A contact at 5 mm/s along an oblique direction, with its velocities before and after it.
    struct Case {
        information: Information,
        prior: Prior,
        estimate: Estimate,
        before: V6,
        after: V6,
    }

    impl Case {
        /// With an error of this size (N) in its loads, and an expected noise of a load (N).
        fn new(damping: f64, error: f64, noise: f64) -> Self {
            let prior = Prior::new((2e5, noise, 0.0), 0.0, direction());
            let mut information = Information::new(V6::zeros());
            information.begin(&V6::zeros(), 0.005, 10.0, prior.sigma);
            for n in 1..37 {
                let (position, change, load) = sample(n, 0.005, damping, error);
                information.add(&position, change, load);
            }
            let (estimate, before) = (information.solve(&prior, 0.005), way() * 0.005);
            let after = before * -0.9 + V6::new(0.0, 1.0, -1.0, 0.5, 0.0, 0.3) * 2e-4;
            Self {
                information,
                prior,
                estimate,
                before,
                after,
            }
        }

        /// The estimate of the restitution for this noise (N) and number of loads.
        fn restitution(&self, loads: f64, noise: f64) -> RestitutionEstimate {
            let velocities = (&self.before, &self.after);
            let (known, estimate) = (&self.information, &self.estimate);
            RestitutionEstimate::new(known, estimate, &self.prior, velocities, (loads, noise))
        }

        fn factor(&self) -> (Ldlt<UNKNOWNS>, Unknowns) {
            let closing = self.estimate.gradient.dot(&self.before);
            self.information.normal_equations(&self.prior, closing)
        }

        /// Standard deviation of a damping per that of a load, and the damping that fits best.
        fn damping(&self) -> (f64, f64) {
            let (factor, target) = self.factor();
            let variance = covariance_of_damping(&factor)[DAMPING];
            (variance.sqrt(), factor.solve(&target)[DAMPING])
        }

        /// Restitution with a damping.
        fn with(&self, damping: f64) -> f64 {
            KelvinVoigt::new(self.estimate.stiffness, damping, self.estimate.mass).restitution
        }
    }

    /// The fixed point of a noise of the loads and the value that `of` gives for a contact with this damping and noise.
    fn noise(damping: f64, first: f64, of: impl Fn(&Case) -> f64) -> f64 {
        (0..20).fold(first, |noise, _| of(&Case::new(damping, 0.0, noise)))
    }

    #[track_caller]
    fn assert_within(found: f64, expected: f64, most: f64) {
        assert!((found - expected).abs() < most, "{found} {expected}");
    }

    /// The standard deviation of e a·V + a·v when the direction a varies within its covariance, with a·d = 1: by its derivative
    /// with respect to each of the six components.
    #[test]
    fn the_doubt_of_the_rebound_is_that_of_the_contacts_direction() {
        let case = Case::new(2000.0, 0.5, 0.5);
        let found = case.restitution(36.0, 0.5);
        let missing = |kappa: V6| {
            let gradient = kappa / kappa.dot(&case.estimate.push);
            gradient.dot(&(case.after + case.before * found.restitution))
        };
        let kappa = case.estimate.gradient * case.estimate.stiffness;
        let mut slope = Unknowns::zeros();
        for i in 0..6 {
            let by = V6::ith(i, 1.0);
            slope[i] = (missing(kappa + by) - missing(kappa - by)) / 2.0;
        }
        let variance = slope.dot(&case.factor().0.solve(&slope));
        let expected = case.prior.sigma * variance.sqrt();
        assert!(found.restitution < 0.9);
        assert_within(found.sigma_m_s / expected, 1.0, 1e-3);
    }

    /// Up to the sum of squares of 36 loads less three unknowns, plus three standard deviations. Two loads with three unknowns
    /// leave nothing but that margin.
    #[test]
    fn residuals_are_noise_as_far_as_noise_makes_so_many() {
        let many: f64 = 33.0 + 3.0 * 72.0_f64.sqrt();
        for (error, noise, loads, usual) in [
            (0.5, 0.5, 36.0, many),
            (5.0, 0.5, 36.0, many),
            (5.0, 0.05, 36.0, many),
            (5.0, 0.0, 36.0, many),
            (5.0, 0.1, 2.0, 6.0),
        ] {
            let case = Case::new(0.0, error, 0.5);
            let squares = loads * case.estimate.error * case.estimate.error;
            let expected = (noise * noise * usual / squares).min(1.0);
            assert_within(case.restitution(loads, noise).noise_share, expected, 1e-9);
        }
    }

    /// A damping that the loads show counts, with its restitution; one that they do not show counts as zero, and is reported as
    /// hidden if noise may hide as much as would slow the rebound.
    #[test]
    fn a_contact_is_damped_as_far_as_its_loads_show_it() {
        for (damping, noise, hides) in [
            (2000.0, 0.01, false),
            (0.0, 0.01, false),
            (0.0, 1.0, true),
            (2000.0, 1.0, false),
        ] {
            let case = Case::new(damping, noise, noise);
            let found = case.restitution(36.0, noise);
            assert_within(found.restitution, case.with(damping), 0.02);
            assert_eq!(found.hides_damping, hides, "{damping} {noise}");
        }
    }

    /// At four standard deviations from zero the probability of a damping is 3/4.
    #[test]
    fn a_damping_counts_as_far_as_it_is_likely() {
        for (deviations, likely) in [(4.0, 0.7488), (3.5, 0.3140), (3.0, 0.0826)] {
            let noise = noise(2000.0, 0.5, |case| {
                let (units, damping) = case.damping();
                damping / units / deviations
            });
            let case = Case::new(2000.0, 0.0, noise);
            let expected = case.with(likely * case.damping().1);
            assert_within(case.restitution(36.0, noise).restitution, expected, 1e-3);
        }
    }

    /// 3.7 standard deviations of it would take 0.8 % of the speed.
    #[test]
    fn noise_hides_a_damping_that_the_guard_would_not_leave_alone() {
        for (part, hides) in [(0.97, false), (1.03, true)] {
            let noise = noise(0.0, 0.05, |case| {
                let zeta = -f64::ln(1.0 - 0.008) / core::f64::consts::PI;
                let critical = 2.0 * (case.estimate.stiffness * case.estimate.mass).sqrt();
                part * zeta * critical / (3.717 * case.damping().0)
            });
            let found = Case::new(0.0, 0.0, noise).restitution(36.0, noise);
            assert_eq!(found.hides_damping, hides, "{part}");
        }
    }
}
