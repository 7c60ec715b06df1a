//! An elastic, damped half space.

use super::tip_motion;
use crate::model::WallModel;
use nalgebra::Vector3;
use softdock_control::frames::{Pose, Twist, vector};

/// `F = n max(0, k p + c min(1, p/d) dp/dt)` on the tip.
pub struct Wall {
    /// A point of the surface in C, m.
    pub point: Vector3<f64>,
    /// Out of the wall, in C.
    pub normal: Vector3<f64>,
    /// The point that touches, in M, m.
    pub tip: Vector3<f64>,
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Damping, N·s/m.
    pub damping: f64,
    /// Penetration at which the damping acts in full, m.
    pub damping_depth: f64,
}

impl Wall {
    /// Ready to run.
    pub fn new(model: &WallModel) -> Self {
        Self {
            point: vector(&model.point_m),
            normal: vector::<f64>(&model.normal).normalize(),
            tip: vector(&model.tip_m),
            stiffness: model.stiffness_n_per_m,
            damping: model.damping_n_s_per_m,
            damping_depth: model.damping_depth_m,
        }
    }

    /// Penetration (m; negative out of contact) and its rate (m/s).
    pub fn penetration(&self, pose: &Pose<f64>, velocity: &Twist<f64>) -> (f64, f64) {
        let (tip, tip_velocity) = tip_motion(pose, velocity, &self.tip);
        (
            (self.point - tip).dot(&self.normal),
            -tip_velocity.dot(&self.normal),
        )
    }

    /// Share of the damping that acts at a penetration.
    pub fn damping_share(&self, penetration: f64) -> f64 {
        if self.damping_depth > 0.0 {
            (penetration / self.damping_depth).min(1.0)
        } else {
            1.0
        }
    }

    /// Size of the force at a penetration and its rate, N.
    pub fn force_at(&self, penetration: f64, rate: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        let damping = self.damping * self.damping_share(penetration);
        (self.stiffness * penetration + damping * rate).max(0.0)
    }

    /// Force on the tip in C; `None` out of contact.
    pub fn force(&self, pose: &Pose<f64>, velocity: &Twist<f64>) -> Option<Vector3<f64>> {
        let (penetration, rate) = self.penetration(pose, velocity);
        (penetration > 0.0).then(|| self.normal * self.force_at(penetration, rate))
    }
}
