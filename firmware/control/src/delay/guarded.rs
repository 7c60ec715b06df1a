//! A law, and passivity beside it if that is asked for.

use super::passivity::Passivity;
use super::status::LawFlags;
use super::{DelaySettings, Law, LawInput, LawName, LawOutput};
use crate::frames::{Wrench, saturated};
use crate::scalar::Scalar;

/// Largest component of the wrench that the model feels, N and N·m: the largest overload limit, at
/// which its lever stays within fixed point.
const LARGEST_FELT: f64 = 1e5;

/// The chosen law with its guard.
#[derive(Clone, Debug)]
pub struct Guarded<S: Scalar> {
    law: Law<S>,
    guard: Option<Passivity<S>>,
}

impl<S: Scalar> Guarded<S> {
    /// In the initial state; `cycle_s` in s. The law `passivity` needs no guard.
    #[inline(always)] // or each level would hold a copy of the law on the stack
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        let guard = settings.passivity_guard && settings.law != LawName::Passivity;
        Self {
            law: Law::new(settings, cycle_s),
            guard: guard.then(|| Passivity::new(settings, cycle_s)),
        }
    }

    /// The initial state again, in place.
    pub fn restart(&mut self, settings: &DelaySettings, cycle_s: f64) {
        self.law.restart(settings, cycle_s);
        let guard = settings.passivity_guard && settings.law != LawName::Passivity;
        self.guard = guard.then(|| Passivity::new(settings, cycle_s));
    }

    /// See [`Law::condition`].
    pub fn condition(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        let felt = self.law.condition(input);
        let felt = match &mut self.guard {
            Some(guard) => guard.condition(input, felt),
            None => felt,
        };
        felt.map(|part| saturated(part, LARGEST_FELT))
    }

    /// See [`Law::step`].
    pub fn step(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        let mut output = self.law.step(input);
        let guard = self.guard.as_ref().map(Passivity::status);
        if guard.is_some_and(|status| status.flags.has(LawFlags::GUARD_PASSIVE)) {
            output.status.flags.set(LawFlags::GUARD_PASSIVE);
        }
        output
    }
}
