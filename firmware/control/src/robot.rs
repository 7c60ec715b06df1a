//! What the control cycle must know of a robot's interface; the robot's link provides it.

use crate::frames::vector;
use crate::scalar::Scalar;
use nalgebra::UnitQuaternion;

/// The robot's interface, as far as the cycle depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotInterface {
    /// Time between two telegrams, s. The robot is the clock.
    pub cycle_s: f64,
    /// Orientations that cannot be commanded; `None` for a robot that takes quaternions or twists.
    pub gimbal_lock: Option<GimbalLock>,
}

/// Where the three angles of a robot's orientation are not defined.
///
/// For any convention of the angles these are the orientations with one axis of M along an axis of C, in either direction. Near
/// them a small rotation takes a large step of two angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GimbalLock {
    /// Axis of M, a unit vector.
    pub axis_in_m: [f64; 3],
    /// Axis of C, a unit vector.
    pub axis_in_c: [f64; 3],
    /// Largest angle of the axis of M out of the plane perpendicular to the axis of C, rad, below π/2.
    pub largest_angle_rad: f64,
}

impl GimbalLock {
    /// Sine of the angle between the axis of M and the plane perpendicular to the axis of C, not negative.
    pub(crate) fn sine<S: Scalar>(&self, orientation: &UnitQuaternion<S>) -> S {
        let axis_in_c = orientation * vector(&self.axis_in_m);
        axis_in_c.dot(&vector(&self.axis_in_c)).abs()
    }

    /// Sine of the largest angle, less a margin in rad.
    pub(crate) fn largest_sine<S: Scalar>(&self, margin_rad: f64) -> S {
        S::of(nalgebra::ComplexField::sin(
            self.largest_angle_rad - margin_rad,
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::orientation_from_abc;

    /// The middle one of three angles about z, y and x is the angle of x out of the plane across z.
    #[test]
    fn the_sine_is_that_of_the_middle_angle() {
        let lock = GimbalLock {
            axis_in_m: [1.0, 0.0, 0.0],
            axis_in_c: [0.0, 0.0, 1.0],
            largest_angle_rad: 1.4,
        };
        for b in [-1.5, -0.3, 0.0, 1.4] {
            let orientation = orientation_from_abc::<f64>(&[0.7, b, -2.0]);
            assert!((lock.sine(&orientation) - f64::abs(f64::sin(b))).abs() < 1e-15);
        }
        assert!((lock.largest_sine::<f64>(0.4) - f64::sin(1.0)).abs() < 1e-15);
    }
}
