//! Relative motion of the two docking frames.

use nalgebra::Vector3;
use softdock_control::frames::{Pose, Twist, Wrench};

/// Pose and twist of the moving side's docking frame J relative to the target's, P.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// Pose of J in P, m.
    pub p_from_j: Pose<f64>,
    /// Twist of J relative to P: linear in axes of P (m/s), angular in axes of J (rad/s).
    pub twist: Twist<f64>,
}

impl Relative {
    /// Motion of J along x of P without rotation: depth (m) and its rate (m/s).
    pub fn along_x(depth_m: f64, rate_m_s: f64) -> Self {
        Self {
            p_from_j: Pose::translation(depth_m, 0.0, 0.0),
            twist: Twist {
                linear: Vector3::new(rate_m_s, 0.0, 0.0),
                angular: Vector3::zeros(),
            },
        }
    }

    /// Velocity relative to P of the point of J that is at `point` (axes of P, m), m/s.
    pub fn velocity_at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let lever = point - self.p_from_j.translation.vector;
        let turning = self.p_from_j.rotation * self.twist.angular;
        self.twist.linear + turning.cross(&lever)
    }

    /// A force on J at `point`, both in axes of P, as a wrench at J in axes of J.
    pub fn push(&self, point: &Vector3<f64>, force: &Vector3<f64>) -> Wrench<f64> {
        let lever = point - self.p_from_j.translation.vector;
        let j_from_p = self.p_from_j.rotation.inverse();
        Wrench {
            force: j_from_p * force,
            torque: j_from_p * lever.cross(force),
        }
    }

    /// Power of a wrench at J, in axes of J, W.
    pub fn power(&self, wrench: &Wrench<f64>) -> f64 {
        let linear_in_j = self.p_from_j.rotation.inverse() * self.twist.linear;
        wrench.force.dot(&linear_in_j) + wrench.torque.dot(&self.twist.angular)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_control::frames::orientation_from_abc;

    /// Force times velocity of its point equals wrench times twist.
    #[test]
    fn power_is_the_same_at_the_point_and_at_j() {
        let at = Relative {
            p_from_j: Pose::from_parts(
                Vector3::new(0.1, -0.2, 0.3).into(),
                orientation_from_abc(&[0.3, -0.7, 1.1]),
            ),
            twist: Twist::of(&[0.01, -0.02, 0.03, 0.4, -0.5, 0.6]),
        };
        let (point, force) = (Vector3::new(0.2, 0.1, 0.5), Vector3::new(10.0, 20.0, -30.0));
        let power = force.dot(&at.velocity_at(&point));
        assert!((at.power(&at.push(&point, &force)) - power).abs() < 1e-12);
    }
}
