//! The reference: the motion that the two spacecraft should have. It is straight, then that of a spring and a damper, then
//! straight again.
//!
//! From the onset on it is, along the direction of contact, the motion s(t) of a [`KelvinVoigt`] model, and across it straight
//! on: Q(t) = Q₀ + V₀ t − d (V t − s(t)), where d is the direction into which a force along the contact pushes, d · a = 1.

use super::V6;
use super::contact_estimator::Estimate;
use super::kelvin_voigt::KelvinVoigt;
use super::preload::Preload;
use super::tuning::*;

/// The desired motion of the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// Time of the onset, cycles; without a contact any time.
    pub(super) onset: f64,
    /// Position at that time and velocity before it.
    pub(super) position: V6,
    pub(super) velocity: V6,
    /// d: into which a force along the contact pushes; d · a = 1.
    pub(super) push: V6,
    /// V: closing velocity, m/s.
    pub(super) closing: f64,
    /// The contact; `None`: straight on.
    pub(super) contact: Option<KelvinVoigt>,
    /// Displacement into the contact in addition to that motion.
    pub(super) preload: Preload,
}

/// Deviations along the horizon: now, and after 1, 2 ... cycles.
pub(super) type Deviations = [Deviation; PREDICTION_HORIZON + 1];

/// Deviation of the motion along the contact from straight flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Deviation {
    /// V t − s(t), m.
    pub(super) displacement: f64,
    /// V − s'(t), m/s.
    pub(super) velocity: f64,
}

impl Reference {
    /// Straight on, from a position at a cycle.
    pub(super) fn straight(cycle: usize, position: V6, velocity: V6) -> Self {
        Self {
            onset: cycle as f64,
            position,
            velocity,
            push: V6::zeros(),
            closing: 0.0,
            contact: None,
            preload: Preload::default(),
        }
    }

    /// Into a contact that begins at a time (cycles) and position, with a velocity and closing velocity.
    pub(super) fn into_contact(
        estimate: &Estimate,
        (onset, position): (f64, V6),
        (velocity, closing): (V6, f64),
    ) -> Self {
        let (k, c, mass) = (estimate.stiffness, estimate.damping, estimate.mass);
        Self {
            onset,
            position,
            velocity,
            push: estimate.push,
            closing,
            contact: Some(KelvinVoigt::new(k, c, mass)),
            preload: Preload::default(),
        }
    }

    /// The same motion along the contact, but across its gradient a with the position and velocity of the model at a cycle.
    pub(super) fn across(
        mut self,
        gradient: &V6,
        cycle: f64,
        (position, velocity): (&V6, &V6),
        cycle_s: f64,
    ) -> Self {
        let t = (cycle - self.onset) * cycle_s;
        let across = |off: V6| off - self.push * gradient.dot(&off);
        let faster = across(velocity - self.velocity);
        let apart = across(position - (self.position + self.velocity * t));
        // A difference much larger than the motion itself is an error of the gradient.
        if faster.norm() > SPEED_LIMIT * self.velocity.norm() {
            return self;
        }
        self.velocity += faster;
        self.position += apart - faster * t;
        self
    }

    /// ζ of the contact.
    pub(super) fn damping_ratio(&self) -> f64 {
        self.contact.map_or(0.0, |contact| contact.zeta)
    }

    /// The deviations at times from `cycle` on, one cycle apart.
    pub(super) fn deviations<const N: usize>(&self, cycle: f64, cycle_s: f64) -> [Deviation; N] {
        let Some(contact) = &self.contact else {
            return [Deviation::default(); N];
        };
        let begin = (cycle - self.onset) * cycle_s;
        let samples = contact.sample::<N>(begin, cycle_s);
        core::array::from_fn(|i| {
            let t = begin + cycle_s * i as f64;
            let (s, rate) = samples[i];
            Deviation {
                displacement: self.closing * (t - s) - self.preload.at(cycle + i as f64),
                velocity: self.closing * (1.0 - rate),
            }
        })
    }

    /// Position at a cycle.
    pub(super) fn position_at(&self, cycle: f64, cycle_s: f64) -> V6 {
        let [deviation] = self.deviations::<1>(cycle, cycle_s);
        let straight = self.position + self.velocity * ((cycle - self.onset) * cycle_s);
        straight - self.push * deviation.displacement
    }

    /// Restitution of the contact.
    pub(super) fn restitution(&self) -> f64 {
        self.contact.map_or(1.0, |contact| contact.restitution)
    }

