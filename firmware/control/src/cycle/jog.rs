//! The part of the cycle that jogs.

use super::Cycle;
use crate::frames::Pose;
use crate::io::{RobotSample, Trace};
use crate::jog::{Jog, JogRun, has_room};
use crate::modes::{Fault, Readiness, Refusal};
use crate::scalar::Scalar;

impl<S: Scalar> Cycle<S> {
    /// Whether a jog may begin at this pose.
    pub(super) fn jog_allowed(&self, jog: Jog, pose: &Pose<S>) -> Readiness {
        let center = self.box_center.unwrap_or(*pose);
        let gimbal_lock = self.robot.gimbal_lock.as_ref();
        match has_room(&self.settings, gimbal_lock, jog, pose, &center) {
            true => Ok(()),
            false => Err(Refusal::NoRoom),
        }
    }

    /// Displacements count from this pose, and the jog begins with the present cycle.
    pub(super) fn begin_jog(&mut self, jog: Jog, pose: &Pose<S>) {
        self.take_start_pose(pose);
        self.jog = Some(JogRun::new(&self.settings, jog));
    }

    /// The next cycle of a jog; behind its end the robot holds.
    pub(super) fn jog_on(&mut self, robot: &RobotSample, trace: &mut Trace) -> Result<bool, Fault> {
        let freeze = self.freeze(robot);
        if let Some(velocity) = self.jog.as_mut().and_then(JogRun::next_velocity) {
            let sent = self.run.jog(&self.plan, &velocity, freeze, trace);
            return sent.map(|()| true);
        }
        self.modes.end_jog();
        self.run.fade_out(&self.plan, trace)
    }
}
