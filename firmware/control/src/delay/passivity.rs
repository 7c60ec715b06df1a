//! Time-domain passivity: an observer counts the energy that the loop makes, a controller takes it
//! out of the model again.
//!
//! ```text
//! E += F (v_exec − v_model) Ts        while E < 0: the model is damped by −E
//! ```
//!
//! De Stefano, Balachandran and Secchi, "A passivity-based approach for simulating satellite
//! dynamics with robots: discrete-time integration and time-delay compensation", IEEE Trans. Robot.
//! 36 (2020) 189. F v_exec is what the wall does on the robot, from measured force and measured
//! motion; F v_model is what the model takes from it. Their difference is energy that nobody paid.
//!
//! Choices that the equation leaves open:
//! - One observer per contact, along its direction (`contact`). It starts anew at each
//!   contact, so that what a damped contact left over does not pay for the next one.
//! - The work on the robot is the trapezoidal sum of force over measured motion, the model's part
//!   the exact change of its kinetic energy along the contact: the integrator's own error is
//!   counted, not assumed.
//! - A cycle takes away at most `largest_share` of the model's speed. Without this bound the model
//!   stops before the robot has turned, and stays: the energy that the wall still holds can only
//!   come back while the model moves out.
//!
//! It can only remove energy. The rebound of an elastic contact comes out right; force, duration
//! and the motion in between do not. A contact with damping ends too slow or does not end: what the wall
//! really dissipates is counted as energy that the model may not have.

use super::contact::{Along, ContactLine, LATENCIES, saturated};
use super::status::{LawFlags, LawStatus};
use super::{DelaySettings, LawInput};
use crate::frames::Wrench;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Ranges in which energy per mass, mm²/s², speed, mm/s, and acceleration, mm/s², stay.
const LARGEST_ENERGY: f64 = 1e8;
const FASTEST_MM_S: f64 = 1e4;
const LARGEST_MM_S2: f64 = 1e5;
/// Likewise, motion in a cycle, mm.
const LONGEST_MM: f64 = 1e2;
/// Largest force that damps, N.
const LARGEST_N: f64 = 1e6;

crate::described! {
/// Settings of the passivity observer and controller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct PassivitySettings {
    /// Force from which a contact counts, N: beyond the sensor's noise.
    pub threshold_n: f64,
    /// Part of the model's speed that a cycle takes away at most.
    pub largest_share: f64,
}
}

impl Default for PassivitySettings {
    fn default() -> Self {
        Self {
            threshold_n: 1.0,
            largest_share: 0.3,
        }
    }
}

impl PassivitySettings {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let threshold = self.threshold_n;
        in_range("delay.passivity.threshold_n", threshold, 0.01, 1e3)?;
        let share = self.largest_share;
        in_range("delay.passivity.largest_share", share, 0.01, 0.9)
    }
}

/// Observer and controller, as a law or beside one.
#[derive(Clone, Debug)]
pub struct Passivity<S: Scalar> {
    line: ContactLine<S>,
    ts: S,
    share_kept: S,
    /// Energy per mass that the loop has left over, mm²/s²; negative: it has made some.
    energy: S,
    /// Acceleration of the last cycle by the measured force, mm/s².
    last_pull: S,
    /// What the model took in the last cycles, newest first: it is counted together with what the
    /// robot was paid, and that is reported late.
    taken: [S; LATENCIES],
    latency: usize,
    damped: bool,
}

impl<S: Scalar> Passivity<S> {
    /// No contact yet; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let own = &settings.passivity;
        Self {
            line: ContactLine::new(own.threshold_n, &settings.actuator),
            ts: S::of(cycle_s),
            share_kept: S::of(1.0 - own.largest_share),
            energy: S::zero(),
            last_pull: S::zero(),
            taken: [S::zero(); LATENCIES],
            latency: settings.actuator.feedback_latency_cycles.into(),
            damped: false,
        }
    }

    /// The wrench with the damping that passivity asks for; `felt` is what the model would feel
    /// without it.
    pub fn condition(&mut self, input: &LawInput<'_, S>, felt: Wrench<S>) -> Wrench<S> {
        self.damped = false;
        let Some(along) = self.line.update(input) else {
            return felt;
        };
        let to_mm = S::of(1e3);
        let velocity = saturated(along.velocity * to_mm, FASTEST_MM_S);
        let pull = self.pull(self.line.load(&felt), &along);
        let after = saturated(velocity + pull * self.ts, FASTEST_MM_S);
        self.observe(&along, velocity, after);
        self.line.close_when_quiet();
        let Some(slower) = self.damp(after) else {
            return felt;
        };
        // A push that cannot move the model cannot damp it.
        if along.mobility <= S::of(1e-8) {
            return felt;
        }
        let (wanted, most) = ((slower - after) / self.ts, S::of(LARGEST_N));
        // Asked before it is divided: in fixed point the quotient would overflow.
        let force = if wanted.abs() * S::of(1e-3) < along.mobility * most {
            wanted / along.mobility * S::of(1e-3)
        } else if wanted < S::zero() {
            -most
        } else {
            most
        };
        felt + self.line.wrench(force)
    }

    /// What it knows: contact and whether it damps in this cycle.
    pub fn status(&self) -> LawStatus {
        let mut status = self.line.status();
        if self.damped {
            status.flags.set(LawFlags::GUARD_PASSIVE);
        }
        status
    }

    /// Acceleration along the contact by a force, mm/s².
    fn pull(&self, load: S, along: &Along<S>) -> S {
        // Small masses: the product must stay within fixed point before it is limited.
        let load = saturated(load, 1e5);
        saturated(load * along.mobility, LARGEST_MM_S2 * 1e-3) * S::of(1e3)
    }

    /// E += what the wall did on the robot − what the model took.
    fn observe(&mut self, along: &Along<S>, velocity: S, after: S) {
        let half = S::of(0.5);
        let pull = self.pull(along.load_then, along);
        if along.opened {
            self.energy = S::zero();
            self.last_pull = S::zero();
            self.taken = [S::zero(); LATENCIES];
        }
        let moved = saturated(along.moved * S::of(1e3), LONGEST_MM);
        let paid = (pull + self.last_pull) * half * moved;
        self.last_pull = pull;
        self.taken.rotate_right(1);
        self.taken[0] = (after - velocity) * (after + velocity) * half;
        let taken = self.taken[self.latency.min(LATENCIES - 1)];
        self.energy = saturated(self.energy + paid - taken, LARGEST_ENERGY);
    }

    /// The speed that is left when the energy that was made is taken out again, mm/s.
    fn damp(&mut self, after: S) -> Option<S> {
        if self.energy >= S::zero() || !self.line.is_open() {
            return None;
        }
        let half = S::of(0.5);
        let square = after * after;
        let left = (square + self.energy + self.energy).max(S::zero()).sqrt();
        let speed = left.max(after.abs() * self.share_kept);
        self.energy += (square - speed * speed) * half;
        self.damped = true;
        Some(if after < S::zero() { -speed } else { speed })
    }
}
