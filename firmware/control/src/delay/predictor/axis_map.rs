//! The robot's axes X Y Z A B C. The law works in these, as delay and pauses of the robot are those of its axes.
//!
//! Angles are multiplied by a length, and so become metres, and torques are divided by it and become forces. All six then have
//! similar magnitudes, and a contact off the centre has one direction in six dimensions.

use super::tuning::*;
use super::{M6, V6};
use crate::frames::{Pose, Twist, Wrench, abc_from_orientation};
use crate::scalar::Scalar;
use nalgebra::{ComplexField, Matrix3, Vector3};

/// The map between axes and body at one orientation.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisMap {
    /// ω in M = `body_from_axes` · (A', B', C').
    body_from_axes: Matrix3<f64>,
    axes_from_body: Matrix3<f64>,
    c_from_m: Matrix3<f64>,
}

impl AxisMap {
    /// At a pose with the angles A, B, C (rad).
    pub(super) fn at<S: Scalar>(pose: &Pose<S>, [_, b, c]: [f64; 3]) -> Self {
        let (sb, cb) = (ComplexField::sin(b), ComplexField::cos(b));
        let (sc, cc) = (ComplexField::sin(c), ComplexField::cos(c));
        let body_from_axes = Matrix3::new(-sb, 0.0, 1.0, cb * sc, cc, 0.0, cb * cc, -sc, 0.0);
        // B stays off ±90°, see `Refusal::OrientationSingular`.
        let safe = if cb.abs() < 1e-3 { 1e-3 } else { cb };
        let (along, across) = (sc / safe, cc / safe);
        let axes_from_body = Matrix3::new(
            0.0,
            along,
            across,
            0.0,
            cc,
            -sc,
            1.0,
            along * sb,
            across * sb,
        );
        Self {
            body_from_axes,
            axes_from_body,
            c_from_m: pose.rotation.to_rotation_matrix().matrix().map(S::get),
        }
    }

    /// Velocity of the axes, from linear in C and angular in M.
    pub(super) fn velocity<S: Scalar>(&self, twist: &Twist<S>) -> V6 {
        let [x, y, z, a, b, c] = twist.get();
        let rates = self.axes_from_body * Vector3::new(a, b, c) * ANGLE_LEVER_M;
        V6::new(x, y, z, rates.x, rates.y, rates.z)
    }

    /// The twist of a velocity of the axes.
    pub(super) fn twist<S: Scalar>(&self, v: &V6) -> Twist<S> {
        let spin = self.body_from_axes * Vector3::new(v[3], v[4], v[5]) / ANGLE_LEVER_M;
        Twist::of(&[v[0], v[1], v[2], spin.x, spin.y, spin.z])
    }

    /// Generalised forces on the axes of a wrench at M in axes of M.
    pub(super) fn load<S: Scalar>(&self, wrench: &Wrench<S>) -> V6 {
        let [x, y, z, a, b, c] = wrench.get();
        let (force, torque) = (self.c_from_m * Vector3::new(x, y, z), Vector3::new(a, b, c));
        let t = self.body_from_axes.transpose() * torque / ANGLE_LEVER_M;
        V6::new(force.x, force.y, force.z, t.x, t.y, t.z)
    }

    /// The wrench at M of generalised forces.
    pub(super) fn wrench<S: Scalar>(&self, load: &V6) -> Wrench<S> {
        let force = self.c_from_m.transpose() * Vector3::new(load[0], load[1], load[2]);
        let torque = Vector3::new(load[3], load[4], load[5]);
        let torque = self.axes_from_body.transpose() * torque * ANGLE_LEVER_M;
        Wrench::of(&[force.x, force.y, force.z, torque.x, torque.y, torque.z])
    }

    /// Velocity of the axes per generalised impulse, from the twist (linear in C, angular in M) per impulse at M in axes of M.
    pub(super) fn mobility(&self, of_wrench: &M6) -> M6 {
        let rates = self.axes_from_body * ANGLE_LEVER_M;
        let torques = self.axes_from_body.transpose() * ANGLE_LEVER_M;
        let mut velocity = M6::identity();
        velocity.fixed_view_mut::<3, 3>(3, 3).copy_from(&rates);
        let mut wrench = M6::zeros();
        let forces = self.c_from_m.transpose();
        wrench.fixed_view_mut::<3, 3>(0, 0).copy_from(&forces);
        wrench.fixed_view_mut::<3, 3>(3, 3).copy_from(&torques);
        velocity * of_wrench * wrench
    }
}

