//! One contact, from its onset to its end: what is identified of it, and the momentum that it gives.

use super::bank::{Bank, Hypothesis, Places};
use super::identify::{Estimate, Evidence, Expected, direction};
use super::rebound::{Measured, Rebound};
use super::reference::{Reference, Spring};
use super::{LATENCIES, M6, V6};

/// Share of the past in the direction of the load, per cycle.
const DIRECTION_KEEPS: f64 = 0.9;
/// Error of a load beside its noise, as a part of the expected peak: the contact is not quite a
/// spring.
const MODEL_ERROR: f64 = 0.003;
/// Quiet cycles after which a contact is over.
const QUIET: u32 = 4;
/// Earliest place of the touch before the first load, cycles, beside noise.
const LATEST_ONSET: f64 = 8.0;

/// A contact that is going on.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    pub(super) bank: Bank,
    /// Direction of the load: running sum.
    loads: V6,
    mobility: M6,
    /// Velocity of the model before it.
    pub(super) velocity: V6,
    /// Cycle of the first load, where the robot was then, and the load.
    pub(super) begin: usize,
    places: Places,
    /// Impulse along the contact that the model got for the first load, N·s, and what was added to
    /// make it that of the contact since the touch.
    onset_felt: f64,
    onset_added: f64,
    /// Longest time from the touch to the first load, cycles.
    latest: f64,
    quiet: u32,
    /// The last load that stood out, along the contact, N.
    last: f64,
    noise: f64,
    stiffness: f64,
    /// Way that the commands have leaned into it, m.
    pub(super) leaned: f64,
}

/// What a new contact begins with.
pub(super) struct Onset<'a> {
    pub(super) cycle: usize,
    pub(super) load: V6,
    pub(super) velocity: V6,
    pub(super) mobility: M6,
    pub(super) before: &'a [V6; LATENCIES],
    pub(super) now: &'a Places,
    /// Standard deviation of a load and the least one that stands out, N.
    pub(super) noise: f64,
    pub(super) threshold: f64,
    /// Expected stiffness, N/m.
    pub(super) stiffness: f64,
    pub(super) remembered: Option<(usize, &'a Evidence)>,
    pub(super) cycle_s: f64,
}

impl Contact {
    pub(super) fn new(onset: &Onset<'_>) -> Self {
        let loads = -onset.load;
        let (h, bh) = direction(&loads, &onset.mobility);
        let closing = h.dot(&onset.velocity).max(0.0);
        let expected = expected(onset.stiffness, onset.noise, closing, (h, bh));
        let travel = closing * onset.cycle_s;
        let deviation =
            (onset.stiffness * travel / 3.5).max(1e-6) + onset.threshold.min(onset.load.norm());
        let bank = Bank::new(
            onset.before,
            onset.now,
            &expected,
            (closing, deviation),
            onset.remembered,
        );
        let per_cycle = (onset.stiffness * travel).max(f64::MIN_POSITIVE);
        Self {
            bank,
            loads,
            mobility: onset.mobility,
            velocity: onset.velocity,
            begin: onset.cycle,
            places: *onset.now,
            onset_felt: 0.5 * load_along(&onset.load, &h) * onset.cycle_s,
            onset_added: 0.0,
            latest: 1.0 + (onset.threshold / per_cycle).min(LATEST_ONSET - 1.0),
            quiet: 0,
            last: 0.0,
            noise: onset.noise,
            stiffness: onset.stiffness,
            leaned: 0.0,
        }
    }

    /// A cycle's load, N.
    pub(super) fn add(
        &mut self,
        load: &V6,
        places: &Places,
        threshold: f64,
        latency: usize,
        only: Option<usize>,
    ) {
        if load.norm() < threshold {
            self.quiet += 1;
            return;
        }
        self.quiet = 0;
        self.loads = self.loads * DIRECTION_KEEPS - load;
        let (h, bh) = self.direction();
        // What does not fit so far is an error that the next fit has to expect.
        let error = self.estimate(latency).error;
        let noise = error.max(self.noise);
        let closing = h.dot(&self.velocity);
        let expected = expected(self.stiffness, noise, closing, (h, bh));
        self.last = load_along(load, &h);
        let known = (&expected, &self.velocity);
        self.bank.add(places, self.last, known, only);
    }

    /// Impulse along the contact (N·s) by which a trapezoid from the last load that stood out to this
    /// cycle's, which does not, is too large: the contact ended in between.
    pub(super) fn release_correction(&self, velocity: &V6, latency: usize, cycle_s: f64) -> f64 {
        if self.quiet != 1 || self.last <= 0.0 {
            return 0.0;
        }
        let estimate = self.estimate(latency);
        let leaving = -estimate.gradient.dot(velocity);
        if leaving <= 0.0 {
            return 0.0;
        }
        let left = (self.last / (estimate.stiffness * leaving)).min(cycle_s);
        0.5 * self.last * (left - cycle_s)
    }

