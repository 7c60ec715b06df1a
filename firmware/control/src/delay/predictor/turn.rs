//! One reversal per axis and contact: each costs the robot a pause.
//!
//! An axis may turn when the reference does, half a pause and a delay ahead, or when the balance asks
//! for a clear retreat; then it stays turned until the contact is over. Noise around zero, or the
//! first guess of a contact, would otherwise make the robot stand still twice.

use super::V6;
use super::reference::{Lag, Reference};

/// Slowest command on either side of the reversal, in units of the closing velocity of the axis.
const CREEP: f64 = 0.005;
/// Slowest one that a correction of four decimals of a millimetre carries in each cycle of 4 ms, m/s: what
/// is rounded away turns the robot a cycle later than its twin.
const CARRIED: f64 = 2.5e-5;
/// A retreat this fast is meant, in the same units.
const RETREAT: f64 = 0.15;
/// Cycles after the touch before a retreat is believed.
const SETTLED: f64 = 2.0;
/// Part of the contact that must be over before it.
const PART: f64 = 0.25;
/// Damping ratio from which on a contact needs an early retreat. The decision stays until the contact
/// is over: an axis that has turned must not be turned back by an estimate that wavers.
const DAMPED: f64 = 0.25;
/// An axis that keeps more than this part of its velocity in a damped contact is not to turn in it.
const GOES_ON: f64 = 0.1;
/// An axis that takes no more of the motion has no direction of its own.
const SHARE: f64 = 0.02;

/// Which axes have turned in this contact.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turns {
    turned: [bool; 6],
    /// The contact was found to be damped: the robot has to retreat at once, and may turn as often as
    /// it likes.
    free: bool,
}

impl Turns {
    /// The command with no more than one reversal, `since` cycles after the touch and with the
    /// reference as it will be when the robot answers.
    pub(super) fn allow(
        &mut self,
        command: &V6,
        reference: &Reference,
        then: &Lag,
        since: f64,
        cycle_s: f64,
    ) -> V6 {
        let damped = reference.spring.is_some_and(|spring| spring.zeta > DAMPED);
        self.free |= damped;
        if damped {
            return onward(command, reference);
        }
        if self.free {
            return *command;
        }
        let before = reference.velocity;
        let later = before - reference.push * then.velocity;
        let duration = (reference.end(cycle_s) - reference.touch).max(1.0);
        let believable = since > SETTLED && since > PART * duration;
        let mut allowed = *command;
        for i in 0..6 {
            let size = before[i].abs();
            if size < SHARE * before.norm() {
                continue;
            }
            let sign = if before[i] > 0.0 { 1.0 } else { -1.0 };
            let u = command[i] * sign;
            let may = later[i] * sign <= 0.0 || (u < -RETREAT * size && believable);
            let Some(turned) = self.turned.get_mut(i) else {
                continue;
            };
            *turned |= may && u < 0.0;
            let creep = (CREEP * size).max(CARRIED);
            let kept = if *turned { u.min(-creep) } else { u.max(creep) };
            allowed[i] = kept * sign;
        }
        allowed
    }
}

/// For a damped contact: no axis turns that goes on in its direction afterwards. It would pause twice
/// for a retreat that the others can make.
fn onward(command: &V6, reference: &Reference) -> V6 {
    let before = reference.velocity;
    let rebound = reference.spring.map_or(1.0, |spring| spring.restitution);
    let after = before - reference.push * ((1.0 + rebound) * reference.closing);
    let mut allowed = *command;
    for i in 0..6 {
        let goes_on = after[i] / before[i] > GOES_ON && before[i].abs() > SHARE * before.norm();
        if goes_on && allowed[i] * before[i] < 0.0 {
            allowed[i] = CREEP * before[i];
        }
    }
    allowed
}
