//! The load that the model of the two spacecraft feels: zero in free flight, and in a contact the measured one with corrections
//! for the parts of its beginning and end that lie between samples.

use super::Supervisor;
use crate::delay::LawInput;
use crate::delay::predictor::V6;
use crate::delay::predictor::contact::{Contact, Onset};
use crate::delay::predictor::contact_estimator::direction;
use crate::delay::predictor::dynamic_matrix::DynamicMatrix;
use crate::delay::predictor::observer::Observer;
use crate::delay::predictor::reference::Reference;
use crate::delay::predictor::reversals::Reversals;
use crate::delay::predictor::tuning::*;
use crate::delay::status::{ConfidenceLevel, LawFlags};
use crate::scalar::Scalar;
use nalgebra::ComplexField;

impl Supervisor {
    /// The load that the model feels, N: in a contact the mean of the last two measured ones, corrected for the parts of its
    /// beginning and end that lie between samples, and at its end for noise or by the guard.
    #[inline(never)]
    pub(in super::super) fn felt_load<S: Scalar>(
        &mut self,
        observer: &mut Observer,
        going_on: &mut Option<Contact>,
        input: &LawInput<'_, S>,
        velocity: &V6,
    ) -> V6 {
        let threshold = self.noise.threshold();
        if going_on.is_none() {
            if !self.is_onset(observer, velocity, threshold) {
                return V6::zeros();
            }
            observer.previous_load = V6::zeros();
            self.begin_contact(observer, going_on, input, velocity, threshold);
        }
        let Some(contact) = going_on else {
            return V6::zeros();
        };
        self.flags.set(LawFlags::CONTACT);
        let only = self.latency_known.then_some(self.latency);
        let at_force = &observer.at_force;
        contact.add(&observer.load, at_force, threshold, self.latency, only);
        self.choose_latency(contact);
        let cycle_s = self.model.cycle_s;
        let added = contact.onset_correction(self.latency)
            + contact.release_correction(&at_force.velocity[self.latency], self.latency);
        let (h, _) = contact.direction();
        let mut felt = (observer.load + observer.previous_load) * 0.5 - h * (added / cycle_s);
        let estimate = contact.estimate(self.latency);
        self.misfit = estimate.misfit;
        self.identified = [estimate.stiffness, estimate.damping];
        let reference = contact.reference(self.latency);
        let delay = self.model.execution_delay(self.latency);
        if contact.is_over(observer.cycle, &reference, delay) {
            felt += self.end_contact(observer, contact, &reference, velocity, &felt);
            *going_on = None;
        }
        felt
    }

    /// Whether a contact begins: a significant load against the motion. A load that is not significant is taken as noise; a
    /// significant one along the motion is spurious.
    fn is_onset(&mut self, observer: &Observer, velocity: &V6, threshold: f64) -> bool {
        let load = &observer.load;
        let pair = (load + observer.previous_load).norm();
        let significant = load.norm() > threshold || pair > threshold * core::f64::consts::SQRT_2;
        if !significant {
            self.noise.add(load);
            return false;
        }
        let against_motion = load.dot(velocity) < 0.0;
        if !against_motion {
            self.flags.set(LawFlags::SPURIOUS_LOAD);
        }
        against_motion
    }

    #[inline(never)]
    fn begin_contact<S: Scalar>(
        &mut self,
        observer: &Observer,
        contact: &mut Option<Contact>,
        input: &LawInput<'_, S>,
        velocity: &V6,
        threshold: f64,
    ) {
        self.approach.end();
        let mobility = observer.mobility(input);
        let load = -observer.load;
        let (h, bh) = direction(&load, &mobility);
        let onset = Onset {
            velocity: *velocity,
            mobility,
            noise: self.noise.sigma(),
            threshold,
            stiffness: self.expected_stiffness(h.dot(&bh)),
            delay_sigma_s: self.approach.findings.deviation * self.model.cycle_s,
            remembered: self.memory.of(&load),
            latency: self.latency,
            cycle_s: self.model.cycle_s,
        };
        *contact = Some(Contact::new(observer, &onset));
    }

    /// Stiffness that is expected along a direction, N/m.
    fn expected_stiffness(&self, inverse_mass: f64) -> f64 {
        if self.settings.contact_stiffness_n_per_m > 0.0 {
            return self.settings.contact_stiffness_n_per_m;
        }
        let delay = self.model.execution_delay(self.latency).max(1.0);
        let omega = PRIOR_PHASE / (delay * self.model.cycle_s);
        omega * omega / inverse_mass.max(1e-9)
    }

