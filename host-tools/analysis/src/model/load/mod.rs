//! Everything that loads the sensor: contact, guide, weight and inertia of the tool, zero.

pub mod effects;
mod guide;
mod scene;
mod wall;

pub use guide::Guide;
pub use scene::{Column, Scene, Touch};
pub use wall::Wall;

use crate::model::Model;
use nalgebra::{UnitQuaternion, Vector3};
use softdock_control::frames::{self, Pose, Twist, Wrench};
use softdock_control::wrench::{Compensation, Motion};

/// The nominal load of the sensor, ready to run.
pub struct LoadModel {
    /// Weight and inertia of the tool.
    pub compensation: Compensation<f64>,
    /// Position of the sensor.
    pub m_from_s: Pose<f64>,
    /// Reading without load.
    pub bias: Wrench<f64>,
    /// What the tip can touch.
    pub walls: Vec<Wall>,
    /// What centres the tip.
    pub guide: Option<Guide>,
    /// The reading contains the tool's inertial wrench.
    pub inertial: bool,
}

impl LoadModel {
    /// From the nominal values of a model.
    pub fn new(model: &Model) -> Self {
        let settings = model.sensor_settings();
        Self {
            compensation: Compensation::new(&settings),
            m_from_s: frames::pose(&settings.position_m, &settings.orientation_wxyz),
            bias: Wrench::of(&settings.bias),
            walls: model.contact.walls.iter().map(Wall::new).collect(),
            guide: model.contact.guide.as_ref().map(Guide::new),
            inertial: model.tool.dynamic_compensation,
        }
    }

    /// Reading of the sensor in S (N, N·m) at a pose of M in C with this motion.
    pub fn wrench(&self, pose: &Pose<f64>, motion: &Motion<f64>) -> Wrench<f64> {
        let s_from_m = self.m_from_s.inverse();
        let mut wrench = self.bias + self.compensation.gravity_wrench(&pose.rotation);
        if self.inertial {
            wrench = wrench + self.compensation.inertial_wrench(&pose.rotation, motion);
        }
        for wall in &self.walls {
            if let Some(force) = wall.force(pose, &motion.velocity) {
                wrench = wrench + on_tip(pose, &wall.tip, &force).transferred(&s_from_m);
            }
        }
        if let Some(guide) = &self.guide {
            let force = guide.force(pose, &motion.velocity);
            wrench = wrench + on_tip(pose, &guide.tip, &force).transferred(&s_from_m);
        }
        wrench
    }

    /// A force in C on a point of M, as a wrench in S.
    pub fn reading_of(
        &self,
        pose: &Pose<f64>,
        point_m: &Vector3<f64>,
        force_c: &Vector3<f64>,
    ) -> Wrench<f64> {
        on_tip(pose, point_m, force_c).transferred(&self.m_from_s.inverse())
    }
}

/// A force in C on a point of M, as a wrench at M in axes of M.
pub fn on_tip(pose: &Pose<f64>, tip: &Vector3<f64>, force_c: &Vector3<f64>) -> Wrench<f64> {
    let force = pose.rotation.inverse() * force_c;
    Wrench {
        force,
        torque: tip.cross(&force),
    }
}

/// Position and velocity of a point of M, in C.
pub fn tip_motion(
    pose: &Pose<f64>,
    velocity: &Twist<f64>,
    tip: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let rotation: &UnitQuaternion<f64> = &pose.rotation;
    (
        pose.translation.vector + rotation * tip,
        velocity.linear + rotation * velocity.angular.cross(tip),
    )
}
