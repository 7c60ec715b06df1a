//! A contact whose stiffness changes with its depth: a parabola through its loads.
//!
//! ```text
//! λ = b + k s + q s²        s: way into the contact since the first load
//! ```
//!
//! by least squares, beside the contact estimator, whose spring is straight. Impulse matching takes it where it leaves less than
//! half of what the spring leaves (rms), and that is more than the error that is expected of a load.

use super::contact_estimator::Estimate;
use super::least_squares::Ldlt;
use super::tuning::*;
use nalgebra::{ComplexField, SMatrix, SVector};

type V3 = SVector<f64, 3>;

/// Sums of the normal equations.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stiffening {
    /// Σ sⁿ, n = 0 to 4.
    powers: [f64; 5],
    /// Σ λ sⁿ, n = 0 to 2, and Σ λ².
    with_load: [f64; 3],
    load_squared: f64,
}

/// Load over depth: k δ + q δ².
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    /// Depth at which the estimator's spring is free, where the parabola is, m.
    pub(super) surface: f64,
    /// k, N/m, and q, N/m².
    pub(super) stiffness: f64,
    pub(super) stiffening: f64,
}

impl Stiffening {
    /// A load (N) at a way into the contact (m).
    pub(super) fn add(&mut self, way: f64, load: f64) {
        let mut power = 1.0;
        for (n, sum) in self.powers.iter_mut().enumerate() {
            *sum += power;
            if let Some(product) = self.with_load.get_mut(n) {
                *product += power * load;
            }
            power *= way;
        }
        self.load_squared += load * load;
    }

    /// The parabola, if it is one; `origin` is the depth at the way 0, `sigma` the error that is expected of a load, N.
    pub(super) fn curve(&self, estimate: &Estimate, origin: f64, sigma: f64) -> Option<Curve> {
        let count = self.powers[0];
        if count < STIFFENING_LOADS
            || estimate.error < STIFFENING_SEEN * sigma
            || estimate.misfit > STIFFENING_MISFIT
        {
            return None;
        }
        let scale = ComplexField::sqrt(self.powers[2] / count).max(1e-9);
        let s = |n: usize| {
            let mut value = self.powers[n];
            for _ in 0..n {
                value /= scale;
            }
            value
        };
        let mut matrix = SMatrix::<f64, 3, 3>::zeros();
        for i in 0..3 {
            for j in 0..=i {
                matrix[(i, j)] = s(i + j);
            }
        }
        let [l0, l1, l2] = self.with_load;
        let target = V3::new(l0, l1 / scale, l2 / (scale * scale));
        let unknowns = Ldlt::new(matrix).solve(&target);
        let left = (self.load_squared - unknowns.dot(&target)).max(0.0);
        if left > STIFFENING_LEAVES * count * estimate.error * estimate.error {
            return None;
        }
        let (b, k, q) = (
            unknowns[0],
            unknowns[1] / scale,
            unknowns[2] / (scale * scale),
        );
        // The way at which the load is zero; the vertex if it never is.
        let root = k * k - 4.0 * q * b;
        let way = if root > 0.0 {
            2.0 * b / (-k - ComplexField::sqrt(root))
        } else {
            -k / (2.0 * q)
        };
        let stiffness = (k + 2.0 * q * way).max(0.0);
        Some(Curve {
            surface: origin + way,
            stiffness,
            stiffening: q,
        })
    }
}