    fn choose_latency(&mut self, contact: &mut Contact) {
        if self.latency_known {
            return;
        }
        let closing = contact
            .estimate(self.latency)
            .gradient
            .dot(&contact.velocity);
        let noise = (self.noise.sigma(), self.approach.findings.noise_m);
        let best = contact.estimator.choose(self.latency, noise, closing);
        if best != self.latency {
            self.latency = best;
            self.matrix = DynamicMatrix::new(&self.model, best);
        }
    }

    /// Ends a contact. Returns a load to add in this cycle, N: the one that noise has hidden, or that the guard adds.
    #[inline(never)]
    fn end_contact(
        &mut self,
        observer: &mut Observer,
        contact: &Contact,
        reference: &Reference,
        velocity: &V6,
        felt: &V6,
    ) -> V6 {
        let (latency, cycle_s) = (self.latency, self.model.cycle_s);
        let after = velocity + contact.mobility * felt * cycle_s;
        let noise = self.noise_against_model(contact);
        let outcome = contact.outcome(latency, reference, &after, noise);
        self.latency_found |= contact.estimator.settled;
        self.confidence = if outcome.fits() {
            self.memory.keep(contact, latency);
            ConfidenceLevel::Verified
        } else {
            ConfidenceLevel::Fallback
        };
        // The model continues from the reference; from the robot's position if the fallback has led the robot.
        observer.model = if self.fallback.trust < 1.0 {
            observer.at_force.position[latency]
        } else {
            let reference = self.reference(contact, observer, &after);
            reference.position_at(observer.cycle as f64, cycle_s)
        };
        // The reversal of the robot shows in its pose a delay from now.
        self.settling = (self.model.linear.mean_delay + TRACKING_SETTLES) as u32;
        observer.load = V6::zeros();
        self.reversals = Reversals::default();
        let missing = if let Some((missing, flag)) = outcome.guard().filter(|_| self.settings.guard)
        {
            self.flags.set(flag);
            missing
        } else if outcome.fits() {
            let estimate = contact.restitution(latency, &after, noise);
            if estimate.hides_damping {
                self.flags.set(LawFlags::DAMPING_IN_NOISE);
            }
            estimate.hidden(&outcome)
        } else {
            0.0
        };
        let (h, _) = contact.direction();
        h * (missing * contact.estimate(latency).mass / cycle_s)
    }

