//! From the first load to the rebound: which load the model feels.

use super::contact::{Contact, Onset};
use super::flight::Flight;
use super::guard::Ended;
use super::reference::Reference;
use super::solver::Solver;
use super::turn::Turns;
use super::{EXPECTED_PHASE, Pilot, V6, bank, identify};
use crate::delay::LawInput;
use crate::delay::status::{LawFlags, Rung};
use crate::scalar::Scalar;

use nalgebra::ComplexField;

impl Pilot {
    /// Stiffness that is expected along a direction, N/m.
    fn expected_stiffness(&self, inverse_mass: f64) -> f64 {
        if self.settings.contact_stiffness_n_per_m > 0.0 {
            return self.settings.contact_stiffness_n_per_m;
        }
        let late = (self.plan.chain.mean - self.latency as f64).max(1.0) * self.plan.cycle_s;
        let omega = EXPECTED_PHASE / late;
        omega * omega / inverse_mass.max(1e-9)
    }

    /// The load that the model feels, N.
    #[inline(never)]
    pub(super) fn feel<S: Scalar>(
        &mut self,
        flight: &mut Flight,
        going_on: &mut Option<Contact>,
        input: &LawInput<'_, S>,
        velocity: &V6,
    ) -> V6 {
        let threshold = self.noise.threshold();
        let begins = going_on.is_none();
        if begins {
            let pair = (flight.load + flight.load_before).norm();
            let loud =
                flight.load.norm() > threshold || pair > threshold * core::f64::consts::SQRT_2;
            let into_wall = flight.load.dot(velocity) < 0.0;
            if !loud || !into_wall {
                if loud {
                    self.flags.set(LawFlags::GHOST);
                } else {
                    self.noise.add(&flight.load);
                }
                return V6::zeros();
            }
            self.begin_contact(flight, going_on, input, velocity, threshold);
        }
        let Some(contact) = going_on else {
            return V6::zeros();
        };
        self.flags.set(LawFlags::CONTACT);
        let only = self.latency_known.then_some(self.latency);
        contact.add(&flight.load, &flight.places, threshold, self.latency, only);
        self.choose_latency(contact);
        let cycle_s = self.plan.cycle_s;
        let places = &flight.places;
        let added = contact.onset_correction(self.latency, cycle_s)
            + contact.release_correction(&places.velocity[self.latency], self.latency, cycle_s);
        let (h, _) = contact.direction();
        let before = if begins {
            V6::zeros()
        } else {
            flight.load_before
        };
        let mut felt = (flight.load + before) * 0.5 - h * (added / cycle_s);
        let estimate = contact.estimate(self.latency);
        self.misfit = estimate.misfit;
        self.identified = [estimate.stiffness, estimate.damping];
        let reference = contact.reference(self.latency, cycle_s);
        let delay = (self.plan.chain.mean - self.latency as f64).max(0.0);
        let too_long = contact.lasts_too_long(flight.cycle, &reference, delay, cycle_s);
        if too_long || contact.is_over(flight.cycle, &reference, delay, cycle_s) {
            felt += self.end_contact(flight, contact, &reference, velocity, &felt);
            *going_on = None;
        }
        felt
    }

    #[inline(never)]
    fn begin_contact<S: Scalar>(
        &self,
        flight: &Flight,
        contact: &mut Option<Contact>,
        input: &LawInput<'_, S>,
        velocity: &V6,
        threshold: f64,
    ) {
        let mobility = flight.mobility(input);
        let load = -flight.load;
        let (h, bh) = identify::direction(&load, &mobility);
        *contact = Some(Contact::new(&Onset {
            cycle: flight.cycle,
            load: flight.load,
            velocity: *velocity,
            mobility,
            before: &flight.before,
            now: &flight.places,
            noise: self.noise.sigma(),
            threshold,
            stiffness: self.expected_stiffness(h.dot(&bh)),
            remembered: self.walls.of(&load),
            cycle_s: self.plan.cycle_s,
        }));
    }

    fn choose_latency(&mut self, contact: &Contact) {
        if self.latency_known {
            return;
        }
        let estimate = contact.estimate(self.latency);
        let closing = estimate.gradient.dot(&contact.velocity);
        let floor = bank::floor(
            self.noise.sigma(),
            closing,
            estimate.stiffness,
            1.0 / estimate.mass,
        );
        let best = contact.bank.choose(self.latency, floor);
        if best != self.latency {
            self.latency = best;
            self.solver = Solver::new(self.plan.chain.response(best));
        }
    }

    /// Ends a contact. The load that the guard adds, N.
    #[inline(never)]
    fn end_contact(
        &mut self,
        flight: &mut Flight,
        contact: &Contact,
        reference: &Reference,
        velocity: &V6,
        felt: &V6,
    ) -> V6 {
        let cycle_s = self.plan.cycle_s;
        let estimate = contact.estimate(self.latency);
        let (h, _) = contact.direction();
        let after = velocity + contact.mobility() * felt * cycle_s;
        let touched = f64::from(contact.bank.loads());
        let momentum = estimate.mass * reference.closing;
        let sigma = self.noise.sigma();
        let peak = reference.closing
            * ComplexField::sqrt(estimate.stiffness * estimate.mass).max(f64::MIN_POSITIVE);
        let ended = Ended {
            closing: reference.closing,
            after: estimate.gradient.dot(&after),
            restitution: reference.spring.map_or(1.0, |spring| spring.restitution),
            misfit: estimate.misfit,
            noise_misfit: sigma / (0.7 * peak),
            noise: sigma * cycle_s * ComplexField::sqrt(touched) / momentum,
        };
        self.rung = if ended.fits() {
            Rung::Identifying
        } else {
            Rung::Leading
        };
        if ended.fits() {
            let evidence = contact.evidence(self.latency);
            self.walls.keep(&h, self.latency, evidence, estimate);
        }
        // The model goes on from where the two craft would be, or the robot is, if it was not led there.
        let [lag] = reference.lags::<1>(flight.cycle as f64, cycle_s);
        flight.model = if self.leading.trust < 1.0 {
            flight.places.position[self.latency]
        } else {
            reference.position(flight.cycle as f64, &lag, cycle_s) + reference.push * contact.leaned
        };
        self.await_turn();
        flight.load = V6::zeros();
        self.turns = Turns::default();
        let missing =
            if let Some((target, flag)) = ended.corrected().filter(|_| self.settings.guard) {
                self.flags.set(flag);
                target - ended.after
            } else if ended.fits() {
                let rebound = contact.rebound(self.latency, &after);
                rebound.hidden(ended.closing, ended.after, ended.noise)
            } else {
                0.0
            };
        h * (missing * estimate.mass / cycle_s)
    }
}
