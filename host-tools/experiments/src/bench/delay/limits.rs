//! Limits that hold for every law on a first contact with a wall that is not known beforehand.
//!
//! With a pure delay τ the robot cannot react for τ after the touch, nor for up to a cycle more until the touch is measured,
//! nor while it stands still at its reversal.

use super::case::Case;
use super::scene::End;
use crate::check;
use crate::one_contact::Contact;
use serde::Serialize;
use softdock_delay_plants::Dynamics;

/// Physical limits of a first contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// φ = ω τ.
    pub phi: f64,
    /// Smallest restitution that any law can reach: the impulse that is spent before the robot can turn, over m v0, less 1. This
    /// is φe²/2 + 2 ζ φe + φe ω Tp − 1 with φe = ω (τ + half a cycle).
    pub least_restitution: f64,
    /// Smallest error of the peak force. The robot moves on for τ, so the peak is at least φ + ω Ts of the ideal one where
    /// that is more than 1.
    pub least_peak_force_error: f64,
    /// Restitution of a law that follows the predicted model without compensating the impulse that was spent before: √(1 −
    /// φ⁴/12 + φ⁶/36).
    pub without_balance: f64,
}

impl Limits {
    /// The limits of a case; None unless the theory holds: a pure delay and one straight impact.
    pub fn new(case: &Case, cycle_s: f64) -> Option<Self> {
        let (robot, scene) = (&case.robot.actuator, &case.scene);
        let pure = robot.dynamics == Dynamics::None;
        if !(pure && scene.is_straight() && scene.end == End::Impacts(1)) {
            return None;
        }
        let contact = Contact {
            mass_kg: scene.mass_kg,
            stiffness_n_per_m: scene.law.stiffness,
            damping_n_s_per_m: scene.law.damping,
        };
        let limits = check::Limits::new(&contact, robot.delay_s, robot.pause_s, cycle_s);
        Some(Self {
            phi: limits.phi,
            least_restitution: limits.least_restitution,
            least_peak_force_error: limits.peak_force_ratio - 1.0,
            without_balance: limits.restitution_limit,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The canonical case, and one that is not feasible.
    #[test]
    fn known_limits() {
        let mut case = Case::new("x", "x");
        let limits = Limits::new(&case, 0.004).unwrap();
        assert!((limits.without_balance - 0.9929).abs() < 1e-3, "{limits:?}");
        assert_eq!(limits.least_restitution, 0.0);
        case.scene = case.scene.damped(0.6);
        let limits = Limits::new(&case, 0.004).unwrap();
        assert!((limits.least_restitution - 0.35).abs() < 0.01, "{limits:?}");
    }
}
