//! Docking mechanisms. From the motion of one docking frame relative to the other they compute a wrench, the state of the
//! mechanism, and the energy balance.
//!
//! ```text
//!   P  docking frame of the target, x out of what is approached on    J  docking frame of the
//!      (the closing direction)                                           moving side
//!
//!         J --->            P-->x       docked: J is P.  Before: J is at negative x.
//! ```
//!
//! A mechanism is compliant: its force follows from the relative motion of the two frames. It has no mass, so the wrench on
//! one side is the reaction to that on the other, and every mechanism conserves momentum.
//!
//! Everything here is a function of its arguments, allocates nothing and never panics. The simulated rig, predictions and
//! tests use the same code. Equations and sources: docs/mechanisms.md.

mod contact;
mod docking;
mod eddy_current;
mod energy_balance;
mod hexapod;
mod hunt_crossley;
mod loads;
mod petals;
mod probe_cone;
mod relative;
mod socket;
mod soft_capture;
mod two_stage;

pub use contact::Surface;
pub use docking::{Docking, DockingSettings, Joint, Kind};
pub use eddy_current::EddyCurrent;
pub use energy_balance::{EnergyBalance, EnergyTracked};
pub use hexapod::Hexapod;
pub use hunt_crossley::HuntCrossley;
pub use loads::Loads;
pub use petals::Petals;
pub use probe_cone::ProbeCone;
pub use relative::Relative;
pub use socket::Socket;
pub use soft_capture::SoftCapture;
pub use two_stage::TwoStage;

use softdock_control::frames::Wrench;

/// Wrench and energies of a mechanism at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaction {
    /// Wrench on the moving side, at J, in axes of J (N, N·m); the target gets the opposite one.
    pub wrench: Wrench<f64>,
    /// Energy that the mechanism would give back, J.
    pub stored_j: f64,
    /// Power that damping dissipates, W. The loss of dry friction is computed per step instead.
    pub loss_w: f64,
}

impl Reaction {
    /// The reaction without any contact.
    pub fn none() -> Self {
        Self {
            wrench: Wrench::zero(),
            stored_j: 0.0,
            loss_w: 0.0,
        }
    }
}

impl core::ops::Add for Reaction {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            wrench: self.wrench + other.wrench,
            stored_j: self.stored_j + other.stored_j,
            loss_w: self.loss_w + other.loss_w,
        }
    }
}

/// A docking mechanism.
pub trait Mechanism {
    /// The reaction at an instant. It changes no state.
    fn reaction(&self, at: &Relative) -> Reaction;

    /// Advances the state by a step that ends here and whose mean velocity is that of `at`. Returns the energy that dry
    /// friction dissipated, J.
    fn advance(&mut self, at: &Relative, step_s: f64) -> f64 {
        let _ = (at, step_s);
        0.0
    }

    /// Whether latches hold the two sides together.
    fn captured(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod testing;
