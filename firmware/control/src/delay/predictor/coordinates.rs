//! The coordinates in which the law works: the robot's axes X Y Z A B C, with the angles as lengths.
//!
//! The robot moves A, B and C, and its delay and pause are those of its axes. Multiplied by a
//! length, angles become metres, and torques forces: all six are then of one size, and a contact
//! beside the centre is a contact along one direction of six.

use super::{M6, V6};
use crate::frames::{Pose, Twist, Wrench, abc_from_orientation};
use crate::scalar::Scalar;
use nalgebra::{ComplexField, Matrix3, Vector3};

/// Metres per radian: the lever of a docking mechanism.
pub(super) const LEVER_M: f64 = 0.3;

/// The map between axes and body at an orientation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Map {
    /// ω in M = `body_from_axes` · (A', B', C').
    body_from_axes: Matrix3<f64>,
    axes_from_body: Matrix3<f64>,
}

impl Map {
    /// At A, B, C (rad).
    pub(super) fn at([_, b, c]: [f64; 3]) -> Self {
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
        }
    }

    /// Velocity of the axes, from linear in C and angular in M.
    pub(super) fn velocity<S: Scalar>(&self, twist: &Twist<S>) -> V6 {
        let [x, y, z, a, b, c] = twist.get();
        let rates = self.axes_from_body * Vector3::new(a, b, c) * LEVER_M;
        V6::new(x, y, z, rates.x, rates.y, rates.z)
    }

    /// The twist of a velocity of the axes.
    pub(super) fn twist<S: Scalar>(&self, v: &V6) -> Twist<S> {
        let spin = self.body_from_axes * Vector3::new(v[3], v[4], v[5]) / LEVER_M;
        Twist::of(&[v[0], v[1], v[2], spin.x, spin.y, spin.z])
    }

    /// Generalised forces of a wrench with the force in C and the torque in M.
    fn forces(&self, force_c: &Vector3<f64>, torque: &Vector3<f64>) -> V6 {
        let t = self.body_from_axes.transpose() * torque / LEVER_M;
        V6::new(force_c.x, force_c.y, force_c.z, t.x, t.y, t.z)
    }

    /// Generalised forces of a wrench at M in axes of M.
    pub(super) fn load<S: Scalar>(&self, wrench: &Wrench<S>, c_from_m: &Matrix3<f64>) -> V6 {
        let [x, y, z, a, b, c] = wrench.get();
        self.forces(&(c_from_m * Vector3::new(x, y, z)), &Vector3::new(a, b, c))
    }

    /// The wrench at M of generalised forces.
    pub(super) fn wrench<S: Scalar>(&self, load: &V6, c_from_m: &Matrix3<f64>) -> Wrench<S> {
        let force = c_from_m.transpose() * Vector3::new(load[0], load[1], load[2]);
        let torque =
            self.axes_from_body.transpose() * Vector3::new(load[3], load[4], load[5]) * LEVER_M;
        Wrench::of(&[force.x, force.y, force.z, torque.x, torque.y, torque.z])
    }

    /// Velocity of the axes per generalised impulse, from that of a twist (linear in C, angular in
    /// M) per impulsive wrench at M in axes of M.
    pub(super) fn mobility(&self, of_wrench: &M6, c_from_m: &Matrix3<f64>) -> M6 {
        let mut velocity = M6::identity();
        velocity
            .fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&(self.axes_from_body * LEVER_M));
        let mut wrench = M6::zeros();
        wrench
            .fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&c_from_m.transpose());
        wrench
            .fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&(self.axes_from_body.transpose() * LEVER_M));
        velocity * of_wrench * wrench
    }
}

/// Positions of the axes: m, and m of the lever.
pub(super) fn positions<S: Scalar>(pose: &Pose<S>) -> (V6, [f64; 3]) {
    let t = &pose.translation.vector;
    let abc = abc_from_orientation(&pose.rotation).map(S::get);
    let [a, b, c] = abc.map(|angle| angle * LEVER_M);
    (V6::new(t.x.get(), t.y.get(), t.z.get(), a, b, c), abc)
}

/// The same positions with angles within half a turn of others.
pub(super) fn unwrapped(mut positions: V6, near: &V6) -> V6 {
    let turn = core::f64::consts::TAU * LEVER_M;
    for i in 3..6 {
        let turns = ComplexField::round((near[i] - positions[i]) / turn);
        positions[i] += turns * turn;
    }
    positions
}
