//! The exact bounce of a mass as observed with a perfect robot, for the tests of contacts.

use super::contact::{Contact, Onset};
use super::observer::{AtForce, Observer};
use super::tuning::*;
use super::{M6, V6};
use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
use crate::frames::Wrench;
use softdock_delay_plants::truth;

pub(super) const MASS: f64 = 500.0;
pub(super) const CLOSING: f64 = 0.005;
pub(super) const OMEGA: f64 = 21.0;
pub(super) const STIFFNESS: f64 = MASS * OMEGA * OMEGA;
/// Cycle of the first load, and where the surface is, m.
pub(super) const FIRST: usize = 50;
pub(super) const SURFACE: f64 = 0.3;

/// A motion, or a force, along the contact.
pub(super) fn x(value: f64) -> V6 {
    V6::ith(0, value)
}

/// Asserts that a number is within a fraction of the expected one.
#[track_caller]
pub(super) fn assert_near(found: f64, expected: f64, part: f64) {
    let apart = (found - expected).abs();
    assert!(apart <= part * expected.abs(), "{found} {expected}");
}

/// The contact at an instant.
pub(super) struct Instant {
    /// Depth, m.
    pub(super) depth: f64,
    /// Rate of the depth, m/s.
    pub(super) rate: f64,
    /// Load, N.
    pub(super) load: f64,
}

/// The exact motion of a mass into a spring and damper along x, seen by a pose that is as old as the force.
#[derive(Clone, Copy)]
pub(super) struct Bounce {
    pub(super) zeta: f64,
    /// q, N/m²: a load that grows faster than its depth.
    pub(super) stiffening: f64,
    /// Time from the onset to the first load, cycles.
    pub(super) phase: f64,
}

impl Bounce {
    /// Into a spring, with the first load `phase` cycles after the onset.
    pub(super) fn spring(phase: f64) -> Self {
        Self {
            zeta: 0.0,
            stiffening: 0.0,
            phase,
        }
    }

    /// At a time after the onset, s.
    pub(super) fn at(&self, t: f64) -> Instant {
        let truth = truth::Bounce::new(MASS, STIFFNESS, self.zeta, CLOSING);
        let (depth, rate, load) = (truth.displacement_m(t), truth.rate_m_s(t), truth.force_n(t));
        let more = if load > 0.0 {
            self.stiffening * depth * depth
        } else {
            0.0
        };
        Instant {
            depth,
            rate,
            load: load + more,
        }
    }

    pub(super) fn time(&self, cycle: usize) -> f64 {
        (cycle as f64 - FIRST as f64 + self.phase) * CYCLE_S
    }

    /// The observer in a cycle.
    pub(super) fn observer(&self, cycle: usize) -> Observer {
        let (spacecraft, wrench) = (Spacecraft::before_a_wall([0.0; 3]), Wrench::zero());
        let mut observer = Observer::new(&spacecraft.input(&wrench));
        let seen =
            |l: usize, earlier: usize| self.at(self.time(cycle + l) - CYCLE_S * earlier as f64);
        observer.cycle = cycle;
        observer.load = x(-seen(0, 0).load);
        observer.previous_load = x(-seen(0, 1).load);
        observer.previous = core::array::from_fn(|l| x(SURFACE + seen(l, 1).depth));
        observer.at_force = AtForce {
            position: core::array::from_fn(|l| x(SURFACE + seen(l, 0).depth)),
            velocity: core::array::from_fn(|l| x(seen(l, 0).rate)),
            resumed: [false; LATENCIES],
        };
        observer
    }

    /// A contact that begins in cycle [`FIRST`], with loads from a threshold on, N.
    pub(super) fn begun(&self, threshold: f64) -> Contact {
        let onset = Onset {
            velocity: x(CLOSING),
            mobility: M6::identity() / MASS,
            noise: 1e-4,
            threshold,
            stiffness: 1.5e5,
            delay_sigma_s: 0.0,
            remembered: None,
            latency: 0,
            cycle_s: CYCLE_S,
        };
        Contact::new(&self.observer(FIRST), &onset)
    }

    /// The same contact after the loads of so many cycles.
    pub(super) fn followed(&self, threshold: f64, cycles: usize) -> Contact {
        let mut contact = self.begun(threshold);
        for cycle in FIRST..FIRST + cycles {
            let observer = self.observer(cycle);
            contact.add(&observer.load, &observer.at_force, threshold, 0, Some(0));
        }
        contact
    }
}
