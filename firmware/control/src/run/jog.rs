//! A cycle of a jog: what the operator asked for goes the way of every correction.

use super::{Plan, Run};
use crate::frames::Twist;
use crate::io::Trace;
use crate::limits::LimitFlags;
use crate::modes::Fault;
use crate::scalar::Scalar;

impl<S: Scalar> Run<S> {
    /// Sends this velocity, without the model and the delay law. `freeze` takes the velocity away as
    /// it does in a closed loop.
    pub(crate) fn jog(
        &mut self,
        plan: &Plan<S>,
        velocity: &Twist<S>,
        freeze: LimitFlags,
        trace: &mut Trace,
    ) -> Result<(), Fault> {
        let authority = self.next_authority(plan, freeze != LimitFlags::default());
        self.send(plan, *velocity * authority, freeze, trace)
    }

    /// The part of the rate that is sent in this cycle: it falls while there is a reason not to
    /// integrate, and rises again without.
    pub(super) fn next_authority(&mut self, plan: &Plan<S>, frozen: bool) -> S {
        let change = if frozen {
            -plan.authority_step
        } else {
            plan.authority_step
        };
        self.authority = (self.authority + change).clamp(S::zero(), S::one());
        self.authority
    }
}
