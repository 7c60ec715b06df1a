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

    /// Of a contact of this restitution and misfit, at 5 mm/s, with a rebound and noise by the closing velocity.
    fn outcome(restitution: f64, misfit: f64, rebound: f64, noise: f64) -> Outcome {
        Outcome {
            closing: 0.005,
            after: -rebound * 0.005,
            restitution,
            misfit,
            noise_misfit: noise,
            noise,
        }
    }

    /// Up to a misfit of six hundredths, and one and a half of what noise makes.
    #[test]
    fn a_contact_is_identified_if_it_explains_its_loads() {
        for (misfit, noise, fits) in [
            (0.0, 0.0, true),
            (0.059, 0.0, true),
            (0.061, 0.0, false),
            (0.089, 0.02, true),
            (0.091, 0.02, false),
        ] {
            assert_eq!(
                outcome(1.0, misfit, 1.0, noise).fits(),
                fits,
                "{misfit} {noise}"
            );
        }
    }

    /// By a hundredth and twice the misfit, at most three hundredths, and three standard deviations; to more than 1.008 of the
    /// speed in no case.
    #[test]
    fn the_rebound_of_an_identified_contact_is_held_to_it() {
        for (e, misfit, noise, rebound, held) in [
            (1.0, 0.0, 0.0, 0.991, false),
            (1.0, 0.0, 0.0, 0.989, true),
            (1.0, 0.0, 0.0, 1.0079, false),
            (1.0, 0.0, 0.0, 1.0081, true),
            (1.0, 0.005, 0.0, 0.981, false),
            (1.0, 0.005, 0.0, 0.979, true),
            (1.0, 0.05, 0.0, 0.971, false),
            (1.0, 0.05, 0.0, 0.969, true),
            (1.0, 0.0, 0.001, 0.988, false),
            (1.0, 0.0, 0.001, 0.986, true),
            (1.0, 0.0, 0.001, 1.0109, false),
            (1.0, 0.0, 0.001, 1.0111, true),
            (0.6, 0.0, 0.0, 0.609, false),
            (0.6, 0.0, 0.0, 0.611, true),
            (0.6, 0.0, 0.0, 0.589, true),
            (1.2, 0.0, 0.0, 1.0, false),
            (1.2, 0.0, 0.0, 1.1, true),
        ] {
            let outcome = outcome(e, misfit, rebound, noise);
            let name = format!("{e} {misfit} {noise} {rebound}");
            let Some((change, flag)) = outcome.guard() else {
                assert!(!held, "{name}");
                continue;
            };
            assert!(held && flag == LawFlags::GUARD_IDENTIFIED, "{name}");
            let after = outcome.after + change;
            assert!((after + e.min(1.0) * 0.005).abs() < 1e-15, "{name}");
        }
    }

    /// Between a stop and the speed that it came with.
    #[test]
    fn the_rebound_of_any_other_contact_is_bounded_to_that_of_a_passive_one() {
        for (noise, rebound, bounded) in [
            (0.0, 0.999, None),
            (0.0, 1.001, Some(1.0)),
            (0.0, 0.001, None),
            (0.0, -0.001, Some(0.0)),
            (0.01, 1.009, None),
            (0.01, 1.029, None),
            (0.01, 1.031, Some(1.0)),
        ] {
            let outcome = outcome(0.5, 0.5, rebound, noise);
            let found = outcome.guard().map(|(change, flag)| {
                assert!(flag == LawFlags::GUARD_PASSIVE);
                -(outcome.after + change) / outcome.closing
            });
            match (found, bounded) {
                (Some(found), Some(bounded)) => assert!((found - bounded).abs() < 1e-12),
                _ => assert_eq!(found.is_some(), bounded.is_some(), "{noise} {rebound}"),
            }
        }
    }

    #[test]
    fn what_noise_hides_is_that_of_the_outcome() {
        let outcome = outcome(1.0, 0.0, 0.998, 0.005);
        assert!((outcome.hidden(&ELASTIC) + 1e-5).abs() < 1e-15);
    }

    /// A contact at 5 mm/s along an oblique direction, with an error of this size (N) in its loads; what it says of the
    /// restitution, with the noise of a load.
    fn contact(damping: f64, error: f64, noise: f64) -> (Information, Prior, Estimate, V6, V6) {
        let h = V6::new(0.8, -0.6, 0.0, 0.1, 0.0, -0.2);
        let bh = V6::new(1.6, -1.1, 0.1, 0.3, -0.1, -0.5) * 1e-3;
        let prior = Prior::new((2e5, noise, 0.0), 0.0, (h, bh));
        let kappa = V6::new(0.9, -0.5, 0.2, 0.1, 0.1, -0.1) * 2.2e5;
        let before = V6::new(0.9, -0.5, 0.1, 0.0, 0.2, -0.1) * 0.005;
        let mut information = Information::new(V6::zeros());
        information.begin(&V6::zeros(), 0.005, 10.0, prior.sigma);
        for n in 1..37 {
            let t = 0.004 * f64::from(n);
            let wave = |rate: f64| (rate * f64::from(n)).sin();
            let across = V6::new(
                wave(1.1),
                wave(2.3),
                wave(1.7),
                wave(0.9),
                wave(2.9),
                wave(1.3),
            );
            let position = before * ((21.0 * t).sin() / 21.0) + across * 1e-6;
            let change = 0.005 * ((21.0 * t).cos() - 1.0);
            let load = kappa.dot(&position) + damping * (0.005 + change) + error * wave(3.7);
            information.add(&position, change, load);
        }
        let estimate = information.solve(&prior, 0.005);
        let after = before * -0.9 + V6::new(0.0, 1.0, -1.0, 0.5, 0.0, 0.3) * 2e-4;
        (information, prior, estimate, before, after)
    }

    /// Of e a·V + a·v when the direction a varies as the loads leave it open, with a·d = 1: by its derivative in each of the six
    /// numbers that it is made of.
    #[test]
    fn the_doubt_of_the_rebound_is_that_of_the_contacts_direction() {
        let (information, prior, estimate, before, after) = contact(2000.0, 0.5, 0.5);
        let velocities = (&before, &after);
        let found =
            RestitutionEstimate::new(&information, &estimate, &prior, velocities, (36.0, 0.5));
        let missing = |kappa: V6| {
            let gradient = kappa / kappa.dot(&estimate.push);
            gradient.dot(&(after + before * found.restitution))
        };
        let kappa = estimate.gradient * estimate.stiffness;
        let mut slope = Unknowns::zeros();
        for i in 0..6 {
            let mut by = V6::zeros();
            by[i] = 1.0;
            slope[i] = (missing(kappa + by) - missing(kappa - by)) / 2.0;
        }
        let closing = estimate.gradient.dot(&before);
        let (factor, _) = information.normal_equations(&prior, closing);
        let variance = slope.dot(&factor.solve(&slope));
        let expected = prior.sigma * variance.sqrt();
        assert!(found.restitution < 0.9);
        let error = found.sigma_m_s / expected - 1.0;
        assert!(error.abs() < 1e-3, "{} {expected}", found.sigma_m_s);
    }

    /// As much of the squares as 36 loads less three unknowns may leave, and three standard deviations more.
    #[test]
    fn residuals_are_noise_as_far_as_noise_makes_so_many() {
        let usual: f64 = 33.0 + 3.0 * 72.0_f64.sqrt();
        for (error, noise) in [(0.5, 0.5), (5.0, 0.5), (5.0, 0.05), (5.0, 0.0)] {
            let (information, prior, estimate, before, after) = contact(0.0, error, 0.5);
            let found = RestitutionEstimate::new(
                &information,
                &estimate,
                &prior,
                (&before, &after),
                (36.0, noise),
            );
            let squares = 36.0 * estimate.error * estimate.error;
            let expected = (noise * noise * usual / squares).min(1.0);
            assert!(
                (found.noise_share - expected).abs() < 1e-9,
                "{error}: {}",
                found.noise_share
            );
        }
        // Of two loads three unknowns leave nothing, but for chance.
        let (information, prior, estimate, before, after) = contact(0.0, 5.0, 0.5);
        let found = RestitutionEstimate::new(
            &information,
            &estimate,
            &prior,
            (&before, &after),
            (2.0, 0.1),
        );
        let expected = 0.01 * 6.0 / (2.0 * estimate.error * estimate.error);
        assert!(
            (found.noise_share - expected).abs() < 1e-9,
            "{}",
            found.noise_share
        );
    }

    /// A damping that the loads show is there, with its restitution; one that they do not is none, and is hidden if noise may hide
    /// as much as would slow the rebound.
    #[test]
    fn a_contact_is_damped_as_far_as_its_loads_show_it() {
        for (damping, noise, hides) in [
            (2000.0, 0.01, false),
            (0.0, 0.01, false),
            (0.0, 1.0, true),
            (2000.0, 1.0, false),
        ] {
            let (information, prior, estimate, before, after) = contact(damping, noise, noise);
            let found = RestitutionEstimate::new(
                &information,
                &estimate,
                &prior,
                (&before, &after),
                (36.0, noise),
            );
            let expected = KelvinVoigt::new(estimate.stiffness, damping, estimate.mass).restitution;
            assert!(
                (found.restitution - expected).abs() < 0.02,
                "{damping} {noise}: {}",
                found.restitution
            );
            assert_eq!(found.hides_damping, hides, "{damping} {noise}");
        }
    }

    /// Standard deviation of a damping by that of a load, and the damping that fits best.
    fn damping_of(information: &Information, prior: &Prior, closing: f64) -> (f64, f64) {
        let (factor, target) = information.normal_equations(prior, closing);
        let variance = covariance_of_damping(&factor)[DAMPING];
        (variance.sqrt(), factor.solve(&target)[DAMPING])
    }

    /// Four standard deviations from none it is there with a probability of 3/4.
    #[test]
    fn a_damping_counts_as_far_as_it_is_likely() {
        for (deviations, likely) in [(4.0, 0.7488), (3.5, 0.3140), (3.0, 0.0826)] {
            let mut noise = 0.5;
            // The noise with which it is that far from none.
            for _ in 0..20 {
                let (information, prior, estimate, before, _) = contact(2000.0, 0.0, noise);
                let (units, damping) =
                    damping_of(&information, &prior, estimate.gradient.dot(&before));
                noise = damping / units / deviations;
            }
            let (information, prior, estimate, before, after) = contact(2000.0, 0.0, noise);
            let velocities = (&before, &after);
            let found = RestitutionEstimate::new(
                &information,
                &estimate,
                &prior,
                velocities,
                (36.0, noise),
            );
            let (_, damping) = damping_of(&information, &prior, estimate.gradient.dot(&before));
            let expected = KelvinVoigt::new(estimate.stiffness, likely * damping, estimate.mass);
            let apart = found.restitution - expected.restitution;
            assert!(
                apart.abs() < 1e-3,
                "{deviations}: {} {}",
                found.restitution,
                expected.restitution
            );
        }
    }

    /// 3.7 standard deviations of it would take 0.8 % of the speed.
    #[test]
    fn noise_hides_a_damping_that_the_guard_would_not_leave_alone() {
        for (part, hides) in [(0.97, false), (1.03, true)] {
            let mut noise = 0.05;
            for _ in 0..20 {
                let (information, prior, estimate, before, _) = contact(0.0, 0.0, noise);
                let (units, _) = damping_of(&information, &prior, estimate.gradient.dot(&before));
                let zeta = -f64::ln(1.0 - 0.008) / core::f64::consts::PI;
                let damping = 2.0 * zeta * (estimate.stiffness * estimate.mass).sqrt();
                noise = part * damping / (3.717 * units);
            }
            let (information, prior, estimate, before, after) = contact(0.0, 0.0, noise);
            let velocities = (&before, &after);
            let found = RestitutionEstimate::new(
                &information,
                &estimate,
                &prior,
                velocities,
                (36.0, noise),
            );
            assert_eq!(found.hides_damping, hides, "{part}");
        }
    }
}
