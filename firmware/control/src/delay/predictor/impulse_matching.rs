//! Impulse matching: how far to press into the contact, so that the impulse that is still to come leaves the
//! model with the momentum of the rebound; and how often an axis may reverse for that.
//!
//! The robot goes straight on for a dead time after the onset, and the model loses more momentum than the
//! contact would have taken. That impulse has to be given back while the contact lasts. A preload, a multiple μ
//! of the moves 1, ½, ¼ ... along the contact on top of the tracking moves, changes the depth from then on; μ
//! is found such that
//!
//! ```text
//! v − (1/m) Σ ∫ max(0, k δ + q δ² + c δ') dt  =  velocity of the reference at the end of the horizon
//! ```
//!
//! along the predicted depth δ. The earlier the preload, the less displacement it takes.

use super::V6;
use super::dynamic_matrix::Trajectory;
use super::reference::{Deviation, Reference};
use super::tuning::*;

/// The contact to come, along its direction.
pub(super) struct ImpulseMatching<'a> {
    /// Depth along the horizon without a preload, m; negative outside.
    pub(super) depth: &'a Trajectory,
    /// Change of the depth by a preload of 1, cycles.
    pub(super) preload: &'a Trajectory,
    /// k and q, N/m and N/m².
    pub(super) stiffness: f64,
    pub(super) stiffening: f64,
    pub(super) damping: f64,
    /// Velocity per impulse, 1/kg.
    pub(super) inverse_mass: f64,
    /// Velocity of the model now, and what it should have at the end of the horizon, m/s.
    pub(super) velocity: f64,
    pub(super) target: f64,
    pub(super) cycle_s: f64,
}

/// A preload that was tried, m/s, and the velocity beyond the target that it leaves, m/s.
#[derive(Clone, Copy)]
struct Trial {
    excess: f64,
    preload: f64,
}

impl Trial {
    /// The better of two: error, and a little for the size of the preload.
    fn better(self, new: Self) -> Self {
        let cost = |trial: Self| trial.excess.abs() + PRELOAD_COST * trial.preload.abs();
        if cost(new) < cost(self) { new } else { self }
    }
}

impl ImpulseMatching<'_> {
    /// Velocity at the end of the horizon beyond the target.
    #[inline(never)]
    fn trial(&self, preload: f64) -> Trial {
        // A spring, nearly always: its loop does without the product.
        let impulse = if self.stiffening == 0.0 {
            self.impulse::<false>(preload)
        } else {
            self.impulse::<true>(preload)
        };
        Trial {
            excess: self.velocity - impulse * self.inverse_mass - self.target,
            preload,
        }
    }

    /// Impulse to come, N·s.
    #[inline]
    fn impulse<const STIFFENING: bool>(&self, preload: f64) -> f64 {
        let drag = self.damping / self.cycle_s;
        let per_cycle = preload * self.cycle_s;
        let mut twice = 0.0;
        let ([depth, depths @ ..], [change, changes @ ..]) = (self.depth, self.preload);
        let mut before = depth + per_cycle * change;
        for (depth, change) in depths.iter().zip(changes) {
            let now = depth + per_cycle * change;
            if before > 0.0 || now > 0.0 {
                twice += self.force::<STIFFENING>(before, now, drag * (now - before));
            }
            before = now;
        }
        0.5 * self.cycle_s * twice
    }

    /// Twice the mean of max(0, k δ + q δ² + c δ') over a cycle in which the depth goes straight, partly at
    /// least in contact, N; `drag` is c δ'.
    #[inline]
    fn force<const STIFFENING: bool>(&self, before: f64, now: f64, drag: f64) -> f64 {
        let spring = |depth: f64| {
            if STIFFENING {
                (self.stiffness + self.stiffening * depth) * depth
            } else {
                self.stiffness * depth
            }
        };
        let last = spring(now) + drag;
        if before < 0.0 {
            // It begins within the cycle.
            return now / (now - before) * positive_part(drag, last);
        }
        positive_part(spring(before) + drag, last)
    }

    /// The best preload within ± `most`, m/s: the sign change of the excess is sought with growing steps.
    #[inline(never)]
    pub(super) fn solve(&self, most: f64) -> f64 {
        // More preload, more impulse, less velocity. The first step as if that were linear.
        let mut low = self.trial(0.0);
        let mut high = self.trial((low.excess * FIRST_STEP).clamp(-most, most));
        let mut best = low.better(high);
        let mut left = EVALUATIONS - 2;
        while low.excess * high.excess > 0.0 && left > ROOT_EVALUATIONS && high.preload.abs() < most
        {
            let slope = (high.excess - low.excess) / (high.preload - low.preload);
            let linear = if slope < 0.0 {
                high.preload - high.excess / slope
            } else {
                0.0
            };
            let far = STEP_GROWTH * high.preload;
            let onward = linear * high.preload > high.preload * high.preload;
            let next = if onward && linear.abs() < far.abs() {
                linear * STEP_MARGIN
            } else {
                far
            };
            low = high;
            high = self.trial(next.clamp(-most, most));
            best = best.better(high);
            left -= 1;
        }
        if low.excess * high.excess > 0.0 {
            return best.preload;
        }
        self.narrow((low, high), best, left)
    }

    /// False position with the stale end's value halved, within a sign change (Illinois method).
    fn narrow(
        &self,
        (mut low, mut high): (Trial, Trial),
        mut best: Trial,
        evaluations: usize,
    ) -> f64 {
        for _ in 0..evaluations {
            let width = high.excess - low.excess;
            if width == 0.0 {
                break;
            }
            let root = (low.preload * high.excess - high.preload * low.excess) / width;
            let new = self.trial(root);
            best = best.better(new);
            if new.excess.abs() <= MATCHED * (self.velocity.abs() + self.target.abs()) {
                break;
            }
            if new.excess * high.excess < 0.0 {
                low = high;
            } else {
                low.excess *= 0.5;
            }
            high = new;
        }
        best.preload
    }
}