    /// End of the contact, cycles.
    pub(super) fn end(&self, cycle_s: f64) -> f64 {
        self.onset + self.contact.map_or(0.0, |contact| contact.contact_s) / cycle_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::scene::oblique;
    use crate::delay::spacecraft::CYCLE_S;

    /// Time of the onset, cycles.
    const ONSET: f64 = 100.5;

    /// Before, in and after the contact: along its gradient that of the bounce, across it straight on.
    #[test]
    fn the_motion_is_that_of_a_mass_at_a_spring() {
        let (contact, reference) = oblique(0.0, ONSET);
        let gradient = contact.gradient;
        let (closing, omega) = (reference.closing, 21.0);
        let contact = core::f64::consts::PI / omega;
        assert!((reference.end(CYCLE_S) - ONSET - contact / CYCLE_S).abs() < 1e-9);
        assert_eq!(
            (reference.damping_ratio(), reference.restitution()),
            (0.0, 1.0)
        );
        let deviations: [Deviation; 80] = reference.deviations(80.25, CYCLE_S);
        for (n, deviation) in deviations.iter().enumerate() {
            let cycle = 80.25 + n as f64;
            let t = (cycle - ONSET) * CYCLE_S;
            let (way, rate) = match t {
                _ if t < 0.0 => (t, 1.0),
                _ if t > contact => (contact - t, -1.0),
                _ => ((omega * t).sin() / omega, (omega * t).cos()),
            };
            assert!(
                (deviation.displacement - closing * (t - way)).abs() < 1e-12,
                "{cycle}"
            );
            assert!(
                (deviation.velocity - closing * (1.0 - rate)).abs() < 1e-12,
                "{cycle}"
            );
            let found = reference.position_at(cycle, CYCLE_S) - reference.position;
            assert!(
                (gradient.dot(&found) - closing * way).abs() < 1e-12,
                "{cycle}"
            );
            let across = found - reference.velocity * t;
            let along = reference.push * gradient.dot(&across);
            assert!((across - along).amax() < 1e-12, "{cycle}");
        }
    }

    #[test]
    fn straight_flight_has_neither_end_nor_damping() {
        let straight = Reference::straight(7, V6::repeat(0.2), V6::repeat(0.01));
        assert_eq!(straight.end(CYCLE_S), 7.0);
        assert_eq!(
            (straight.damping_ratio(), straight.restitution()),
            (0.0, 1.0)
        );
        let later = straight.position_at(12.0, CYCLE_S);
        assert!((later - V6::repeat(0.2 + 0.01 * 5.0 * CYCLE_S)).amax() < 1e-15);
        assert!((oblique(0.3, ONSET).1.damping_ratio() - 0.3).abs() < 1e-12);
    }

    #[test]
    fn across_the_contact_it_goes_as_the_model_and_along_it_as_before() {
        let (contact, reference) = oblique(0.1, ONSET);
        let gradient = contact.gradient;
        let position = reference.position + V6::new(1.0, 2.0, -1.0, 0.5, -2.0, 1.5) * 1e-4;
        let velocity = reference.velocity * 0.7 + V6::new(0.0, 1.0, 0.5, 0.0, -1.0, 0.3) * 1e-3;
        let cycle = 110.0;
        let turned = reference.across(&gradient, cycle, (&position, &velocity), CYCLE_S);
        for n in [100.0, 110.0, 125.0] {
            let apart = turned.position_at(n, CYCLE_S) - reference.position_at(n, CYCLE_S);
            assert!(gradient.dot(&apart).abs() < 1e-12, "{n}");
        }
        // The straight flight goes through the given position with the given velocity, except along the push.
        let straight =
            |of: &Reference, n: f64| of.position + of.velocity * ((n - of.onset) * CYCLE_S);
        for n in [110.0, 118.0] {
            let off = straight(&turned, n) - (position + velocity * ((n - cycle) * CYCLE_S));
            let along = reference.push * gradient.dot(&off);
            assert!((off - along).amax() < 1e-12, "{n}: {off}");
        }
    }

    /// Four times the velocity before the contact.
    #[test]
    fn what_moves_much_faster_across_than_it_came_is_not_followed() {
        let (contact, reference) = oblique(0.0, ONSET);
        let gradient = contact.gradient;
        let off = V6::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.0);
        let across = off - reference.push * gradient.dot(&off);
        let most = SPEED_LIMIT * reference.velocity.norm() / across.norm();
        for (size, followed) in [(0.99 * most, true), (1.01 * most, false)] {
            let velocity = reference.velocity + across * size;
            let motion = (&reference.position, &velocity);
            let turned = reference.across(&gradient, ONSET, motion, CYCLE_S);
            assert_eq!(turned.velocity != reference.velocity, followed, "{size}");
        }
    }
}