    /// Standard deviation of a load relative to the identified contact at the believed position of the robot: from the sensor's
    /// noise, and from the noise of the position after the observer, N.
    fn noise_against_model(&self, contact: &Contact) -> f64 {
        let gain = self.observer_gain(&contact.velocity);
        let position = self.approach.findings.noise_m * ComplexField::sqrt(gain / (2.0 - gain));
        let (load, apart) = (
            self.noise.sigma(),
            contact.estimate(self.latency).stiffness * position,
        );
        ComplexField::sqrt(load * load + apart * apart)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::docking::{Docking, believed, between_walls, robot};
    use crate::delay::predictor::bounce::{Bounce, CLOSING, MASS, STIFFNESS, assert_near, x};
    use crate::delay::predictor::noise::LoadNoise;
    use crate::delay::predictor::supervisor::tests::supervisor;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::delay::{Law, LawName};
    use crate::frames::Wrench;
    use softdock_delay_plants::Measurement;

    /// ω τ = 0.6 for the effective mass, or what is set.
    #[test]
    fn a_contact_is_expected_to_last_five_delays() {
        let mut supervisor = supervisor(0.0);
        let omega = 0.6 / 0.032;
        assert_near(
            supervisor.expected_stiffness(1.0 / 500.0),
            500.0 * omega * omega,
            1e-9,
        );
        assert_near(
            supervisor.expected_stiffness(0.0),
            1e9 * omega * omega,
            1e-9,
        );
        supervisor.latency = 4;
        let later = 0.6 / 0.016;
        assert_near(
            supervisor.expected_stiffness(1.0 / 500.0),
            500.0 * later * later,
            1e-9,
        );
        // A robot with no delay counts as one with a delay of a cycle.
        supervisor.model.linear.mean_delay = 0.0;
        let soonest = 0.6 / CYCLE_S;
        assert_near(supervisor.expected_stiffness(1.0), soonest * soonest, 1e-9);
        supervisor.settings.contact_stiffness_n_per_m = 3e5;
        assert_near(supervisor.expected_stiffness(1.0), 3e5, 1e-9);
    }

    /// Noise of the sensor and of the position after the observer: a gain g leaves g/(2 − g) of the variance.
    #[test]
    fn the_noise_of_a_load_is_that_of_the_sensor_and_of_the_position() {
        let contact = Bounce::spring(0.5).followed(0.01, 25);
        for (load, noise_m) in [(0.2, 0.0), (0.0001, 1e-6), (0.2, 1e-6)] {
            let mut supervisor = supervisor(noise_m);
            supervisor.noise = LoadNoise::new(load);
            let gain = supervisor.observer_gain(&contact.velocity);
            let apart = STIFFNESS * noise_m * (gain / (2.0 - gain)).sqrt();
            let found = supervisor.noise_against_model(&contact);
            let expected = (load * load + apart * apart).sqrt();
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
    }

    /// A load against the motion that exceeds a threshold: 4.5 times 0.002 N alone, or √2 times that together with the load
    /// before.
    #[test]
    fn a_contact_begins_with_a_significant_load_against_the_motion() {
        let (spacecraft, wrench) = (Spacecraft::before_a_wall([0.0; 3]), Wrench::zero());
        let mut observer = Observer::new(&spacecraft.input(&wrench));
        for (load, before, onset, spurious) in [
            (-0.0091, 0.0, true, false),
            (-0.0089, 0.0, false, false),
            (0.0091, 0.0, false, true),
            (-0.0065, -0.0065, true, false),
            (-0.0063, -0.0063, false, false),
            (-0.0089, 0.0089, false, false),
        ] {
            let mut supervisor = supervisor(0.0);
            (observer.load, observer.previous_load) = (x(load), x(before));
            let threshold = supervisor.noise.threshold();
            assert_eq!(
                supervisor.is_onset(&observer, &x(0.005), threshold),
                onset,
                "{load}"
            );
            assert_eq!(
                supervisor.flags.has(LawFlags::SPURIOUS_LOAD),
                spurious,
                "{load}"
            );
        }
        // A load that is not significant counts as noise.
        let mut supervisor = supervisor(0.0);
        (observer.load, observer.previous_load) = (x(3.0), V6::zeros());
        (0..20).for_each(|_| {
            supervisor.is_onset(&observer, &x(0.005), 4.0);
        });
        assert_near(supervisor.noise.sigma(), 3.0, 1e-9);
    }

    #[test]
    fn a_latency_that_was_found_stays_so() {
        let plant = between_walls(robot(), 0.0, Measurement::default());
        let mut docking = Docking::new(&believed(LawName::Predictor, &robot()), &plant, 0.005);
        for found in [false, true, true, true] {
            let Law::Predictor(law) = &docking.law else {
                panic!("another law");
            };
            assert_eq!(law.supervisor.latency_found, found);
            docking.bounce();
        }
    }

    /// The model continues from the reference, or from the robot if it was led by the fallback.
    #[test]
    fn after_a_contact_the_model_goes_on_from_the_reference_or_from_the_robot() {
        for (trust, led) in [(1.0, true), (0.5, false), (0.0, false)] {
            let mut supervisor = supervisor(0.0);
            supervisor.fallback.trust = trust;
            let contact = Bounce::spring(0.5).followed(0.01, 36);
            let mut observer = Bounce::spring(0.5).observer(95);
            observer.model = observer.at_force.position[0];
            let exact = observer.model;
            observer.at_force.position[0] += x(1e-3);
            let reference = contact.reference(0);
            let ended = (x(-CLOSING), V6::zeros());
            supervisor.end_contact(&mut observer, &contact, &reference, &ended.0, &ended.1);
            let robot = observer.at_force.position[0];
            let expected = if led { exact } else { robot };
            assert!(
                (observer.model - expected).amax() < 1e-6,
                "{trust}: {}",
                observer.model
            );
        }
    }

    /// The guard compares the velocity after the last load: 0.4 mm/s more.
    #[test]
    fn the_rebound_is_the_velocity_after_the_last_load() {
        for (before, held) in [
            (-CLOSING + 4e-4, false),
            (-CLOSING, true),
            (-CLOSING + 8e-4, true),
        ] {
            let mut supervisor = supervisor(0.0);
            let contact = Bounce::spring(0.5).followed(0.01, 36);
            let mut observer = Bounce::spring(0.5).observer(95);
            let reference = contact.reference(0);
            let load = x(-50.0);
            let added =
                supervisor.end_contact(&mut observer, &contact, &reference, &x(before), &load);
            assert_eq!(
                supervisor.flags.has(LawFlags::GUARD_IDENTIFIED),
                held,
                "{before}"
            );
            let after = before + (load + added)[0] / MASS * CYCLE_S;
            assert!((after + CLOSING).abs() < 1e-5, "{before}: {after}");
        }
    }
}
