//! The tip of the mechanism on the moving frame M: how it moves, and what its force does at M.
//!
//! Not an effect by itself: every contact acts through it.

use crate::frames::{Pose, Twist, Wrench};
use crate::scalar::Scalar;
use nalgebra::{UnitQuaternion, Vector3};

/// Position (m) and velocity (m/s) of a tip, axes of C; `tip_m` in M.
///
/// `tip = p + R r_tip`, `v_tip = v + R (ω × r_tip)`, with the twist of M as [`Twist`] defines it.
pub fn tip_motion<S: Scalar>(
    c_from_m: &Pose<S>,
    twist: &Twist<S>,
    tip_m: &Vector3<S>,
) -> (Vector3<S>, Vector3<S>) {
    let position = c_from_m.translation.vector + c_from_m.rotation * tip_m;
    let velocity = twist.linear + c_from_m.rotation * twist.angular.cross(tip_m);
    (position, velocity)
}

/// Wrench at M's origin, in M axes, of a force (N, axes of C) that acts at the tip.
pub fn wrench_at_origin<S: Scalar>(
    orientation: &UnitQuaternion<S>,
    force_in_c: &Vector3<S>,
    tip_m: &Vector3<S>,
) -> Wrench<S> {
    let force = orientation.inverse_transform_vector(force_in_c);
    Wrench {
        force,
        torque: tip_m.cross(&force),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{orientation_from_abc, pose, vector};

    /// Force times tip velocity equals wrench times twist: the lever neither makes nor eats power.
    #[test]
    fn power_is_the_same_at_the_tip_and_at_the_origin() {
        let orientation = orientation_from_abc::<f64>(&[0.3, -0.7, 1.1]);
        let mut at = pose::<f64>(&[0.1, 0.2, 0.3], &[1.0, 0.0, 0.0, 0.0]);
        at.rotation = orientation;
        let twist = Twist::of(&[0.01, -0.02, 0.03, 0.4, -0.5, 0.6]);
        let (tip, force) = (vector(&[0.2, -0.1, 0.5]), vector(&[10.0, 20.0, -30.0]));
        let (_, velocity) = tip_motion(&at, &twist, &tip);
        let wrench = wrench_at_origin(&orientation, &force, &tip);
        let linear_in_m = orientation.inverse() * twist.linear;
        let power = wrench.force.dot(&linear_in_m) + wrench.torque.dot(&twist.angular);
        assert!((power - force.dot(&velocity)).abs() < 1e-12);
    }
}
