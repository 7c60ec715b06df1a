//! A contact from its onset to its end: the momentum that it gives between samples; and contacts that are
//! remembered.
//!
//! A trapezoid of the measured loads is wrong where they begin and end, between two samples. Both pieces are
//! taken from the identified contact instead, and are bounded by the neighbouring load.

use super::contact_estimator::{
    Estimate, Hypothesis, Information, LatencyEstimator, Prior, direction,
};
use super::observer::{AtForce, Observer};
use super::reference::{Preload, Reference};
use super::restitution::{Outcome, RestitutionEstimate};
use super::stiffening::{Curve, Stiffening};
use super::tuning::*;
use super::{M6, V6};
use nalgebra::ComplexField;

/// A contact that is going on.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    pub(super) estimator: LatencyEstimator,
    /// Direction of the load: running sum.
    load_sum: V6,
    pub(super) mobility: M6,
    /// Velocity of the model before it.
    pub(super) velocity: V6,
    /// Cycle of the first load, and where the robot was then at each latency.
    first_cycle: usize,
    first_position: [V6; LATENCIES],
    /// Latency that was believed then, cycles.
    pub(super) first_latency: usize,
    /// Impulse along the contact that the model got for the first load, N·s, and what was added to
    /// make it that of the contact since the onset.
    onset_felt: f64,
    onset_added: f64,
    /// Longest time from the onset to the first load, cycles.
    longest_onset: f64,
    /// Cycles without a significant load.
    quiet: u32,
    /// The last significant load, along the contact, N.
    last: f64,
    noise: f64,
    stiffness: f64,
    delay_sigma_s: f64,
    cycle_s: f64,
    /// Displacement of the commands' preload so far.
    pub(super) preload: Preload,
    /// What the estimator's spring does not say, by the positions at a latency.
    stiffening: (usize, Stiffening),
    /// Error of a load that was expected at the onset, N.
    sigma: f64,
}

/// What a new contact begins with.
pub(super) struct Onset<'a> {
    pub(super) velocity: V6,
    pub(super) mobility: M6,
    /// Standard deviation of a load and the least significant one, N.
    pub(super) noise: f64,
    pub(super) threshold: f64,
    /// Expected stiffness, N/m.
    pub(super) stiffness: f64,
    /// Standard deviation of the robot's delay, s.
    pub(super) delay_sigma_s: f64,
    pub(super) remembered: Option<(usize, &'a Information)>,
    /// Latency that is believed, cycles.
    pub(super) latency: usize,
    pub(super) cycle_s: f64,
}

impl Contact {
    pub(super) fn new(observer: &Observer, onset: &Onset<'_>) -> Self {
        let load = &observer.load;
        let (h, bh) = direction(&-load, &onset.mobility);
        let closing = h.dot(&onset.velocity).max(0.0);
        let expected = (onset.stiffness, onset.noise, onset.delay_sigma_s);
        let prior = Prior::new(expected, closing, (h, bh));
        let travel = closing * onset.cycle_s;
        let estimator = LatencyEstimator::new(
            &observer.previous,
            &observer.at_force,
            &prior,
            (closing, travel, onset.threshold.min(load.norm())),
            onset.remembered,
        );
        let per_cycle = (onset.stiffness * travel).max(f64::MIN_POSITIVE);
        Self {
            estimator,
            load_sum: -load,
            mobility: onset.mobility,
            velocity: onset.velocity,
            first_cycle: observer.cycle,
            first_position: observer.at_force.position,
            first_latency: onset.latency,
            onset_felt: 0.5 * load_along(load, &h) * onset.cycle_s,
            onset_added: 0.0,
            longest_onset: 1.0 + (onset.threshold / per_cycle).min(EARLIEST_ONSET - 1.0),
            quiet: 0,
            last: 0.0,
            noise: onset.noise,
            stiffness: onset.stiffness,
            delay_sigma_s: onset.delay_sigma_s,
            cycle_s: onset.cycle_s,
            preload: Preload::default(),
            stiffening: (onset.latency, Stiffening::default()),
            sigma: prior.sigma,
        }
    }

    /// A cycle's load, N, if it is at least a threshold.
    pub(super) fn add(
        &mut self,
        load: &V6,
        at_force: &AtForce,
        threshold: f64,
        latency: usize,
        only: Option<usize>,
    ) {
        if load.norm() < threshold {
            self.quiet += 1;
            return;
        }
        self.quiet = 0;
        self.load_sum = self.load_sum * DIRECTION_FORGETTING - load;
        let direction = self.direction();
        self.last = load_along(load, &direction.0);
        // What does not fit so far is an error that the next fit has to expect.
        let prior = self.prior(direction, self.estimate(latency).error);
        let known = (&prior, &self.velocity);
        self.estimator.add(at_force, self.last, known, only);
        self.add_to_parabola(at_force, latency);
    }

