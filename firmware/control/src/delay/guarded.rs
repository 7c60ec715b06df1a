//! A law, and the energy bound beside it if that is asked for.

use super::energy_bound::EnergyBound;
use super::status::LawFlags;
use super::{DelaySettings, Law, LawInput, LawName, LawOutput};
use crate::frames::{Wrench, saturated};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Largest component of the wrench that the model feels, N and N·m: the largest overload limit, at
/// which its lever stays within fixed point.
const LARGEST_FELT: f64 = 1e5;

/// The chosen law with its guard.
#[derive(Clone, Debug)]
pub struct Guarded<S: Scalar> {
    law: Law<S>,
    guard: Option<EnergyBound<S>>,
}

impl<S: Scalar> Guarded<S> {
    /// In the initial state; `cycle_s` in s.
    #[inline(always)] // or each level would hold a copy of the law on the stack
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        Self {
            law: Law::new(settings, cycle_s),
            guard: bound(settings, cycle_s),
        }
    }

    /// The initial state again, in place.
    pub fn restart(&mut self, settings: &DelaySettings, cycle_s: f64) {
        self.law.restart(settings, cycle_s);
        self.guard = bound(settings, cycle_s);
    }

    /// See [`Law::condition`].
    pub fn condition(&mut self, input: &LawInput<'_, S>) -> Wrench<S> {
        let felt = self.law.condition(input);
        let felt = match &mut self.guard {
            Some(guard) => guard.bounded(input, felt.map(within)),
            None => felt,
        };
        felt.map(within)
    }

    /// See [`Law::step`].
    pub fn step(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        let mut output = self.law.step(input);
        if self.guard.as_ref().is_some_and(|guard| guard.acts) {
            output.status.flags.set(LawFlags::GUARD_PASSIVE);
        }
        output
    }
}

fn within<S: Scalar>(part: &Vector3<S>) -> Vector3<S> {
    saturated(part, LARGEST_FELT)
}

/// The guard of these settings: the predictor has one of its own that asks for it too.
fn bound<S: Scalar>(settings: &DelaySettings, cycle_s: f64) -> Option<EnergyBound<S>> {
    let predictor = settings.law == LawName::Predictor && settings.predictor.guard;
    let threshold_n = settings.passivity.threshold_n;
    (settings.passivity_guard || predictor).then(|| EnergyBound::new(threshold_n, cycle_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::SentHistory;
    use crate::dynamics::{BodyState, TwoBody, TwoBodyState};
    use crate::frames::{Pose, Twist};
    use crate::settings::BodySettings;
    use nalgebra::UnitQuaternion;

    /// What the spacecraft feel of 1e6 N and N·m with this law, and with the guard or without.
    fn felt(law: LawName, passivity_guard: bool) -> [f64; 6] {
        let settings = DelaySettings {
            law,
            passivity_guard,
            ..DelaySettings::default()
        };
        let body = BodySettings::default();
        let at_rest = BodyState::initial(&body);
        Guarded::<f64>::new(&settings, 0.004)
            .condition(&LawInput {
                model: Twist::zero(),
                model_end: Twist::zero(),
                wrench: &Wrench::of(&[1e6, -1e6, 1e6, 1e6, -1e6, 1e6]),
                measured: &Pose::identity(),
                commanded: &Pose::identity(),
                sent: &SentHistory::new(),
                bodies: &TwoBody::new(&body, &body, 0.004),
                state: &TwoBodyState {
                    k: at_rest,
                    q: at_rest,
                },
                c_from_q: UnitQuaternion::identity(),
                released: true,
                frozen: false,
            })
            .get()
    }

    #[test]
    fn no_law_lets_more_be_felt_than_the_largest_load() {
        for law in LawName::ALL {
            for guard in [false, true] {
                let felt = felt(law, guard);
                let largest = felt
                    .iter()
                    .fold(0.0, |most: f64, part| most.max(part.abs()));
                assert!(largest <= LARGEST_FELT, "{law:?}: {felt:?}");
            }
        }
        let taken = LARGEST_FELT;
        let sides = [taken, -taken, taken, taken, -taken, taken];
        assert_eq!(felt(LawName::None, false), sides);
    }
}
