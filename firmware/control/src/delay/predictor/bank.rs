//! How old the reported pose is: one identification for each number of cycles, and which of them
//! fits the loads best.

use super::identify::{Estimate, Evidence, Expected};
use super::{LATENCIES, V6};
use nalgebra::ComplexField;

/// Loads before the bank may decide.
const FIRST_LOADS: u32 = 3;
/// By how much a rival must be better.
const CLEARLY: f64 = 2.0;

/// The identification at one latency.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub(super) evidence: Evidence,
    pub(super) estimate: Estimate,
}

/// All of them.
#[derive(Clone, Debug)]
pub(super) struct Bank {
    pub(super) of: [Hypothesis; LATENCIES],
    loads: u32,
}

/// Where the robot is, at each latency.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    pub(super) position: [V6; LATENCIES],
    pub(super) velocity: [V6; LATENCIES],
    /// A pause ended within the last cycle.
    pub(super) resumed: [bool; LATENCIES],
}

impl Bank {
    /// A new contact: it began between the places before and now, with a closing velocity (m/s); there
    /// is no force there, to a deviation (N).
    pub(super) fn new(
        before: &[V6; LATENCIES],
        now: &Places,
        expected: &Expected,
        (closing, deviation): (f64, f64),
        remembered: Option<(usize, &Evidence)>,
    ) -> Self {
        let hypothesis = |l: usize| {
            let middle = (before[l] + now.position[l]) * 0.5;
            let mut evidence = Evidence::new(middle);
            if let Some((latency, known)) = remembered
                && latency == l
            {
                evidence = known.clone();
            }
            evidence.begin(&middle, closing, deviation, expected.sigma);
            let estimate = evidence.solve(expected, closing);
            Hypothesis { evidence, estimate }
        };
        Self {
            of: core::array::from_fn(hypothesis),
            loads: 0,
        }
    }

    /// A load λ, N, in a contact that began with a velocity of the axes. `only` one hypothesis is worth
    /// the work when the latency is known.
    pub(super) fn add(
        &mut self,
        places: &Places,
        load: f64,
        (expected, before): (&Expected, &V6),
        only: Option<usize>,
    ) {
        self.loads += 1;
        for (l, hypothesis) in self.of.iter_mut().enumerate() {
            if places.resumed[l] || only.is_some_and(|only| only != l) {
                continue;
            }
            let Hypothesis { evidence, estimate } = hypothesis;
            let (position, velocity) = (&places.position[l], &places.velocity[l]);
            let gradient = estimate.gradient;
            evidence.add(position, gradient.dot(&(velocity - before)), load);
            *estimate = evidence.solve(expected, gradient.dot(before));
        }
    }

    /// The latency to believe, given the present one and the error of a load that means nothing.
    pub(super) fn choose(&self, present: usize, floor_n: f64) -> usize {
        if self.loads < FIRST_LOADS {
            return present;
        }
        let floor = f64::from(self.loads) * floor_n * floor_n;
        let cost = |l: usize| self.of[l].estimate.rest + floor;
        let best = (0..LATENCIES).fold(present, |a, b| if cost(b) < cost(a) { b } else { a });
        if cost(present) > CLEARLY * cost(best) {
            best
        } else {
            present
        }
    }

    /// Loads taken.
    pub(super) fn loads(&self) -> u32 {
        self.loads
    }
}

/// Error of a load that means nothing, N: of noise, and a small part of the expected peak.
pub(super) fn floor(noise: f64, closing: f64, stiffness: f64, inverse_mass: f64) -> f64 {
    let peak = closing * ComplexField::sqrt(stiffness / inverse_mass.max(1e-9));
    let (noise, part) = (1.5 * noise, 0.0002 * peak);
    ComplexField::sqrt(noise * noise + part * part)
}
