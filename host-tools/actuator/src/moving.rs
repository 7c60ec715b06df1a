//! A moving axis: drive, pause and lost motion, computed in parts or for a whole segment.

use super::chain::Chain;
use super::linear::PartVelocity;
use super::nonlinear::{Backlash, Drive, PauseGate};

/// The axis between two cycles.
pub(super) struct Moving {
    drive: Drive,
    gate: PauseGate,
    backlash: Backlash,
}

impl Moving {
    /// At rest.
    pub(super) fn new(chain: &Chain) -> Self {
        Self {
            drive: Drive::new(chain),
            gate: PauseGate::new(chain),
            backlash: Backlash::new(chain.backlash_m),
        }
    }

    /// One part with a constant command.
    pub(super) fn step(&mut self, command: f64, duration_s: f64) -> PartVelocity {
        let moved = if self.gate.holds_command() {
            self.gate.follow_held(command, duration_s, &mut self.drive)
        } else {
            let moved = self.drive.follow(command, duration_s);
            self.gate.pass(moved, command, duration_s, &mut self.drive)
        };
        self.backlash.pass(moved, duration_s)
    }

    /// Whether nothing but the linear stages acts while a command is constant.
    pub(super) fn can_step_exactly(&self, command: f64) -> bool {
        !self.backlash.acts()
            && self.drive.is_free(command)
            && self.gate.stays_open(command, &self.drive)
    }

    /// Advances by a whole segment, if [`Self::can_step_exactly`]. `once`: no other segment has this duration.
    pub(super) fn exact_step(&mut self, command: f64, duration_s: f64, once: bool) -> PartVelocity {
        let moved = self.drive.exact_step(command, duration_s, once);
        self.gate.opened(moved, command);
        moved
    }
}
