//! The energy bound: a contact gives back no more than it took, whatever a law believes.
//!
//! The work of the felt wrench w on both spacecraft together is the exact change of their kinetic energy: with v
//! the velocity of K seen from Q at M, and B the inverse inertia of the pair,
//!
//! ```text
//! ΔE = ½ (v + B w Ts)ᵀ B⁻¹ (v + B w Ts) − ½ vᵀ B⁻¹ v = w·v Ts + ½ wᵀ B w Ts²
//! ```
//!
//! Summed since the touch this is what the mechanism has given; a passive one has never given anything, in no
//! direction and of no shape. A wrench with which it would have given more than [`SLACK`] of what it took is scaled
//! down until it has given nothing: the root of a quadratic that has one between 0 and 1. Neither a contact
//! model nor a delay is needed, and no position feedback.
//!
//! It bounds energy, not momentum: what the scaled wrench lacks is in the trace (`unaccounted_impulse`).

use super::LawInput;
use crate::dynamics::relative_velocity;
use crate::frames::Wrench;
use crate::scalar::Scalar;
use core::marker::PhantomData;
use nalgebra::ComplexField;

/// Energy that may be given back beyond what was taken, as a part of it: what noise and samples make of a force.
/// ↑ lets energy through; ↓ acts on rebounds that are right.
const SLACK: f64 = 0.008;
/// Cycles without a load after which a contact is over: longer than any law takes to end one (`smith`: 64).
const QUIET_CYCLES: u32 = 72;
/// Forgetting factor of the work before the touch, per cycle: ten cycles in which a slow contact grows to its
/// threshold.
const EARLIER: f64 = 0.9;
/// Arm that makes a torque a force, m.
const ARM_M: f64 = 0.3;
/// Load that does no work worth counting, N and N·m.
const LEAST_LOAD: f64 = 1e-3;
/// Size of the wrench whose answer is asked for, N and N·m: at the ends of all ranges (10⁻³ kg·m² at a lever of 10³ m)
/// the answer to a larger one would leave fixed point.
const PROBE_LOAD: f64 = 1e-2;

/// The ledger of a contact. It counts in f64 whatever the scalar of the cycle is: energies of light and heavy
/// spacecraft are too far apart for fixed point.
#[derive(Clone, Debug)]
pub(super) struct EnergyBound<S: Scalar> {
    cycle_s: f64,
    /// Force from which a contact counts, N.
    threshold_n: f64,
    /// Work on the spacecraft since the touch, and the least that it has been, J.
    work: f64,
    least: f64,
    /// What earlier contacts gave beyond what they took, J: the next one takes it back.
    debt: f64,
    /// Cycles since the last load; none before the first.
    quiet: Option<u32>,
    /// The wrench was scaled down in this cycle.
    pub(super) acts: bool,
    scalar: PhantomData<S>,
}

impl<S: Scalar> EnergyBound<S> {
    /// No contact yet; a contact counts from `threshold_n`, the cycle in s.
    pub(super) fn new(threshold_n: f64, cycle_s: f64) -> Self {
        Self {
            cycle_s,
            threshold_n,
            work: 0.0,
            least: 0.0,
            debt: 0.0,
            quiet: None,
            acts: false,
            scalar: PhantomData,
        }
    }

    /// The wrench that the spacecraft may feel of `felt`, at M in axes of M.
    pub(super) fn bounded(&mut self, input: &LawInput<'_, S>, felt: Wrench<S>) -> Wrench<S> {
        self.acts = false;
        self.follow(&input.wrench.get());
        let (linear, quadratic) = self.work_of(input, &felt);
        let given = self.work + linear + quadratic;
        if self.quiet.is_none() {
            // A load that still grows to the threshold belongs to the contact.
            self.work = given * EARLIER;
            self.least = self.work.min(0.0);
            return felt;
        }
        if given <= -self.least * SLACK {
            self.account(given);
            return felt;
        }
        self.acts = true;
        let share = largest_share(linear, quadratic, -self.work);
        self.account(self.work + (linear + quadratic * share) * share);
        felt * S::of(share)
    }

    /// Whether a contact goes on.
    fn follow(&mut self, [x, y, z, a, b, c]: &[f64; 6]) {
        let largest = |parts: [&f64; 3]| parts.into_iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let load = largest([x, y, z]).max(largest([a, b, c]) / ARM_M);
        let loaded = load >= self.threshold_n;
        self.quiet = match self.quiet {
            Some(_) if loaded => Some(0),
            None if loaded => {
                self.work += self.debt;
                Some(0)
            }
            Some(quiet) if quiet < QUIET_CYCLES => Some(quiet + 1),
            Some(_) => {
                self.debt = self.work.max(0.0);
                (self.work, self.least) = (0.0, 0.0);
                None
            }
            None => None,
        };
    }

    fn account(&mut self, work: f64) {
        self.work = work;
        self.least = self.least.min(work);
    }

    /// w·v Ts and ½ wᵀ B w Ts², J.
    fn work_of(&self, input: &LawInput<'_, S>, felt: &Wrench<S>) -> (f64, f64) {
        let parts = felt.get();
        let size = parts.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        if size < LEAST_LOAD {
            return (0.0, 0.0);
        }
        let along = |motion: [f64; 6]| parts.iter().zip(motion).map(|(w, v)| w * v).sum::<f64>();
        // In axes of the model's K, to which the wrench is applied: the robot's own attitude is late.
        let (k, q) = (&input.state.k, &input.state.q);
        let relative = relative_velocity(k, q);
        let in_c = q.c_from_body.rotation * relative.linear;
        let linear = (k.c_from_body.rotation.inverse() * in_c).map(S::get);
        let angular = relative.angular.map(S::get);
        let before = [
            linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
        ];
        let scale = PROBE_LOAD / size;
        let probe = Wrench::of(&parts.map(|part| part * scale));
        let answer = input.bodies.mobility(input.state, &probe).get();
        let change = answer.map(|v| v / scale * self.cycle_s);
        let ts = self.cycle_s;
        (along(before) * ts, 0.5 * along(change) * ts)
    }
}

/// The largest share α of a wrench with α a + α² b ≤ `room`, for a wrench that as a whole gives more; b ≥ 0.
fn largest_share(a: f64, b: f64, room: f64) -> f64 {
    if room <= 0.0 && a >= 0.0 {
        return 0.0;
    }
    let root = ComplexField::sqrt((a * a + 4.0 * b * room).max(0.0));
    // The form that does not cancel: for a ≥ 0, and for a < 0 where room may be negative.
    let share = if a >= 0.0 {
        2.0 * room / (a + root).max(f64::MIN_POSITIVE)
    } else {
        (root - a) / (2.0 * b).max(f64::MIN_POSITIVE)
    };
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// α a + α² b is the room that is left.
    #[test]
    fn the_share_leaves_no_more_than_the_room() {
        for (a, b, room) in [
            (1.0_f64, 0.5, 0.2_f64),
            (-1.0, 2.0, 0.1),
            (-1.0, 2.0, 0.0),
            (1.0, 0.0, 0.5),
            (1.0, 0.5, 0.0),
            (0.3, 0.4, -0.1),
            (-0.3, 0.4, -0.01),
            (4e5, 3e3, 2e5),
        ] {
            let share = largest_share(a, b, room);
            let given = share * (a + share * b);
            assert!((0.0..=1.0).contains(&share), "{a} {b} {room}: {share}");
            assert!(given <= room.max(0.0) + 1e-9, "{a} {b} {room}: {given}");
            assert!(
                room < 0.0 || given >= room - 1e-9 * a.abs(),
                "{a} {b} {room}"
            );
        }
    }
}
