//! Poses, twists, wrenches and the named frames of the rig. The frames are drawn here once;
//! everything else refers to this page.
//!
//! ```text
//!            simulated world                          laboratory
//!
//!    K  centre of mass, passive spacecraft          M  the same point K on the robot's flange
//!    |\                                        |\
//!    | \_ J  its docking surface (also N)      | \_ S  force/torque sensor
//!    |                                         |
//!    |  ^Q_K: K seen from Q   ==============>  |  ^C_M: what the robot is told to do
//!    |                                         |
//!    |  _ P  docking surface of Q              |
//!    | /                                       |
//!    |/                                        |
//!    Q  centre of mass, active spacecraft           Q  fixed to the floor
//!
//!    C  reference of all poses; inertial in the simulated world. In the laboratory it is the
//!       robot's BASE and is fixed to the ground A.
//! ```
//!
//! Both spacecraft move in the simulated world; the rig moves only K (as M) with respect to Q.
//!
//! Conventions: `x_from_y` maps coordinates of y into x. Quaternions are Hamilton, w first.
//! Linear velocity is expressed in C, angular velocity in the body's own axes (A17, A19: the
//! paper does not say). Roll-pitch-yaw of the robot is A, B, C, as KUKA's: rotation about z, then
//! the new y, then the new x.

use crate::scalar::Scalar;
use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Position (m) and orientation of one frame in another.
pub type Pose<S> = Isometry3<S>;

/// Linear velocity (m/s, in C) and angular velocity (rad/s, in body axes).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<S: Scalar> {
    /// Linear velocity, m/s, axes of C.
    pub linear: Vector3<S>,
    /// Angular velocity, rad/s, body axes.
    pub angular: Vector3<S>,
}

/// Force (N) and torque (N·m) at one point, in the axes of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<S: Scalar> {
    /// Force, N.
    pub force: Vector3<S>,
    /// Torque about the frame's origin, N·m.
    pub torque: Vector3<S>,
}

macro_rules! six_vector {
    ($name:ident, $first:ident, $second:ident) => {
        impl<S: Scalar> $name<S> {
            /// All six components zero.
            pub fn zero() -> Self {
                Self {
                    $first: Vector3::zeros(),
                    $second: Vector3::zeros(),
                }
            }
            /// From six SI numbers, x y z first.
            pub fn of(values: &[f64; 6]) -> Self {
                let [a, b, c, d, e, f] = *values;
                Self {
                    $first: vector(&[a, b, c]),
                    $second: vector(&[d, e, f]),
                }
            }
            /// As six SI numbers, x y z first.
            pub fn get(&self) -> [f64; 6] {
                let ([a, b, c], [d, e, f]) = (components(&self.$first), components(&self.$second));
                [a, b, c, d, e, f]
            }
            /// Applies `op` to both parts.
            pub fn map(&self, op: impl Fn(&Vector3<S>) -> Vector3<S>) -> Self {
                Self {
                    $first: op(&self.$first),
                    $second: op(&self.$second),
                }
            }
        }
        impl<S: Scalar> core::ops::Add for $name<S> {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self {
                    $first: self.$first + other.$first,
                    $second: self.$second + other.$second,
                }
            }
        }
        impl<S: Scalar> core::ops::Sub for $name<S> {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self {
                    $first: self.$first - other.$first,
                    $second: self.$second - other.$second,
                }
            }
        }
        impl<S: Scalar> core::ops::Mul<S> for $name<S> {
            type Output = Self;
            fn mul(self, factor: S) -> Self {
                Self {
                    $first: self.$first * factor,
                    $second: self.$second * factor,
                }
            }
        }
    };
}
six_vector!(Twist, linear, angular);
six_vector!(Wrench, force, torque);

impl<S: Scalar> Wrench<S> {
    /// The same wrench about the origin of frame a, in axes of a: `a_from_b` is b's pose in a.
    ///
    /// `F^a = R F^b`, `T^a = R T^b + p × F^a` (section 3.2; the lever takes the rotated force,
    /// A16).
    pub fn transferred(&self, a_from_b: &Pose<S>) -> Self {
        let force = a_from_b.rotation * self.force;
        let torque = a_from_b.rotation * self.torque + a_from_b.translation.vector.cross(&force);
        Self { force, torque }
    }

    /// The reaction to this wrench, which acts at a point A: the opposite wrench, about a point B with `b_minus_a` = r_B − r_A in
    /// the same axes.
    ///
    /// `F_B = −F_A`, `T_B = −T_A + (r_B − r_A) × F_A` (section 3.2; A15: with the other sign of
    /// the lever the pair would not cancel).
    pub fn reaction(&self, b_minus_a: &Vector3<S>) -> Self {
        Self {
            force: -self.force,
            torque: b_minus_a.cross(&self.force) - self.torque,
        }
    }
}

/// A vector from three SI numbers.
pub fn vector<S: Scalar>(values: &[f64; 3]) -> Vector3<S> {
    let [x, y, z] = *values;
    Vector3::new(S::of(x), S::of(y), S::of(z))
}