    /// What is known of the contact, for the next one with the same wall.
    pub(super) fn evidence(&self, latency: usize) -> Evidence {
        let mut evidence = self.bank.of[latency.min(LATENCIES - 1)].evidence.clone();
        evidence.end(self.estimate(latency).gradient.dot(&self.velocity));
        evidence
    }

    /// What all loads say about the rebound, for a velocity after it.
    pub(super) fn rebound(&self, latency: usize, after: &V6) -> Rebound {
        let (h, bh) = self.direction();
        let Hypothesis { evidence, estimate } = &self.bank.of[latency.min(LATENCIES - 1)];
        let sigma = estimate.error.max(self.noise);
        let expected = expected(self.stiffness, sigma, h.dot(&self.velocity), (h, bh));
        Rebound::new(&Measured {
            evidence,
            estimate,
            expected: &expected,
            before: &self.velocity,
            after,
            loads: f64::from(self.bank.loads()),
            noise: self.noise / h.norm(),
        })
    }

    /// Direction of the load with a force part of 1, and velocity per impulse along it.
    pub(super) fn direction(&self) -> (V6, V6) {
        direction(&self.loads, &self.mobility)
    }

    /// Velocity of the axes per impulse on them.
    pub(super) fn mobility(&self) -> &M6 {
        &self.mobility
    }

    /// The contact as identified at a latency.
    pub(super) fn estimate(&self, latency: usize) -> &Estimate {
        &self.bank.of[latency.min(LATENCIES - 1)].estimate
    }

    /// The ideal contact from the touch on.
    pub(super) fn reference(&self, latency: usize, cycle_s: f64) -> Reference {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(1e-9);
        let since = self.since_touch(latency, cycle_s);
        let place = self.places.position[latency.min(LATENCIES - 1)];
        Reference {
            touch: self.begin as f64 - since,
            position: place - self.velocity * (since * cycle_s),
            velocity: self.velocity,
            push: estimate.push,
            closing,
            spring: Some(Spring::new(
                estimate.stiffness,
                estimate.damping,
                estimate.mass,
            )),
        }
    }

    /// Time from the touch to the first load, cycles.
    fn since_touch(&self, latency: usize, cycle_s: f64) -> f64 {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(1e-9);
        let place = &self.places.position[latency.min(LATENCIES - 1)];
        let depth = estimate.gradient.dot(place) - estimate.wall;
        (depth / (closing * cycle_s)).clamp(0.0, self.latest)
    }

    /// Impulse along the contact (N·s) that is still to be added for the time from the touch to the
    /// first load: the samples see a trapezoid there, the craft feel ∫ (k v t + c v) dt.
    pub(super) fn onset_correction(&mut self, latency: usize, cycle_s: f64) -> f64 {
        let estimate = self.estimate(latency);
        let closing = estimate.gradient.dot(&self.velocity).max(0.0);
        let t = self.since_touch(latency, cycle_s) * cycle_s;
        let impulse = (estimate.damping + 0.5 * estimate.stiffness * t) * closing * t;
        // No more than the first load allows, whatever is identified.
        let most = self.onset_felt.abs() * self.latest;
        let wanted = (impulse - self.onset_felt).clamp(-most, most);
        let step = wanted - self.onset_added;
        self.onset_added = wanted;
        step
    }

    /// Whether it is over at a cycle.
    pub(super) fn is_over(
        &self,
        cycle: usize,
        reference: &Reference,
        delay: f64,
        cycle_s: f64,
    ) -> bool {
        let late = cycle as f64 > reference.end(cycle_s);
        self.quiet >= QUIET && (late || f64::from(self.quiet) >= delay + 6.0)
    }

    /// Whether it lasts longer than any that was identified could.
    pub(super) fn lasts_too_long(
        &self,
        cycle: usize,
        reference: &Reference,
        delay: f64,
        cycle_s: f64,
    ) -> bool {
        let duration = reference.end(cycle_s) - reference.touch;
        let most = 2.2 * duration + delay + 0.05 / cycle_s;
        (cycle - self.begin) as f64 > most
    }
}

/// λ of a load along a direction, N.
pub(super) fn load_along(load: &V6, h: &V6) -> f64 {
    -load.dot(h) / h.norm_squared()
}

fn expected(stiffness: f64, noise: f64, closing: f64, (h, bh): (V6, V6)) -> Expected {
    let inverse_mass = h.dot(&bh).max(1e-9);
    let peak = closing.abs() * nalgebra::ComplexField::sqrt(stiffness / inverse_mass);
    let part = MODEL_ERROR * peak;
    Expected {
        stiffness,
        sigma: nalgebra::ComplexField::sqrt(noise * noise + part * part).max(1e-9),
        direction: h,
        mobility: bh,
    }
}
