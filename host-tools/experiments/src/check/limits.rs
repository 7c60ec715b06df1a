//! Physical limits of all laws, whatever they know of the robot, if the wall is only felt at the touch.

use crate::one_contact::Contact;
use serde::Serialize;

/// Largest phase at which the contact's own restitution is possible while the robot retreats no faster than it came; below
/// it, with any speed of retreat: (v τ²/2) k ≤ 2 m v.
pub(super) const LARGEST_PHI: f64 = std::f64::consts::SQRT_2;
const LARGEST_PHI_AT_ANY_SPEED: f64 = 2.0;

/// The physical limits of a contact behind a delay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// φ = ω τ: the delay as a phase of the contact.
    pub phi: f64,
    /// Restitution of a law that integrates the measured force until the delay is over and then follows the ideal contact:
    /// √(1 − φ⁴/12 + φ⁶/36). For an elastic contact.
    pub restitution_limit: f64,
    /// Smallest restitution that is possible on a first contact, even with any speed of retreat:
    /// φ²/2 + 2 ζ φ + φ ω T_p − 1, with half a cycle until the touch is felt; 0 if less.
    pub least_restitution: f64,
    /// Smallest possible peak force of a first contact, relative to that of the ideal one.
    pub peak_force_ratio: f64,
    /// Whether the contact's own restitution is possible on a first contact.
    pub feasible: bool,
    /// Whether it is possible without a retreat that is faster than the approach: φ ≤ √2.
    pub feasible_at_approach_speed: bool,
}

impl Limits {
    /// The limits of a contact with a delay (s), a pause at the reversal (s) and a cycle (s).
    pub fn new(contact: &Contact, delay_s: f64, pause_s: f64, cycle_s: f64) -> Self {
        let omega = contact.frequency_rad_s();
        let zeta = contact.damping_ratio();
        let phi = omega * delay_s;
        let limit = (1.0 - phi.powi(4) / 12.0 + phi.powi(6) / 36.0)
            .max(0.0)
            .sqrt();
        // No law reacts before the touch is measured, half a cycle later on average.
        let felt = phi + 0.5 * omega * cycle_s;
        let spent = 0.5 * felt * felt + 2.0 * zeta * felt + felt * omega * pause_s;
        let least = (spent - 1.0).max(0.0);
        Self {
            phi,
            restitution_limit: limit,
            least_restitution: least,
            peak_force_ratio: f64::max(1.0, phi + omega * cycle_s),
            feasible: least <= contact.restitution() && phi <= LARGEST_PHI_AT_ANY_SPEED,
            feasible_at_approach_speed: phi <= LARGEST_PHI,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_phi(phi: f64, zeta: f64, pause_s: f64) -> Limits {
        let (mass_kg, stiffness_n_per_m) = (500.0, 220_500.0);
        let contact = Contact {
            mass_kg,
            stiffness_n_per_m,
            damping_n_s_per_m: 2.0 * zeta * f64::sqrt(mass_kg * stiffness_n_per_m),
        };
        Limits::new(&contact, phi / 21.0, pause_s, 0.004)
    }

    /// Known: φ .5 .9976, .7 .9916, 1.0 .9718, 1.41 .9428.
    #[test]
    fn the_known_limits() {
        for (phi, e) in [(0.5, 0.9976), (0.7, 0.9916), (1.0, 0.9718), (1.41, 0.9428)] {
            let limit = at_phi(phi, 0.0, 0.0).restitution_limit;
            assert!((limit - e).abs() < 3e-4, "{phi}: {limit}");
        }
    }

    /// Known at 32 ms and a pause of 16 ms: ζ .6 cannot be reached, without the pause it can.
    #[test]
    fn heavy_damping_behind_a_pause_is_not_feasible() {
        let with_pause = at_phi(0.672, 0.6, 0.016);
        assert!((with_pause.least_restitution - 0.35).abs() < 0.01);
        assert!(!with_pause.feasible);
        assert!(at_phi(0.672, 0.6, 0.0).feasible);
        assert!(at_phi(0.672, 0.0, 0.016).feasible);
        assert!(!at_phi(2.1, 0.0, 0.0).feasible);
    }
}