/// Twice the mean of the positive part of what goes straight from one value to another.
fn positive_part(first: f64, last: f64) -> f64 {
    match (first > 0.0, last > 0.0) {
        (true, true) => first + last,
        (true, false) => first * first / (first - last),
        (false, true) => last * last / (last - first),
        (false, false) => 0.0,
    }
}

/// Which axes have reversed in this contact: each may do so once, because each reversal costs the robot a
/// pause.
///
/// An axis may reverse when the reference does, half a pause and a delay ahead, or when impulse matching asks
/// for a clear retreat; then it stays reversed until the contact is over. Noise around zero, or the
/// first estimate of a contact, would otherwise make the robot stand still twice.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reversals {
    reversed: [bool; 6],
    /// The contact was found to be damped: the robot has to retreat at once, and may reverse as often as it
    /// likes. The decision stays until the contact is over: an axis that has reversed must not be turned back
    /// by an estimate that wavers.
    free: bool,
}

impl Reversals {
    /// The command with no more than one reversal, `since` cycles after the onset and with the
    /// reference as it will be when the robot answers, at the soonest; `sure` if that time is known.
    pub(super) fn allow(
        &mut self,
        command: &V6,
        reference: &Reference,
        then: &Deviation,
        (since, sure): (f64, bool),
        cycle_s: f64,
    ) -> V6 {
        let contact = reference.contact.as_ref();
        let damped = contact.is_some_and(|contact| contact.zeta > FREE_REVERSAL_DAMPING);
        self.free |= damped && sure;
        if damped && sure {
            return onward(command, reference);
        }
        if self.free {
            return *command;
        }
        let before = reference.velocity;
        let later = before - reference.push * then.velocity;
        let duration = (reference.end(cycle_s) - reference.onset).max(1.0);
        let believable = since > RETREAT_CYCLES && since > RETREAT_PART * duration;
        let mut allowed = *command;
        for i in 0..6 {
            let size = before[i].abs();
            if size < AXIS_SHARE * before.norm() {
                continue;
            }
            let sign = if before[i] > 0.0 { 1.0 } else { -1.0 };
            let u = command[i] * sign;
            let may = later[i] * sign <= 0.0 || (u < -RETREAT_SPEED * size && believable);
            let Some(reversed) = self.reversed.get_mut(i) else {
                continue;
            };
            *reversed |= may && u < 0.0;
            let least = (REVERSAL_SPEED * size).max(REVERSAL_SPEED_M_S);
            let kept = if *reversed {
                u.min(-least)
            } else {
                u.max(least)
            };
            allowed[i] = kept * sign;
        }
        allowed
    }
}

/// For a damped contact: no axis reverses that goes on in its direction afterwards. It would pause twice
/// for a retreat that the others can make.
fn onward(command: &V6, reference: &Reference) -> V6 {
    let before = reference.velocity;
    let after = before - reference.push * ((1.0 + reference.restitution()) * reference.closing);
    let mut allowed = *command;
    for i in 0..6 {
        let goes_on =
            after[i] / before[i] > ONWARD_PART && before[i].abs() > AXIS_SHARE * before.norm();
        if goes_on && allowed[i] * before[i] < 0.0 {
            allowed[i] = REVERSAL_SPEED * before[i];
        }
    }
    allowed
}
