//! Contact with a wall over a log.

use super::Wall;
use nalgebra::Vector3;
use softdock_control::frames::Pose;
use softdock_control::wrench::Motion;

/// Contact of the tip with one wall over a log.
#[derive(Clone, Debug)]
pub struct Touch {
    /// Number of the wall in the model, from 1.
    pub number: usize,
    /// Out of the wall, in C.
    pub normal: Vector3<f64>,
    /// The point that touches, in M.
    pub tip: Vector3<f64>,
    /// Penetration, m; negative out of contact.
    pub penetration: Vec<f64>,
    /// Its rate, m/s.
    pub rate: Vec<f64>,
    /// Nominal force, N.
    pub force: Vec<f64>,
    /// Nominal stiffness, N/m.
    pub stiffness: f64,
    /// Nominal damping, N·s/m.
    pub damping: f64,
    /// Penetration at which the damping acts in full, m.
    pub damping_depth: f64,
}

impl Touch {
    /// Share of the damping that acts at a depth, 0 to 1.
    pub fn onset(&self, depth: f64) -> f64 {
        if self.damping_depth > 0.0 {
            (depth / self.damping_depth).min(1.0)
        } else {
            1.0
        }
    }

    /// Force of the nominal wall at a depth in a cycle, N; negative where it would pull, which the caller has to clip.
    pub fn push_at(&self, n: usize, depth: f64) -> f64 {
        if depth <= 0.0 {
            return 0.0;
        }
        self.stiffness * depth + self.damping * self.onset(depth) * self.rate[n]
    }

    /// Contact with a wall over a motion.
    pub(super) fn of(
        wall: &Wall,
        number: usize,
        pose: &[Pose<f64>],
        motion: &[Motion<f64>],
    ) -> Self {
        let both = pose.iter().zip(motion);
        let at: Vec<(f64, f64)> = both
            .map(|(pose, motion)| wall.penetration(pose, &motion.velocity))
            .collect();
        Self {
            number,
            normal: wall.normal,
            tip: wall.tip,
            force: at.iter().map(|(p, r)| wall.force_at(*p, *r)).collect(),
            penetration: at.iter().map(|a| a.0).collect(),
            rate: at.iter().map(|a| a.1).collect(),
            stiffness: wall.stiffness,
            damping: wall.damping,
            damping_depth: wall.damping_depth,
        }
    }
}
