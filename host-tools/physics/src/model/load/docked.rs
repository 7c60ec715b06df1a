//! Docking mechanisms over a log.
//!
//! They remember: friction that sticks, a ring that yields, latches. What they do follows from the way
//! and not from an instant, so they are moved along the measured motion. A log has to begin before the
//! contact.

use nalgebra::UnitQuaternion;
use softdock_control::frames::{Pose, Twist, Wrench};
use softdock_control::wrench::Motion;
use softdock_mechanism::{Docking, DockingSettings};

/// The docking mechanisms of a model on their way.
pub struct Docked {
    dockings: Vec<Docking>,
    last: Option<Pose<f64>>,
    cycle_s: f64,
    /// Steps of a cycle.
    steps: f64,
}

impl Docked {
    /// Nothing has touched yet. Settings out of range, which a model file cannot have, are left out.
    pub fn new(settings: &[DockingSettings], cycle_s: f64) -> Self {
        let longest = settings.iter().map(|d| d.kind.longest_step_s());
        let longest_s = longest.fold(cycle_s, f64::min);
        Self {
            steps: (cycle_s / longest_s).ceil().max(1.0),
            dockings: settings.iter().flat_map(Docking::new).collect(),
            last: None,
            cycle_s,
        }
    }

    /// The wrench at M in axes of M of every cycle; empty without a mechanism.
    pub fn over(
        settings: &[DockingSettings],
        cycle_s: f64,
        pose: &[Pose<f64>],
        motion: &[Motion<f64>],
    ) -> Vec<Wrench<f64>> {
        let mut docked = Self::new(settings, cycle_s);
        if docked.is_empty() {
            return Vec::new();
        }
        let cycles = pose.iter().zip(motion);
        let at = |(pose, motion): (_, &Motion<f64>)| {
            docked.advance(pose);
            docked.wrench(pose, &motion.velocity)
        };
        cycles.map(at).collect()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.dockings.is_empty()
    }

    /// Moves on to the pose of the next cycle, straight and evenly.
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

    /// What they do at M, in axes of M, for a pose and a twist of M.
    pub fn wrench(&self, pose: &Pose<f64>, twist: &Twist<f64>) -> Wrench<f64> {
        let all = self.dockings.iter().map(|d| d.wrench(pose, twist));
        all.fold(Wrench::zero(), |sum, wrench| sum + wrench)
    }

    /// The wrench's noise by that of each component of position (m) and velocity (m/s) of M.
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
