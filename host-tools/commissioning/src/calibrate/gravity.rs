//! The direction of gravity in C, where it is known or has to be found.

use super::observation::Group;
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};

/// Gravity in C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gravity {
    /// m/s².
    pub vector: Vector3<f64>,
}

impl Gravity {
    pub(super) fn new(vector: [f64; 3]) -> Self {
        Self {
            vector: vector.into(),
        }
    }

    /// Two directions across it.
    pub(super) fn across(&self) -> [Vector3<f64>; 2] {
        let down = self.vector.normalize();
        // The axis of C that is farthest from it.
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let farthest = axes
            .into_iter()
            .min_by(|a, b| a.dot(&down).abs().total_cmp(&b.dot(&down).abs()))
            .unwrap_or_else(Vector3::x);
        let first = down.cross(&farthest).normalize();
        [first, down.cross(&first)]
    }

    /// Turned by two small angles about [`Self::across`], rad.
    pub(super) fn turned(&self, angles: [f64; 2]) -> Self {
        let [first, second] = self.across();
        let turn = UnitQuaternion::from_scaled_axis(first * angles[0] + second * angles[1]);
        Self {
            vector: turn * self.vector,
        }
    }

    /// A first guess of its direction with this length, from forces alone: `F = R⁻¹ w + b` is
    /// linear in the weight w in C and the zero b. A direction that cannot be computed stays.
    pub(super) fn found_in(&self, groups: &[Group]) -> Self {
        let observations: Vec<_> = groups.iter().flat_map(|g| &g.observations).collect();
        let mut rows = DMatrix::zeros(3 * observations.len(), 6);
        let mut forces = DVector::zeros(3 * observations.len());
        for (n, observation) in observations.iter().enumerate() {
            let s_from_c = observation.c_from_s.inverse().to_rotation_matrix();
            rows.fixed_view_mut::<3, 3>(3 * n, 0)
                .copy_from(s_from_c.matrix());
            rows.fixed_view_mut::<3, 3>(3 * n, 3).fill_with_identity();
            forces
                .fixed_rows_mut::<3>(3 * n)
                .copy_from(&observation.wrench.force);
        }
        let solved = rows.svd(true, true).solve(&forces, 1e-9).ok();
        let weight = solved.map(|x| Vector3::new(x[0], x[1], x[2]));
        match weight.and_then(|w| w.try_normalize(1e-9)) {
            Some(down) => Self {
                vector: down * self.vector.norm(),
            },
            None => *self,
        }
    }
}
