//! The robot's delay after the approach, from how it turns in each contact.
//!
//! Straight and uniform motion says nothing about a delay: d more of it looks like a place that is
//! d v behind, and places change, because a way is lost at each reversal. What tells them apart is a
//! velocity that changes: with the twin's motion ẑ without feedback
//!
//! ```text
//! z − ẑ = x₀ − d ẑ' Ts        x₀ a constant from one reversal of an axis to the next
//! ```
//!
//! is solved for d over the braking before a reversal and the motion after it, all axes together. A
//! wrong length of the pause, which moves x₀ alone, is no error of d. Near the reversal itself the
//! robot may turn, or stand, while the twin does not: those samples are left out.

use super::flight::Flight;
use super::solver::Solver;
use super::twin::Axes;
use super::{Pilot, V6};
use crate::delay::status::LawFlags;

/// Share of the past that a place x₀ keeps per cycle, and that the products keep per contact.
const PLACE_KEEPS: f64 = 1.0 - 1.0 / 64.0;
const CONTACT_KEEPS: f64 = 0.6;
/// How fast the largest velocity of an axis is forgotten, per cycle.
const PEAK_KEEPS: f64 = 0.98;
/// Below this part of its largest velocity an axis is near a reversal.
const NEAR_REVERSAL: f64 = 0.4;
/// A change of the delay below this is not worth it; largest one after a contact; cycles.
const WORTH: f64 = 0.05;
const MOST: f64 = 2.0;
/// Cycles after a contact and the robot's delay until its motion is straight.
const SETTLES: f64 = 12.0;
/// A change within so many standard deviations of zero is shrunk to zero.
const DOUBT: f64 = 2.0;

/// Running means of each axis, and the products about them.
#[derive(Clone, Debug, Default)]
pub(super) struct Drift {
    means: [Mean; 6],
    /// Σ (residual · rate) and Σ rate², m² and m².
    product: f64,
    spread: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    peak: f64,
    weight: f64,
    residual: f64,
    rate: f64,
}

impl Drift {
    /// A cycle: measured position less the twin's without feedback (m), and the twin.
    #[inline(never)]
    pub(super) fn add(&mut self, residual: &V6, axes: &Axes, cycle_s: f64) {
        for (i, (mean, axis)) in self.means.iter_mut().zip(&axes.0).enumerate() {
            let rate = axis.velocity * cycle_s;
            mean.peak = (mean.peak * PEAK_KEEPS).max(rate.abs());
            if rate.abs() < NEAR_REVERSAL * mean.peak {
                mean.weight = 0.0;
                continue;
            }
            mean.weight = mean.weight * PLACE_KEEPS + 1.0;
            let (off, faster) = (residual[i] - mean.residual, rate - mean.rate);
            if mean.weight <= 1.0 {
                (mean.residual, mean.rate) = (residual[i], rate);
                continue;
            }
            mean.residual += off / mean.weight;
            mean.rate += faster / mean.weight;
            self.product += off * (rate - mean.rate);
            self.spread += faster * (rate - mean.rate);
        }
    }

    /// By how many cycles the robot is later than believed, as far as that stands out of the noise
    /// of a position (standard deviation, m). Asked once for each contact.
    fn late(&mut self, noise_m: f64) -> Option<f64> {
        self.product *= CONTACT_KEEPS;
        self.spread *= CONTACT_KEEPS;
        if self.spread <= 0.0 {
            return None;
        }
        let late = -self.product / self.spread;
        let variance = noise_m * noise_m / self.spread;
        let doubt = DOUBT * DOUBT * variance / (late * late).max(f64::MIN_POSITIVE);
        let late = (late * (1.0 - doubt).max(0.0)).clamp(-MOST, MOST);
        (late.abs() > WORTH).then_some(late)
    }

    /// The twin is so many cycles later now.
    fn shift(&mut self, late: f64) {
        self.product += late * self.spread;
        for mean in &mut self.means {
            mean.residual += late * mean.rate;
        }
    }
}

impl Pilot {
    /// A contact has ended: the robot's turn can be seen a delay from now.
    pub(super) fn await_turn(&mut self) {
        self.settling = (self.plan.chain.mean + SETTLES) as u32;
    }

    /// Follows the delay in free flight, once after each contact.
    pub(super) fn follow(&mut self, flight: &mut Flight) {
        if self.settling == 0 {
            return;
        }
        self.settling -= 1;
        if self.settling > 0 {
            return;
        }
        if let Some(late) = self.drift.late(self.approach.findings.noise_m) {
            let within = self.approach.follow(late);
            self.change_delay(flight, within);
            self.drift.shift(within);
            self.flags.set(LawFlags::DELAY_FOLLOWED);
            if self.approach.findings.at_bound {
                self.flags.set(LawFlags::DELAY_AT_BOUND);
            }
        }
    }

    /// A robot that is so many cycles later than believed.
    pub(super) fn change_delay(&mut self, flight: &mut Flight, late: f64) {
        self.plan.chain.shift(late);
        // The twin has gone straight for a while: it is so much further behind.
        flight
            .axes
            .shift(&(flight.axes.velocity() * (-late * self.plan.cycle_s)));
        self.solver = Solver::new(self.plan.chain.response(self.latency));
    }
}
