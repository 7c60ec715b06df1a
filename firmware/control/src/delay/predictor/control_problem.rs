//! What the command of a cycle depends on.

use super::V6;
use super::command_history::CommandHistory;
use super::contact_estimator::Estimate;
use super::dynamic_matrix::DynamicMatrix;
use super::reference::Reference;
use super::reversals::Reversals;
use super::robot_model::{RobotModel, RobotState};
use super::stiffening::Curve;

/// What a command depends on.
pub(super) struct ControlProblem<'a> {
    pub(super) cycle: usize,
    pub(super) model: &'a RobotModel,
    pub(super) commands: &'a CommandHistory,
    pub(super) matrix: &'a DynamicMatrix,
    pub(super) latency: usize,
    /// The robot at the time of the force.
    pub(super) robot: RobotState,
    /// Velocity of the model of the two spacecraft.
    pub(super) velocity: V6,
    pub(super) reference: Reference,
    /// The contact that is going on or expected.
    pub(super) contact: Option<Estimate>,
    /// Axes that have reversed in the contact.
    pub(super) reversals: Reversals,
    /// The largest latency that the pose may have, cycles.
    pub(super) latest: usize,
    /// Load over depth of the contact, where it stiffens.
    pub(super) curve: Option<Curve>,
}

impl ControlProblem<'_> {
    /// Delay from a command to its execution, at the time of the force, cycles.
    pub(super) fn delay(&self) -> f64 {
        self.model.execution_delay(self.latency)
    }
}
