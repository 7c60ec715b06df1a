//! Docking mechanisms over a log.
//!
//! They have memory: sticking friction, a ring that yields, latches. Their force depends on the path, not on the present pose
//! alone, so they are moved along the measured motion. A log, and each run of the robot in it, has to begin before the contact.

use crate::model::prediction::signals::Step;
use nalgebra::UnitQuaternion;
use softdock_control::frames::{Pose, Twist, Wrench};
use softdock_control::wrench::Motion;
use softdock_mechanism::{Docking, DockingSettings};

/// The docking mechanisms of a model with their state.
pub struct Docked {
    dockings: Vec<Docking>,
    /// The mechanisms before any contact.
    untouched: Vec<Docking>,
    last: Option<Pose<f64>>,
    cycle_s: f64,
    /// Integration steps per cycle.
    steps: f64,
}

impl Docked {
    /// Nothing has touched yet. Settings out of range, which a model file cannot have, are left out.
    pub fn new(settings: &[DockingSettings], cycle_s: f64) -> Self {
        let longest = settings.iter().map(|d| d.kind.longest_step_s());
        let longest_s = longest.fold(cycle_s, f64::min);
        let untouched: Vec<Docking> = settings.iter().flat_map(Docking::new).collect();
        Self {
            steps: (cycle_s / longest_s).ceil().max(1.0),
            dockings: untouched.clone(),
            untouched,
            last: None,
            cycle_s,
        }
    }

    /// The wrench at M in axes of M of every cycle; empty without a mechanism. `steps` is empty if each cycle directly follows
    /// the one before.
    pub fn along(
        settings: &[DockingSettings],
        cycle_s: f64,
        pose: &[Pose<f64>],
        motion: &[Motion<f64>],
        steps: &[Step],
    ) -> Vec<Wrench<f64>> {
        let mut docked = Self::new(settings, cycle_s);
        if docked.is_empty() {
            return Vec::new();
        }
        let cycles = pose.iter().zip(motion).enumerate();
        let at = |(n, (pose, motion)): (usize, (_, &Motion<f64>))| {
            docked.resume(steps.get(n).copied().unwrap_or(Step::Next));
            docked.advance(pose);
            docked.wrench(pose, &motion.velocity)
        };
        cycles.map(at).collect()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.dockings.is_empty()
    }

    /// To be called before each cycle with its step. Between two runs the robot was moved away, so that the mechanisms are reset;
    /// across a hole the path is unknown, so that they keep their state.
    pub fn resume(&mut self, step: Step) {
        match step {
            Step::Next | Step::Lost(_) => {}
            Step::Hole => self.last = None,
            Step::NewRun => {
                self.last = None;
                self.dockings.clone_from(&self.untouched);
            }
        }
    }

    /// Moves to the pose of the next cycle, along a straight line at constant velocity.
    pub fn advance(&mut self, pose: &Pose<f64>) {
        let last = self.last.replace(*pose).unwrap_or(*pose);
        let way = pose.translation.vector - last.translation.vector;
        let turn = (last.rotation.inverse() * pose.rotation).scaled_axis();
        let twist = Twist {
            linear: way / self.cycle_s,
            angular: turn / self.cycle_s,
        };
        for k in 1..=self.steps as usize {
            let share = k as f64 / self.steps;
            let mut at = last;
            at.translation.vector += way * share;
            at.rotation *= UnitQuaternion::from_scaled_axis(turn * share);
            for docking in &mut self.dockings {
                docking.follow(&at, &twist, self.cycle_s / self.steps);
            }
        }
    }

    /// Their wrench at M, in axes of M, for a pose and a twist of M.
    pub fn wrench(&self, pose: &Pose<f64>, twist: &Twist<f64>) -> Wrench<f64> {
        let all = self.dockings.iter().map(|d| d.wrench(pose, twist));
        all.fold(Wrench::zero(), |sum, wrench| sum + wrench)
    }

    /// Noise of the wrench from one standard deviation of each component of position (m), then velocity (m/s) of M.
    pub fn noise(
        &self,
        pose: &Pose<f64>,
        twist: &Twist<f64>,
        [position_m, velocity_m_s]: [f64; 2],
    ) -> [Wrench<f64>; 6] {
        let nominal = self.wrench(pose, twist);
        std::array::from_fn(|i| {
            let (mut pose, mut twist) = (*pose, *twist);
            if i < 3 {
                pose.translation.vector[i] += position_m;
            } else {
                twist.linear[i - 3] += velocity_m_s;
            }
            self.wrench(&pose, &twist) - nominal
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;
    use nalgebra::Vector3;

    const MODEL: &str = include_str!("../../../../scenarios/probe-drogue.model.toml");

    /// Into the mechanism until it latches, and 0.1 m away again: the next run meets an open latch.
    #[test]
    fn each_run_meets_a_mechanism_that_nothing_has_touched() {
        let model = Model::from_toml(MODEL, "model").unwrap();
        let settings = &model.contact.docking;
        let seat = Vector3::from(settings[0].position_m) - Vector3::from(settings[0].tip_m);
        let at = |mm: i32| {
            let ahead = Vector3::x() * (1e-3 * f64::from(mm));
            Pose::from_parts((seat + ahead).into(), UnitQuaternion::identity())
        };
        let pulls_after = |step| {
            let mut docked = Docked::new(settings, 0.004);
            let way = (-200..10).chain((-100..10).rev());
            way.for_each(|mm| docked.advance(&at(mm)));
            docked.resume(step);
            docked.advance(&at(-100));
            docked.wrench(&at(-100), &Twist::zero()) != Wrench::zero()
        };
        let held = [Step::Next, Step::Hole, Step::NewRun].map(pulls_after);
        assert_eq!(held, [true, true, false]);
    }
}
