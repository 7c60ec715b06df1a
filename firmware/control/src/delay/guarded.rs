//! A law with the energy bound behind it, if the settings ask for the bound.

use super::energy_bound::EnergyBound;
use super::status::LawFlags;
use super::{DelaySettings, Law, LawInput, LawName, LawOutput};
use crate::frames::{Wrench, saturated};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Largest component of the wrench that the model feels, N and N·m: the upper end of the range of the overload limit, at which
/// its lever stays within fixed point.
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

/// The energy bound, if these settings ask for it: by `passivity_guard`, or by the predictor's own `guard`.
fn bound<S: Scalar>(settings: &DelaySettings, cycle_s: f64) -> Option<EnergyBound<S>> {
    let predictor = settings.law == LawName::Predictor && settings.predictor.guard;
    let threshold_n = settings.passivity.threshold_n;
    (settings.passivity_guard || predictor).then(|| EnergyBound::new(threshold_n, cycle_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::{CYCLE_S, Spacecraft};
    use crate::frames::Twist;
    use crate::settings::BodySettings;

    fn settings(law: LawName, passivity_guard: bool) -> DelaySettings {
        DelaySettings {
            law,
            passivity_guard,
            ..DelaySettings::default()
        }
    }

    /// A cycle of spacecraft at rest, with this wrench and this velocity of the model: the wrench that is felt, and the velocity
    /// that is sent.
    fn cycle(law: &mut Guarded<f64>, wrench: [f64; 6], model: [f64; 6]) -> ([f64; 6], [f64; 6]) {
        let body = BodySettings::default();
        let (spacecraft, wrench) = (Spacecraft::new(&body, &body), Wrench::of(&wrench));
        let input = spacecraft.asked(&wrench, Twist::of(&model));
        (law.condition(&input).get(), law.step(&input).command.get())
    }

    /// What the spacecraft feel of 1e6 N and N·m with this law, with or without the guard.
    fn felt(law: LawName, passivity_guard: bool) -> [f64; 6] {
        let mut law = Guarded::new(&settings(law, passivity_guard), CYCLE_S);
        cycle(&mut law, [1e6, -1e6, 1e6, 1e6, -1e6, 1e6], [0.0; 6]).0
    }

    /// Ten cycles of a contact and a velocity that change.
    fn history(law: &mut Guarded<f64>) -> [([f64; 6], [f64; 6]); 10] {
        core::array::from_fn(|n| {
            let grown = n as f64;
            let wrench = [20.0 * grown, 0.0, 0.0, 0.0, grown, 0.0];
            cycle(
                law,
                wrench,
                [0.01 * grown * grown, 0.0, 0.0, 0.0, 0.0, 0.02],
            )
        })
    }

    #[test]
    fn a_law_that_is_restarted_has_forgotten_everything() {
        for law in LawName::ALL {
            let settings = settings(law, true);
            let mut used = Guarded::new(&settings, CYCLE_S);
            let first = history(&mut used);
            used.restart(&settings, CYCLE_S);
            assert_eq!(history(&mut used), first, "{law:?}");
        }
    }

    #[test]
    fn a_restart_may_choose_another_law() {
        for before in LawName::ALL {
            for after in [LawName::None, LawName::Lead, LawName::Predictor] {
                let mut law = Guarded::new(&settings(before, true), CYCLE_S);
                law.restart(&settings(after, false), CYCLE_S);
                let mut new = Guarded::new(&settings(after, false), CYCLE_S);
                assert_eq!(history(&mut law), history(&mut new), "{before:?} {after:?}");
            }
        }
    }

    #[test]
    fn the_energy_bound_is_there_where_it_is_asked_for() {
        for (law, own, guard, expected) in [
            (LawName::Predictor, true, false, true),
            (LawName::Predictor, false, false, false),
            (LawName::Predictor, false, true, true),
            (LawName::Lead, true, false, false),
            (LawName::Lead, false, true, true),
        ] {
            let mut settings = settings(law, guard);
            settings.predictor.guard = own;
            let bound = bound::<f64>(&settings, CYCLE_S);
            assert_eq!(bound.is_some(), expected, "{law:?} {own} {guard}");
        }
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