/// The three SI numbers of a vector.
pub fn components<S: Scalar>(v: &Vector3<S>) -> [f64; 3] {
    [v.x.get(), v.y.get(), v.z.get()]
}

/// A vector with each component kept within ±`limit`.
pub fn saturated<S: Scalar>(v: &Vector3<S>, limit: f64) -> Vector3<S> {
    let (least, most) = (S::of(-limit), S::of(limit));
    v.map(|c| c.clamp(least, most))
}

/// A matrix from three rows of SI numbers.
pub fn matrix<S: Scalar>(rows: &[[f64; 3]; 3]) -> Matrix3<S> {
    let [a, b, c] = rows;
    Matrix3::from_rows(&[
        vector::<S>(a).transpose(),
        vector::<S>(b).transpose(),
        vector::<S>(c).transpose(),
    ])
}

/// A pose from a position (m) and a quaternion (w x y z, normalised here; all zero is identity).
pub fn pose<S: Scalar>(position_m: &[f64; 3], quaternion_wxyz: &[f64; 4]) -> Pose<S> {
    let [w, x, y, z] = *quaternion_wxyz;
    let q = Quaternion::new(w, x, y, z);
    let unit = UnitQuaternion::try_new(q, 1e-9).unwrap_or_else(UnitQuaternion::identity);
    let q = Quaternion::new(S::of(unit.w), S::of(unit.i), S::of(unit.j), S::of(unit.k));
    Pose::from_parts(
        Translation3::from(vector(position_m)),
        UnitQuaternion::new_unchecked(q),
    )
}

/// Position (m) and quaternion (w x y z) of a pose.
pub fn pose_components<S: Scalar>(pose: &Pose<S>) -> [f64; 7] {
    let ([x, y, z], q) = (components(&pose.translation.vector), &pose.rotation);
    [x, y, z, q.w.get(), q.i.get(), q.j.get(), q.k.get()]
}

/// The pose of these components, the inverse of [`pose_components`]: the quaternion is not normalised.
pub fn pose_from_components<S: Scalar>(pose: &[f64; 7]) -> Pose<S> {
    let [x, y, z, w, i, j, k] = pose.map(S::of);
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
    Pose::from_parts(Translation3::new(x, y, z), rotation)
}

/// The rotation by a small rotation vector (rad), exact to 1e-10 up to 0.1 rad.
///
/// The increments of a cycle are tiny, and their squares vanish in fixed point: a general
/// exponential would divide by a zero norm there and lose slow rotations altogether. Series of
/// cos(θ/2) and sin(θ/2)/θ to θ⁴, then renormalised. (A20: the increments in the paper's pose
/// update are small-motion exponentials.)
pub fn small_rotation<S: Scalar>(rotation_vector_rad: &Vector3<S>) -> UnitQuaternion<S> {
    let squared = rotation_vector_rad.norm_squared();
    let (half, one) = (S::of(0.5), S::one());
    let w = one - squared * S::of(0.125) * (one - squared * S::of(1.0 / 48.0));
    let scale = half * (one - squared * S::of(1.0 / 24.0) * (one - squared * S::of(1.0 / 80.0)));
    renormalised(&Quaternion::from_parts(
        w,
        scaled(rotation_vector_rad, scale),
    ))
}

/// One Newton step towards unit length: keeps a product of near-unit quaternions at unit length indefinitely without a square
/// root.
pub fn renormalised<S: Scalar>(q: &Quaternion<S>) -> UnitQuaternion<S> {
    let excess = product(q, &q.conjugate()).w - S::one();
    let half = S::of(0.5).times(excess);
    UnitQuaternion::new_unchecked(Quaternion::from(q.coords.map(|c| c - c.times(half))))
}

/// Hamilton's product with each scalar product rounded to the nearest: 10⁹ roundings downwards would rotate a spacecraft that
/// does not rotate.
fn product<S: Scalar>(p: &Quaternion<S>, q: &Quaternion<S>) -> Quaternion<S> {
    let times = |a: S, b: S| a.times(b);
    Quaternion::new(
        times(p.w, q.w) - times(p.i, q.i) - times(p.j, q.j) - times(p.k, q.k),
        times(p.w, q.i) + times(p.i, q.w) + times(p.j, q.k) - times(p.k, q.j),
        times(p.w, q.j) - times(p.i, q.k) + times(p.j, q.w) + times(p.k, q.i),
        times(p.w, q.k) + times(p.i, q.j) - times(p.j, q.i) + times(p.k, q.w),
    )
}

/// A vector times a number, rounded to the nearest.
pub fn scaled<S: Scalar>(v: &Vector3<S>, factor: S) -> Vector3<S> {
    v.map(|c| c.times(factor))
}

/// Composition of an orientation with a small body-axes rotation, kept at unit length.
pub fn rotated<S: Scalar>(
    orientation: &UnitQuaternion<S>,
    rotation_vector_rad: &Vector3<S>,
) -> UnitQuaternion<S> {
    let turn = small_rotation(rotation_vector_rad);
    renormalised(&product(orientation.quaternion(), turn.quaternion()))
}

