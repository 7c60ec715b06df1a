//! A lead that knows nothing of the contact: the step of the ladder for contacts that are not
//! understood.
//!
//! ```text
//! v_cmd = v + τ v' + ½ τ² v''
//! ```
//!
//! as in the law `lead`, with the model's velocity during the contact. The law passes from the one to
//! the other over [`PASSAGE`] cycles, and only between contacts, where both are the model's velocity.

use super::V6;
use super::command::{Decision, Situation, limited};

/// Cycles from one step of the ladder to the other.
const PASSAGE: f64 = 10.0;

/// The lead, and how much of the command is the predictor's.
#[derive(Clone, Debug)]
pub(super) struct Leading {
    /// 1: the predictor; 0: the lead.
    pub(super) trust: f64,
    last: V6,
    slope: V6,
}

impl Leading {
    pub(super) fn new() -> Self {
        Self {
            trust: 1.0,
            last: V6::zeros(),
            slope: V6::zeros(),
        }
    }

    /// The command, with the identification of contacts `trusted` or not.
    #[inline(never)]
    pub(super) fn decide(
        &mut self,
        situation: &Situation<'_>,
        in_contact: bool,
        trusted: bool,
    ) -> Decision {
        let velocity = &situation.velocity;
        let lead = self.lead(velocity, in_contact, situation.delay());
        if !in_contact {
            let step = if trusted { 1.0 } else { -1.0 } / PASSAGE;
            self.trust = (self.trust + step).clamp(0.0, 1.0);
        }
        let trust = self.trust;
        if trust >= 1.0 {
            return situation.decide();
        }
        let (simple, at_speed_limit) = limited(velocity + lead, &situation.reference.velocity);
        let mut decision = Decision {
            command: simple,
            tracking: simple - velocity,
            leaning: V6::zeros(),
            lean: 0.0,
            turns: situation.turns,
            at_speed_limit,
        };
        if trust > 0.0 {
            let full = situation.decide();
            decision.command += (full.command - decision.command) * trust;
            decision.tracking += (full.tracking - decision.tracking) * trust;
            (decision.leaning, decision.lean) = (full.leaning * trust, full.lean * trust);
            decision.turns = full.turns;
            decision.at_speed_limit |= full.at_speed_limit;
        }
        decision
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
