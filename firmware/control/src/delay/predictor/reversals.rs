//! Which axes have reversed in a contact: each may do so once, because each reversal costs the robot a pause.
//!
//! An axis may reverse when the reference does, half a pause and a delay ahead, or when impulse matching asks for a clear
//! retreat; then it stays reversed until the contact is over. Otherwise noise around zero, or the first estimate of a contact,
//! would make the robot stand still twice.

use super::V6;
use super::reference::{Deviation, Reference};
use super::tuning::*;

/// Which axes have reversed in this contact.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reversals {
    reversed: [bool; 6],
    /// The contact was found to be damped: the robot has to retreat at once, and may reverse as often as it
    /// likes. The decision stays until the contact is over: an axis that has reversed must not be turned back
    /// by an estimate that wavers.
    free: bool,
}

impl Reversals {
    /// The command with at most one reversal per axis, `since` cycles after the onset. `then` is the deviation of the reference
    /// at the earliest time at which the robot responds; `sure` tells whether that time is known.
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

/// For a damped contact: an axis that keeps its direction after the contact does not reverse in it. It would pause twice for a
/// retreat that the other axes can make.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::predictor::bounce::MASS;
    use crate::delay::predictor::kelvin_voigt::KelvinVoigt;
    use crate::delay::spacecraft::CYCLE_S;

    /// Into a contact of 21 rad/s with this damping ratio, 37 cycles long if it is undamped: an axis that moves forward, one that
    /// moves backward, and one with less than its share of the motion. `speed` in m/s.
    fn reference(speed: f64, zeta: f64) -> Reference {
        spring_at(speed, 21.0, zeta)
    }

    fn spring_at(speed: f64, omega: f64, zeta: f64) -> Reference {
        let along = V6::new(0.8, -0.6, 0.0, 0.0, 0.0, 0.0);
        let few = V6::new(0.0, 0.0, 0.019, 0.0, 0.0, 0.0);
        let mut reference = Reference::straight(100, V6::zeros(), (along + few) * speed);
        let damping = 2.0 * zeta * MASS * omega;
        let contact = KelvinVoigt::new(MASS * omega * omega, damping, MASS);
        (reference.push, reference.closing) = (along, speed);
        reference.contact = Some(contact);
        reference
    }

    /// The deviation by which the reference has lost this part of its velocity.
    fn lost(reference: &Reference, part: f64) -> Deviation {
        Deviation {
            displacement: 0.0,
            velocity: part * reference.closing,
        }
    }

    /// A command in parts of the velocity of each axis.
    fn parts(reference: &Reference, x: f64, y: f64, z: f64) -> V6 {
        reference
            .velocity
            .component_mul(&V6::new(x, y, z, 0.0, 0.0, 0.0))
    }

    fn assert_same(allowed: &V6, expected: &V6) {
        let apart = (allowed - expected).amax();
        assert!(apart < 1e-12, "{allowed} {expected}");
    }

    /// The slowest command is given by the axis's own velocity at 50 mm/s, by the last digit of a correction at 1 mm/s.
    #[test]
    fn an_axis_goes_on_until_the_reference_turns_and_then_never_again() {
        for (speed, [x, y]) in [
            (0.05, [0.005, 0.005]),
            (0.001, [2.5e-5 / 0.0008, 2.5e-5 / 0.0006]),
        ] {
            let reference = reference(speed, 0.0);
            let mut reversals = Reversals::default();
            let mut ask = |x: f64, y: f64, part: f64| {
                let command = parts(&reference, x, y, -1.0);
                let then = lost(&reference, part);
                reversals.allow(&command, &reference, &then, (5.0, true), CYCLE_S)
            };
            // The third axis, with less than its share, is not held.
            let answer = |x: f64, y: f64| parts(&reference, x, y, -1.0);
            assert_same(&ask(0.5, 0.9, 0.9), &answer(0.5, 0.9));
            assert_same(&ask(0.0, -0.9, 0.99), &answer(x, y));
            assert_same(&ask(0.5, 0.9, 1.01), &answer(0.5, 0.9));
            assert_same(&ask(-0.5, 0.9, 1.01), &answer(-0.5, 0.9));
            assert_same(&ask(0.5, -0.9, 0.9), &answer(-x, y));
            assert_same(&ask(-0.9, -0.9, 1.5), &answer(-0.9, -0.9));
            assert_same(&ask(-0.0, 0.9, 0.0), &answer(-x, -y));
        }
    }

    /// 0.15 of the velocity, a quarter of the contact and two cycles after its onset.
    #[test]
    fn a_retreat_is_believed_if_it_is_clear_and_not_at_the_beginning() {
        for (omega, since, retreat, turns) in [
            (21.0, 10.0, 0.16, true),
            (21.0, 10.0, 0.14, false),
            (21.0, 9.0, 0.16, false),
            (196.0, 2.1, 0.16, true),
            (196.0, 1.9, 0.16, false),
        ] {
            let reference = spring_at(0.05, omega, 0.0);
            let command = parts(&reference, -retreat, 1.0, 0.0);
            let then = lost(&reference, 0.0);
            let mut reversals = Reversals::default();
            let known = (since, true);
            let allowed = reversals.allow(&command, &reference, &then, known, CYCLE_S);
            let x = if turns { -retreat } else { 0.005 };
            assert_same(&allowed, &parts(&reference, x, 1.0, 0.0));
        }
    }

    #[test]
    fn a_contact_that_was_damped_for_sure_lets_all_axes_turn_until_its_end() {
        for (zeta, sure, free) in [
            (0.26, true, true),
            (0.24, true, false),
            (0.26, false, false),
        ] {
            let damped = reference(0.05, zeta);
            let command = parts(&damped, -0.1, -0.1, 0.0);
            let then = lost(&damped, 0.0);
            let held = parts(&damped, 0.005, 0.005, 0.0);
            let expected = if free { command } else { held };
            let mut reversals = Reversals::default();
            let first = reversals.allow(&command, &damped, &then, (5.0, sure), CYCLE_S);
            assert_same(&first, &expected);
            // However often the contact is found to be damped.
            reversals.allow(&command, &damped, &then, (5.5, sure), CYCLE_S);
            let undamped = reference(0.05, 0.0);
            let later = reversals.allow(&command, &undamped, &then, (6.0, sure), CYCLE_S);
            assert_same(&later, &expected);
        }
    }

    /// The second axis keeps this part of its velocity.
    #[test]
    fn in_a_damped_contact_an_axis_that_goes_on_afterwards_does_not_turn() {
        for (kept, held) in [(1.0, true), (0.11, true), (0.09, false), (-0.5, false)] {
            let mut damped = reference(0.05, 0.3);
            let change = (1.0 + damped.restitution()) * damped.closing;
            damped.push[1] = (1.0 - kept) * damped.velocity[1] / change;
            let then = lost(&damped, 0.0);
            let ask = |y: f64| {
                let command = parts(&damped, -0.2, y, -1.0);
                Reversals::default().allow(&command, &damped, &then, (5.0, true), CYCLE_S)
            };
            let y = if held { 0.005 } else { -0.3 };
            assert_same(&ask(-0.3), &parts(&damped, -0.2, y, -1.0));
            assert_same(&ask(0.3), &parts(&damped, -0.2, 0.3, -1.0));
        }
    }
}
