//! Pose and velocity of the flange from the robot's axes.

use crate::Axes;
use nalgebra::{Rotation3, Vector3};

/// Pose and velocity of the flange M in the laboratory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotPose {
    /// Origin of M, m.
    pub position: Vector3<f64>,
    /// Axes of M in the laboratory.
    pub rotation: Rotation3<f64>,
    /// Velocity of the origin, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity in the laboratory, rad/s.
    pub spin: Vector3<f64>,
}

impl RobotPose {
    /// From positions (m, rad) and velocities (m/s, rad/s) of X Y Z A B C.
    pub fn new(position: &Axes, velocity: &Axes) -> Self {
        let [x, y, z, a, b, c] = *position;
        let [vx, vy, vz, da, db, dc] = *velocity;
        let about_z = Rotation3::from_axis_angle(&Vector3::z_axis(), a);
        let about_y = Rotation3::from_axis_angle(&Vector3::y_axis(), b);
        let about_x = Rotation3::from_axis_angle(&Vector3::x_axis(), c);
        let spin = Vector3::z() * da
            + about_z * (Vector3::y() * db)
            + about_z * (about_y * (Vector3::x() * dc));
        Self {
            position: Vector3::new(x, y, z),
            rotation: about_z * about_y * about_x,
            velocity: Vector3::new(vx, vy, vz),
            spin,
        }
    }

    /// Position and velocity of a point that is fixed to the flange (m, in M).
    pub fn point(&self, in_m: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let arm = self.rotation * in_m;
        (self.position + arm, self.velocity + self.spin.cross(&arm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spin_is_the_derivative_of_the_rotation() {
        let at = [0.1, 0.2, 0.3, 0.4, -0.5, 0.6];
        let rate = [0.01, 0.02, -0.03, 0.7, -0.8, 0.9];
        let h = 1e-6;
        let later: Axes = std::array::from_fn(|i| at[i] + h * rate[i]);
        let (now, then) = (RobotPose::new(&at, &rate), RobotPose::new(&later, &rate));
        let skew = (then.rotation.matrix() - now.rotation.matrix()) / h
            * now.rotation.matrix().transpose();
        let turned = Vector3::new(skew.m32, skew.m13, skew.m21);
        assert!((turned - now.spin).norm() < 1e-5);
        let probe = Vector3::new(0.3, -0.2, 0.1);
        let moved = (then.point(&probe).0 - now.point(&probe).0) / h;
        assert!((moved - now.point(&probe).1).norm() < 1e-5);
    }
}
