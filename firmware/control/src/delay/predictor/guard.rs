//! The guard at the end of a contact. A rebound that departs from that of an identified contact is set to it; that of a contact
//! that was not identified is bounded to what a passive one can give, 0 ≤ e ≤ 1. The guard moves the model without a measured
//! force; the impulse is in the trace, and each action is flagged.

use super::tuning::*;
use crate::delay::status::LawFlags;

/// A contact that has ended.
pub(super) struct Outcome {
    /// Velocity of the model along the contact, before and after, m/s.
    pub(super) closing: f64,
    pub(super) after: f64,
    /// Restitution of the identified contact.
    pub(super) restitution: f64,
    /// Misfit of the identification, as a fraction of the load, and the misfit that noise alone makes.
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

    /// The velocity that the guard adds after the contact, m/s, and the flag of that action; `None` if it does not act.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outcome of a contact with this identified restitution and misfit, at 5 mm/s, with a rebound and noise relative to the
    /// closing velocity.
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

    /// Up to a misfit of 0.06 plus one and a half times that of noise.
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

    /// The tolerance is 0.01 and twice the misfit, at most 0.03, plus three standard deviations of noise; a gain above 1.008 of
    /// the speed is never left.
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

    /// Between rest and the speed of the approach.
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
}