    /// The last load, less that of the damping, at the way since the first one.
    fn add_to_parabola(&mut self, at_force: &AtForce, latency: usize) {
        if self.stiffening.0 != latency {
            self.stiffening = (latency, Stiffening::default());
        }
        let l = latency.min(LATENCIES - 1);
        let estimate = self.estimate(latency);
        let along = |motion: V6| estimate.gradient.dot(&motion);
        let way = along(at_force.position[l] - self.first_position[l]);
        let elastic = self.last - estimate.damping * along(at_force.velocity[l]);
        self.stiffening.1.add(way, elastic);
    }

    /// The stiffening of the contact, if it has one.
    pub(super) fn curve(&self, latency: usize) -> Option<Curve> {
        let estimate = self.estimate(latency);
        let origin = estimate
            .gradient
            .dot(&self.first_position[latency.min(LATENCIES - 1)]);
        self.stiffening.1.curve(estimate, origin, self.sigma)
    }

    /// What is expected of it, with h and Bh and the error of the present fit, N.
    fn prior(&self, (h, bh): (V6, V6), error: f64) -> Prior {
        let closing = h.dot(&self.velocity);
        let expected = (self.stiffness, error.max(self.noise), self.delay_sigma_s);
        Prior::new(expected, closing, (h, bh))
    }

    /// h and Bh: direction of the load with a force part of 1, and velocity per impulse along it.
    pub(super) fn direction(&self) -> (V6, V6) {
        direction(&self.load_sum, &self.mobility)
    }

    /// The contact as identified at a latency.
    pub(super) fn estimate(&self, latency: usize) -> &Estimate {
        &self.estimator.at(latency).estimate
    }

    /// The ideal contact from the onset on.
    pub(super) fn reference(&self, latency: usize) -> Reference {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(1e-9);
        let since = self.since_onset(latency);
        let first = self.first_position[latency.min(LATENCIES - 1)];
        let onset = (
            self.first_cycle as f64 - since,
            first - self.velocity * (since * self.cycle_s),
        );
        Reference::into_contact(estimate, onset, (self.velocity, closing))
    }

    /// Time from the onset to the first load, cycles.
    fn since_onset(&self, latency: usize) -> f64 {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(1e-9);
        let first = &self.first_position[latency.min(LATENCIES - 1)];
        let depth = estimate.gradient.dot(first) - estimate.surface;
        (depth / (closing * self.cycle_s)).clamp(0.0, self.longest_onset)
    }

    /// Impulse along the contact (N·s) that is still to be added for the time from the onset to the
    /// first load: the samples see a trapezoid there, the spacecraft feel ∫ (k v t + c v) dt.
    pub(super) fn onset_correction(&mut self, latency: usize) -> f64 {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(0.0);
        let t = self.since_onset(latency) * self.cycle_s;
        let impulse = (estimate.damping + 0.5 * estimate.stiffness * t) * closing * t;
        // No more than the first load allows, whatever is identified.
        let most = self.onset_felt.abs() * self.longest_onset;
        let wanted = (impulse - self.onset_felt).clamp(-most, most);
        let step = wanted - self.onset_added;
        self.onset_added = wanted;
        step
    }

    /// Impulse along the contact (N·s) by which a trapezoid from the last significant load to this
    /// cycle's, which is not, is too large: the contact ended in between.
    pub(super) fn release_correction(&self, velocity: &V6, latency: usize) -> f64 {
        if self.quiet != 1 || self.last <= 0.0 {
            return 0.0;
        }
        let estimate = self.estimate(latency);
        let leaving = -estimate.gradient.dot(velocity);
        if leaving <= 0.0 {
            return 0.0;
        }
        let left = (self.last / (estimate.stiffness * leaving)).min(self.cycle_s);
        0.5 * self.last * (left - self.cycle_s)
    }

    /// Whether it is over at a cycle, or lasts longer than any that was identified could; `delay` from a
    /// command to its execution, cycles.
    pub(super) fn is_over(&self, cycle: usize, reference: &Reference, delay: f64) -> bool {
        let end = reference.end(self.cycle_s);
        let late = cycle as f64 > end || f64::from(self.quiet) >= delay + QUIET_CYCLES_LATE;
        let longest =
            DURATION_LIMIT * (end - reference.onset) + delay + DURATION_MARGIN_S / self.cycle_s;
        (self.quiet >= QUIET_CYCLES && late) || (cycle - self.first_cycle) as f64 > longest
    }

    /// What is known of it, for the next one at the same place.
    pub(super) fn information(&self, latency: usize) -> Information {
        let mut information = self.estimator.at(latency).information.clone();
        information.end(self.estimate(latency).gradient.dot(&self.velocity));
        information
    }

