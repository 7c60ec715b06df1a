//! Docking mechanisms. From how one docking frame moves before the other follow a wrench, what the
//! mechanism remembers, and where the energy went.
//!
//! ```text
//!   P  docking frame of the target, x out of what is approached on    J  docking frame of the
//!      (the closing direction)                                           moving side
//!
//!         J --->            P-->x       docked: J is P.  Before: J is at negative x.
//! ```
//!
//! A mechanism is compliant: its force follows from where the two frames are. It has no mass, so what
//! it does to one side it does to the other, and momentum is kept whatever the mechanism is.
//!
//! Everything here is a function of its arguments, allocates nothing and never panics: rig, prediction
//! and tests evaluate the same. Equations and sources: docs/mechanisms.md.

mod book;
mod contact;
mod docking;
mod eddy_current;
mod hexapod;
mod hunt_crossley;
mod loads;
mod petals;
mod probe_cone;
mod relative;
mod socket;
mod soft_capture;
mod two_stage;

pub use book::{Booked, EnergyBook};
pub use contact::Surface;
pub use docking::{Docking, DockingSettings, Joint, Kind};
pub use eddy_current::EddyCurrent;
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

/// What a mechanism does at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaction {
    /// On the moving side, at J, in axes of J (N, N·m); the target gets the reaction.
    pub wrench: Wrench<f64>,
    /// Energy that the mechanism would give back, J.
    pub stored_j: f64,
    /// Power that damping turns into heat, W. Dry friction is booked by the step.
    pub loss_w: f64,
}

impl Reaction {
    /// Nothing touches.
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
    /// What acts at an instant. Pure: asking twice changes nothing.
    fn reaction(&self, at: &Relative) -> Reaction;

    /// Moves what it remembers over a step that ends here and whose mean velocity is that of `at`.
    /// Returns the energy that dry friction took, J.
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