/// Positions of the axes (m; angles times the lever), and the angles A, B, C, rad.
pub(super) fn positions<S: Scalar>(pose: &Pose<S>) -> (V6, [f64; 3]) {
    let t = &pose.translation.vector;
    let abc = abc_from_orientation(&pose.rotation).map(S::get);
    let [a, b, c] = abc.map(|angle| angle * ANGLE_LEVER_M);
    (V6::new(t.x.get(), t.y.get(), t.z.get(), a, b, c), abc)
}

/// The same positions, with angles within half a turn of those of `near`.
pub(super) fn unwrapped(mut positions: V6, near: &V6) -> V6 {
    let turn = core::f64::consts::TAU * ANGLE_LEVER_M;
    for i in 3..6 {
        let turns = ComplexField::round((near[i] - positions[i]) / turn);
        positions[i] += turns * turn;
    }
    positions
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::advanced;
    use nalgebra::UnitQuaternion;

    fn pose(position: [f64; 3], [a, b, c]: [f64; 3]) -> Pose<f64> {
        Pose::from_parts(
            Vector3::from(position).into(),
            UnitQuaternion::from_euler_angles(c, b, a),
        )
    }

    fn map(pose: &Pose<f64>) -> AxisMap {
        AxisMap::at(pose, positions(pose).1)
    }

    /// Orientations with large angles about all axes.
    fn poses() -> [Pose<f64>; 4] {
        [
            pose([0.1, 0.2, 0.3], [0.0, 0.0, 0.0]),
            pose([-1.0, 0.5, 2.0], [0.7, -0.4, 1.1]),
            pose([0.0, 0.0, 1.0], [-2.5, 1.3, -2.0]),
            pose([0.3, -0.1, 0.0], [1.5, -1.2, 3.0]),
        ]
    }

    fn twist() -> Twist<f64> {
        Twist::of(&[0.01, -0.02, 0.03, 0.05, -0.04, 0.02])
    }

    #[test]
    fn the_velocity_of_the_axes_is_the_rate_of_their_positions() {
        for pose in poses() {
            let velocity = map(&pose).velocity(&twist());
            let (at, _) = positions(&pose);
            let later = positions(&advanced(&pose, &twist(), 1e-4)).0;
            let earlier = positions(&advanced(&pose, &twist(), -1e-4)).0;
            let rate = (later - earlier) / 2e-4;
            assert!((rate - velocity).amax() < 1e-7, "{pose}: {rate} {velocity}");
            assert_eq!(at.fixed_rows::<3>(0), pose.translation.vector);
            let back = map(&pose).twist::<f64>(&velocity).get();
            let apart = V6::from(back) - V6::from(twist().get());
            assert!(apart.amax() < 1e-15, "{apart}");
        }
    }

    /// A load of the axes does the work of its wrench.
    #[test]
    fn a_wrench_and_its_load_have_the_same_power() {
        let wrench = Wrench::of(&[3.0, -5.0, 2.0, 1.0, 0.5, -2.0]);
        for pose in poses() {
            let map = map(&pose);
            let load = map.load(&wrench);
            let force = pose.rotation * wrench.force;
            let power = force.dot(&twist().linear) + wrench.torque.dot(&twist().angular);
            let found = load.dot(&map.velocity(&twist()));
            assert!((found - power).abs() < 1e-14, "{found} {power}");
            let back = V6::from(map.wrench::<f64>(&load).get()) - V6::from(wrench.get());
            assert!(back.amax() < 1e-14, "{back}");
        }
    }

    /// Where A and C are the same axis their rates would be infinite.
    #[test]
    fn at_the_gimbal_lock_the_rates_of_the_axes_are_bounded() {
        for b in [90.0_f64, -90.0, 89.99] {
            let angles = [0.3, b.to_radians(), 0.2];
            let map = AxisMap::at(&pose([0.0; 3], angles), angles);
            let velocity = map.velocity(&twist());
            assert!(velocity.amax() < 1e3 * 0.07 * ANGLE_LEVER_M, "{velocity}");
        }
    }

    #[test]
    fn an_angle_goes_on_beyond_half_a_turn() {
        let at = |degrees: f64| V6::repeat(degrees.to_radians() * ANGLE_LEVER_M);
        for (measured, near, expected) in [
            (-179.0, 179.0, 181.0),
            (179.0, -179.0, -181.0),
            (10.0, 725.0, 730.0),
            (10.0, 20.0, 10.0),
        ] {
            let found = unwrapped(at(measured), &at(near));
            let kept = at(measured).fixed_rows::<3>(0).into_owned();
            assert_eq!(found.fixed_rows::<3>(0), kept);
            let angles = found.fixed_rows::<3>(3) - at(expected).fixed_rows::<3>(3);
            assert!(angles.amax() < 1e-12, "{measured} {near}: {found}");
        }
    }
}