/// The angles A, B, C (rad) about z, y and x of an orientation: R = Rz(A) Ry(B) Rx(C), B in ±90°.
pub fn abc_from_orientation<S: Scalar>(orientation: &UnitQuaternion<S>) -> [S; 3] {
    let r = orientation.to_rotation_matrix();
    let across = (r[(0, 0)] * r[(0, 0)] + r[(1, 0)] * r[(1, 0)]).sqrt();
    [
        S::angle_of(r[(1, 0)], r[(0, 0)]),
        S::angle_of(-r[(2, 0)], across),
        S::angle_of(r[(2, 1)], r[(2, 2)]),
    ]
}

/// The orientation of the angles A, B, C (rad) about z, y and x: R = Rz(A) Ry(B) Rx(C).
pub fn orientation_from_abc<S: Scalar>(abc_rad: &[f64; 3]) -> UnitQuaternion<S> {
    let [a, b, c] = abc_rad.map(S::of);
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), a)
        * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), b)
        * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;
    use proptest::prelude::*;

    #[test]
    fn small_rotation_equals_the_exponential_and_survives_fixed_point() {
        for theta in [1e-6_f64, 1e-3, 0.01, 0.1] {
            let v = Vector3::new(0.6, -0.48, 0.64) * theta;
            let error = small_rotation(&v).angle_to(&UnitQuaternion::from_scaled_axis(v));
            assert!(error < 1e-9 * theta.max(1e-3), "{theta}: {error}");
        }
        let slow = small_rotation(&vector::<Fixed>(&[4e-6, 0.0, 0.0]));
        assert!((slow.i.get() - 2e-6).abs() < 1e-9);
    }

    #[test]
    fn a_quaternion_near_unit_length_comes_to_it() {
        let q = Quaternion::new(0.5, -0.5, 0.5, 0.5);
        for excess in [1e-4, -1e-4] {
            let length = renormalised(&(q * (1.0 + excess))).quaternion().norm();
            assert!((length - 1.0_f64).abs() < 2.0 * excess * excess, "{length}");
        }
    }

    proptest! {
        /// The pose of a record, and back.
        #[test]
        fn a_pose_is_its_components(at in prop::array::uniform3(-5.0..5.0f64),
                abc in prop::array::uniform3(-1.5..1.5f64)) {
            let pose = Pose::from_parts(vector(&at).into(), orientation_from_abc(&abc));
            prop_assert_eq!(pose_from_components::<f64>(&pose_components(&pose)), pose);
        }

        #[test]
        fn a_turn_in_the_own_axes_is_multiplied_from_the_right(
                abc in prop::array::uniform3(-1.5..1.5f64),
                turn in prop::array::uniform3(-0.05..0.05f64)) {
            let (before, turn) = (orientation_from_abc::<f64>(&abc), vector(&turn));
            let after = before * UnitQuaternion::from_scaled_axis(turn);
            prop_assert!(rotated(&before, &turn).angle_to(&after) < 1e-9);
        }

        /// A wrench has the same power at every point of a rigid body.
        #[test]
        fn a_transferred_wrench_has_the_same_power(w in prop::array::uniform6(-100.0..100.0f64),
                v in prop::array::uniform6(-1.0..1.0f64), p in prop::array::uniform3(-5.0..5.0f64),
                abc in prop::array::uniform3(-1.5..1.5f64)) {
            let a_from_b = Pose::from_parts(vector(&p).into(), orientation_from_abc(&abc));
            let (at_b, motion) = (Wrench::<f64>::of(&w), Twist::of(&v));
            let at_a = at_b.transferred(&a_from_b);
            // The motion of b, in its axes.
            let back = a_from_b.rotation.inverse();
            let linear = back * (motion.linear + motion.angular.cross(&vector(&p)));
            let angular = back * motion.angular;
            let in_b = at_b.force.dot(&linear) + at_b.torque.dot(&angular);
            let in_a = at_a.force.dot(&motion.linear) + at_a.torque.dot(&motion.angular);
            prop_assert!((in_a - in_b).abs() < 1e-9);
        }

        #[test]
        fn abc_round_trip(a in -3.1..3.1, b in -1.5..1.5, c in -3.1..3.1) {
            let back = abc_from_orientation(&orientation_from_abc::<f64>(&[a, b, c]));
            for (x, y) in back.iter().zip([a, b, c]) {
                prop_assert!((x - y).abs() < 1e-9);
            }
        }

        #[test]
        fn a_pair_cancels_about_any_point(w in prop::array::uniform6(-100.0..100.0f64),
                a in prop::array::uniform3(-5.0..5.0f64), b in prop::array::uniform3(-5.0..5.0f64),
                about in prop::array::uniform3(-5.0..5.0f64)) {
            let (ra, rb, o) = (vector::<f64>(&a), vector::<f64>(&b), vector::<f64>(&about));
            let action = Wrench::of(&w);
            let reaction = action.reaction(&(rb - ra));
            let moment = action.torque + (ra - o).cross(&action.force)
                + reaction.torque + (rb - o).cross(&reaction.force);
            prop_assert!(moment.norm() < 1e-9);
            prop_assert!((action.force + reaction.force).norm() == 0.0);
        }
    }
}
