//! The fallback law: a second-order lead that knows nothing of the contact, for contacts that are not
//! understood.
//!
//! ```text
//! v_cmd = v + τ v' + ½ τ² v''
//! ```
//!
//! as in the law [`lead`](crate::delay::lead), with the model's velocity during the contact. The law passes
//! from the one to the other over [`BLEND_CYCLES`], and only between contacts, where both are the model's
//! velocity.

use super::V6;
use super::dynamic_matrix::{Command, ControlProblem, limited};
use super::tuning::*;

/// The lead, and how much of the command is the predictor's.
#[derive(Clone, Debug)]
pub(super) struct Fallback {
    /// 1: the predictor; 0: the lead.
    pub(super) trust: f64,
    last: V6,
    slope: V6,
}

impl Fallback {
    pub(super) fn new() -> Self {
        Self {
            trust: 1.0,
            last: V6::zeros(),
            slope: V6::zeros(),
        }
    }

    /// The command, with the identification of contacts `trusted` or not.
    #[inline(never)]
    pub(super) fn command(
        &mut self,
        problem: &ControlProblem<'_>,
        in_contact: bool,
        trusted: bool,
    ) -> Command {
        let velocity = &problem.velocity;
        let lead = self.lead(velocity, in_contact, problem.delay());
        if !in_contact {
            self.blend(trusted);
        }
        let trust = self.trust;
        if trust >= 1.0 {
            return problem.solve();
        }
        let (simple, at_speed_limit) = limited(velocity + lead, &problem.reference.velocity);
        let mut command = Command {
            velocity: simple,
            tracking: simple - velocity,
            preload: V6::zeros(),
            preload_rate: 0.0,
            reversals: problem.reversals,
            at_speed_limit,
        };
        if trust > 0.0 {
            let full = problem.solve();
            command.velocity += (full.velocity - command.velocity) * trust;
            command.tracking += (full.tracking - command.tracking) * trust;
            command.preload = full.preload * trust;
            command.preload_rate = full.preload_rate * trust;
            command.reversals = full.reversals;
            command.at_speed_limit |= full.at_speed_limit;
        }
        command
    }

    /// A cycle between contacts. Beyond its ends the share would have to come back first.
    fn blend(&mut self, trusted: bool) {
        let step = if trusted { 1.0 } else { -1.0 } / BLEND_CYCLES;
        self.trust = (self.trust + step).clamp(0.0, 1.0);
    }

    /// A cycle: what is added to the model's velocity for a robot that is so many cycles late.
    fn lead(&mut self, velocity: &V6, in_contact: bool, delay: f64) -> V6 {
        if !in_contact {
            (self.last, self.slope) = (*velocity, V6::zeros());
            return V6::zeros();
        }
        let before = core::mem::replace(&mut self.slope, velocity - self.last);
        self.last = *velocity;
        // The difference stands for the middle of the cycle: half a cycle more.
        self.slope * delay + (self.slope - before) * (0.5 * delay * (delay + 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However long it was trusted or not: each way takes [`BLEND_CYCLES`], no cycle more.
    #[test]
    fn the_blend_takes_as_long_after_a_year_as_after_a_second() {
        let mut fallback = Fallback::new();
        let mut blended = |trusted, cycles| {
            (0..cycles).for_each(|_| fallback.blend(trusted));
            fallback.trust
        };
        let passage = BLEND_CYCLES as usize + 1;
        for (trusted, end) in [(true, 1.0), (false, 0.0), (true, 1.0)] {
            assert_eq!(blended(trusted, passage), end);
            assert_eq!(blended(trusted, 1000), end);
        }
    }
}
