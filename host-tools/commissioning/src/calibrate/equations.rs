//! Readings of a rigid load, linear in the unknowns.
//!
//! With q = g − a (gravity less the acceleration of the sensor's origin), ω and α in axes of S, and
//! the load's mass m, first moment h = m c, inertia J about the sensor's origin, and zero b:
//!
//! ```text
//! F = m q − α × h − ω × (ω × h) + b_F
//! T = h × q − J α − ω × J ω + b_T
//! ```
//!
//! which is `weight + inertial wrench + bias` of `softdock_control::wrench` by the parallel-axis
//! theorem. The direction of gravity enters through a small turn δ of it about two axes across:
//! `q' = q + R (δ × g)`, with the mass and moment of the last step.

use super::gravity::Gravity;
use super::observation::Observation;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Index of the mass among the unknowns.
pub(super) const MASS: usize = 0;
/// Index of the first moment.
pub(super) const MOMENT: usize = 1;
/// Index of the zero.
pub(super) const BIAS: usize = 4;
/// Unknowns of a load at rest.
pub(super) const AT_REST: usize = 10;
/// Components of the inertia: xx, yy, zz, xy, xz, yz.
pub(super) const INERTIA: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// What is not known besides mass, centre of mass and zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unknowns {
    /// The inertia tensor.
    pub inertia: bool,
    /// The direction of gravity.
    pub tilt: bool,
}

impl Unknowns {
    /// Their number.
    pub(super) fn count(&self) -> usize {
        self.tilt_at() + if self.tilt { 2 } else { 0 }
    }

    /// Index of the tilt.
    pub(super) fn tilt_at(&self) -> usize {
        AT_REST + if self.inertia { INERTIA.len() } else { 0 }
    }

    /// Unknowns that forces depend on.
    pub(super) fn of_forces(&self) -> usize {
        // Mass and three zeros; of a load in motion the moment, too.
        4 + if self.inertia { 3 } else { 0 } + if self.tilt { 2 } else { 0 }
    }

    /// Unknowns that only torques determine.
    pub(super) fn of_torques(&self) -> usize {
        if self.inertia { 9 } else { 6 }
    }
}

impl Observation {
    /// The coefficients of the unknowns in the three forces and three torques; for the tilt at the
    /// mass and moment of `values`.
    pub(super) fn rows(
        &self,
        unknowns: &Unknowns,
        gravity: &Gravity,
        values: &DVector<f64>,
    ) -> DMatrix<f64> {
        let s_from_c = self.c_from_s.inverse();
        let pull = s_from_c * gravity.vector - self.acceleration;
        let (omega, alpha) = (self.angular_velocity, self.angular_acceleration);
        let mut rows = DMatrix::zeros(6, unknowns.count());
        rows.fixed_view_mut::<3, 1>(0, MASS).copy_from(&pull);
        let spin = omega.cross_matrix();
        let turned = -alpha.cross_matrix() - spin * spin;
        rows.fixed_view_mut::<3, 3>(0, MOMENT).copy_from(&turned);
        // h × q = −q × h.
        rows.fixed_view_mut::<3, 3>(3, MOMENT)
            .copy_from(&-pull.cross_matrix());
        rows.fixed_view_mut::<6, 6>(0, BIAS).fill_with_identity();
        if unknowns.inertia {
            for (k, (i, j)) in INERTIA.into_iter().enumerate() {
                let mut unit = Matrix3::zeros();
                unit[(i, j)] = 1.0;
                unit[(j, i)] = 1.0;
                let torque = -(unit * alpha + omega.cross(&(unit * omega)));
                rows.fixed_view_mut::<3, 1>(3, AT_REST + k)
                    .copy_from(&torque);
            }
        }
        if unknowns.tilt {
            let mass = values[MASS];
            let moment = Vector3::new(values[MOMENT], values[MOMENT + 1], values[MOMENT + 2]);
            for (k, axis) in gravity.across().iter().enumerate() {
                let change = s_from_c * axis.cross(&gravity.vector);
                let column = unknowns.tilt_at() + k;
                rows.fixed_view_mut::<3, 1>(0, column)
                    .copy_from(&(change * mass));
                rows.fixed_view_mut::<3, 1>(3, column)
                    .copy_from(&moment.cross(&change));
            }
        }
        rows
    }

    /// What was read, as six numbers.
    pub(super) fn read(&self) -> DVector<f64> {
        DVector::from_row_slice(&self.wrench.get())
    }
}
