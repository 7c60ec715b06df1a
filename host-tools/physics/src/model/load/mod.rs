//! Everything that loads the sensor: contact, guide, weight and inertia of the tool, zero.

mod column;
mod docked;
pub mod effects;
mod filtered;
mod guide;
mod guided;
mod laws;
pub mod loaded;
mod scene;
mod touch;
mod turns;
mod wall;

pub use column::Column;
pub use docked::Docked;
pub use guide::Guide;
pub use laws::{in_motion, nominal_tool};
pub use scene::Scene;
pub use touch::Touch;
pub use turns::{
    Followed, angle_about, angles, count_turns, pose_of, positions, turn_between,
    turned_since_first,
};
pub use wall::Wall;

use crate::effects::sensor::tool::{LoadMotion, Tool};
use crate::model::Model;
use nalgebra::{UnitQuaternion, Vector3};
use softdock_control::frames::{self, Pose, Twist, Wrench, matrix, vector};
use softdock_control::wrench::Motion;

/// The nominal load of the sensor, ready to run.
pub struct LoadModel {
    /// The tool on the sensor.
    pub tool: Tool,
    /// Gravity in C, m/s².
    pub gravity: Vector3<f64>,
    /// Position of the sensor.
    pub m_from_s: Pose<f64>,
    /// Reading without load.
    pub bias: Wrench<f64>,
    /// Walls that the tip can touch.
    pub walls: Vec<Wall>,
    /// Guide that centres the tip.
    pub guide: Option<Guide>,
    /// The reading contains the tool's inertial wrench.
    pub inertial: bool,
}

impl LoadModel {
    /// From the nominal values of a model.
    pub fn new(model: &Model) -> Self {
        let settings = model.sensor_settings();
        Self {
            tool: Tool {
                mass_kg: settings.tool_mass_kg,
                com: vector(&settings.tool_com_m),
                inertia: matrix(&settings.tool_inertia_kg_m2),
            },
            gravity: vector(&settings.gravity_m_s2),
            m_from_s: frames::pose(&settings.position_m, &settings.orientation_wxyz),
            bias: Wrench::of(&settings.bias),
            walls: model.contact.walls.iter().map(Wall::new).collect(),
            guide: model.contact.guide.as_ref().map(Guide::new),
            inertial: model.tool.dynamic_compensation,
        }
    }

    /// Reading of the sensor in S (N, N·m) at a pose of M in C with this motion, without docking mechanisms, which have memory
    /// ([`Docked`]).
    pub fn wrench(&self, pose: &Pose<f64>, motion: &Motion<f64>) -> Wrench<f64> {
        let s_from_m = self.m_from_s.inverse();
        let mut wrench = self.free_wrench(pose, motion);
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

    /// Reading of the wrench of docking mechanisms at M in a cycle; zero without one.
    pub fn docked(&self, at_m: &[Wrench<f64>], n: usize) -> Wrench<f64> {
        let zero = Wrench::zero;
        at_m.get(n)
            .map_or_else(zero, |wrench| wrench.transferred(&self.m_from_s.inverse()))
    }

    /// The reading without contact and guide: zero, weight and inertia.
    fn free_wrench(&self, pose: &Pose<f64>, motion: &Motion<f64>) -> Wrench<f64> {
        let s_from_m = self.m_from_s.rotation.inverse();
        let gravity_in_s = s_from_m * (pose.rotation.inverse() * self.gravity);
        let at_rest = self.bias + self.tool.weight(&gravity_in_s);
        match self.inertial {
            true => at_rest + self.inertial_wrench(&pose.rotation, motion),
            false => at_rest,
        }
    }

    /// The force of contact and guide on the tip, N in C, from a reading.
    pub fn contact_force(
        &self,
        reading: &Wrench<f64>,
        pose: &Pose<f64>,
        motion: &Motion<f64>,
    ) -> Vector3<f64> {
        let contact = *reading - self.free_wrench(pose, motion);
        pose.rotation * contact.transferred(&self.m_from_s).force
    }

    /// Reading of the tool's inertia.
    fn inertial_wrench(&self, c_from_m: &UnitQuaternion<f64>, motion: &Motion<f64>) -> Wrench<f64> {
        let (velocity, acceleration) = (&motion.velocity, &motion.acceleration);
        let motion = LoadMotion::of_sensor(&self.m_from_s, c_from_m, velocity, acceleration);
        self.tool.inertial_wrench(&motion)
    }

    /// Variance of the reading that follows from an uncertain acceleration (one standard deviation of each axis). The inertial
    /// wrench is linear in it, and the orientation does not matter, because the noise of the three axes is the same. Zero where
    /// the reading has no inertia.
    pub fn inertial_variance(&self, acceleration_sigma: &[f64; 6]) -> [f64; 6] {
        let mut variance = [0.0; 6];
        for (i, sigma) in acceleration_sigma
            .iter()
            .enumerate()
            .filter(|_| self.inertial)
        {
            let mut acceleration = [0.0; 6];
            acceleration[i] = *sigma;
            let motion = Motion {
                velocity: Twist::zero(),
                acceleration: Twist::of(&acceleration),
            };
            let part = self
                .inertial_wrench(&UnitQuaternion::identity(), &motion)
                .get();
            variance.iter_mut().zip(part).for_each(|(v, p)| *v += p * p);
        }
        variance
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

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_control::frames::{orientation_from_abc, pose, vector};

    /// Force times tip velocity equals wrench times twist: the transfer conserves power.
    #[test]
    fn power_is_the_same_at_the_tip_and_at_the_origin() {
        let mut at = pose::<f64>(&[0.1, 0.2, 0.3], &[1.0, 0.0, 0.0, 0.0]);
        at.rotation = orientation_from_abc::<f64>(&[0.3, -0.7, 1.1]);
        let twist = Twist::of(&[0.01, -0.02, 0.03, 0.4, -0.5, 0.6]);
        let (tip, force) = (vector(&[0.2, -0.1, 0.5]), vector(&[10.0, 20.0, -30.0]));
        let (_, velocity) = tip_motion(&at, &twist, &tip);
        let wrench = on_tip(&at, &tip, &force);
        let linear_in_m = at.rotation.inverse() * twist.linear;
        let power = wrench.force.dot(&linear_in_m) + wrench.torque.dot(&twist.angular);
        assert!((power - force.dot(&velocity)).abs() < 1e-12);
    }
}
