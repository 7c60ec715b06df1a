//! A guide that centres the tip across an axis.

use super::tip_motion;
use crate::model::GuideModel;
use nalgebra::Vector3;
use softdock_control::frames::{Pose, Twist, vector};

/// `F = −(k (tip − point) + c v_tip)` without its component along the axis.
pub struct Guide {
    /// The free direction, in C.
    pub axis: Vector3<f64>,
    /// A point of it in C, m.
    pub point: Vector3<f64>,
    /// The guided point in M, m.
    pub tip: Vector3<f64>,
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Damping, N·s/m.
    pub damping: f64,
}

impl Guide {
    /// Ready to run.
    pub fn new(model: &GuideModel) -> Self {
        Self {
            axis: vector::<f64>(&model.axis).normalize(),
            point: vector(&model.point_m),
            tip: vector(&model.tip_m),
            stiffness: model.stiffness_n_per_m,
            damping: model.damping_n_s_per_m,
        }
    }

    /// Force on the tip in C.
    pub fn force(&self, pose: &Pose<f64>, velocity: &Twist<f64>) -> Vector3<f64> {
        let (tip, tip_velocity) = tip_motion(pose, velocity, &self.tip);
        let pull = (tip - self.point) * self.stiffness + tip_velocity * self.damping;
        self.axis * pull.dot(&self.axis) - pull
    }
}