    /// Its end, with a velocity of the axes after it, and with what noise (N) makes of its numbers.
    pub(super) fn outcome(
        &self,
        latency: usize,
        reference: &Reference,
        after: &V6,
        noise: f64,
    ) -> Outcome {
        let estimate = self.estimate(latency);
        let closing = reference.closing;
        let impedance = ComplexField::sqrt(estimate.stiffness * estimate.mass);
        let peak = closing * impedance.max(f64::MIN_POSITIVE);
        let loads = f64::from(self.estimator.loads());
        let momentum = estimate.mass * closing;
        Outcome {
            closing,
            after: estimate.gradient.dot(after),
            restitution: reference.restitution(),
            misfit: estimate.misfit,
            noise_misfit: noise / (MEAN_LOAD * peak),
            noise: noise * self.cycle_s * ComplexField::sqrt(loads) / momentum,
        }
    }

    /// What all its loads, with their noise (N), say about the restitution, for a velocity of the axes after it.
    pub(super) fn restitution(
        &self,
        latency: usize,
        after: &V6,
        noise: f64,
    ) -> RestitutionEstimate {
        let Hypothesis {
            information,
            estimate,
        } = self.estimator.at(latency);
        let direction = self.direction();
        let prior = self.prior(direction, estimate.error);
        let loads = f64::from(self.estimator.loads());
        let noise = noise / direction.0.norm();
        let velocities = (&self.velocity, after);
        RestitutionEstimate::new(information, estimate, &prior, velocities, (loads, noise))
    }
}

/// λ of a load along a direction, N.
fn load_along(load: &V6, h: &V6) -> f64 {
    -load.dot(h) / h.norm_squared()
}

/// A contact that was identified.
#[derive(Clone, Debug)]
struct Remembered {
    direction: V6,
    latency: usize,
    information: Information,
    estimate: Estimate,
}

/// The contact memory of a run: where one is expected, the robot turns before it feels it.
#[derive(Clone, Debug, Default)]
pub(super) struct ContactMemory {
    kept: [Option<Remembered>; REMEMBERED_CONTACTS],
    /// The slot that is given away next.
    next: usize,
}

impl ContactMemory {
    /// What is known of the contact that a load of this direction comes from.
    pub(super) fn of(&self, direction: &V6) -> Option<(usize, &Information)> {
        let same = |known: &&Remembered| cosine(&known.direction, direction) > SAME_CONTACT;
        let known = self.kept.iter().flatten().find(same)?;
        Some((known.latency, &known.information))
    }

    /// Keeps a contact in place of what was known of it.
    pub(super) fn keep(&mut self, contact: &Contact, latency: usize) {
        let (direction, _) = contact.direction();
        let same = |slot: &Option<Remembered>| {
            slot.as_ref()
                .is_none_or(|known| cosine(&known.direction, &direction) > SAME_CONTACT)
        };
        let index = self.kept.iter().position(same).unwrap_or(self.next);
        self.next = (index + 1) % REMEMBERED_CONTACTS;
        if let Some(slot) = self.kept.get_mut(index) {
            *slot = Some(Remembered {
                direction,
                latency,
                information: contact.information(latency),
                estimate: *contact.estimate(latency),
            });
        }
    }

    /// The contact that is coming, for a straight flight from a position at a cycle; the nearest of
    /// those within a horizon. One that should have been felt is forgotten.
    pub(super) fn ahead(
        &mut self,
        (cycle, position, velocity): (usize, &V6, &V6),
        horizon: f64,
        cycle_s: f64,
    ) -> Option<(Reference, Estimate)> {
        let mut nearest: Option<(f64, Estimate)> = None;
        for slot in &mut self.kept {
            let Some(known) = slot else { continue };
            let estimate = known.estimate;
            let closing = estimate.gradient.dot(velocity);
            if closing <= LEAST_CLOSING * velocity.norm() {
                continue;
            }
            let distance = estimate.surface - estimate.gradient.dot(position);
            let cycles = distance / (closing * cycle_s);
            if cycles < -MISSED_CONTACT {
                *slot = None;
            } else if cycles < horizon && nearest.is_none_or(|(best, _)| cycles < best) {
                nearest = Some((cycles, estimate));
            }
        }
        let (cycles, estimate) = nearest?;
        let onset = (
            cycle as f64 + cycles,
            position + velocity * (cycles * cycle_s),
        );
        let closing = estimate.gradient.dot(velocity);
        let reference = Reference::into_contact(&estimate, onset, (*velocity, closing));
        Some((reference, estimate))
    }
}

fn cosine(a: &V6, b: &V6) -> f64 {
    a.dot(b) / (a.norm() * b.norm()).max(f64::MIN_POSITIVE)
}
