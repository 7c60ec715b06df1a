//! Small least-squares problems: factorisation of normal equations, and shrinkage of an estimate that is not significant.

use nalgebra::{SMatrix, SVector};

/// A = L D Lᵀ of a positive definite matrix, without square roots.
#[derive(Clone, Debug)]
pub(super) struct Ldlt<const N: usize> {
    lower: SMatrix<f64, N, N>,
    inverse_diagonal: SVector<f64, N>,
}

impl<const N: usize> Ldlt<N> {
    /// Only the lower triangle is read; L is stored in place of it, below the diagonal. An unknown whose pivot is not positive is
    /// set to zero.
    pub(super) fn new(mut lower: SMatrix<f64, N, N>) -> Self {
        let mut inverse_diagonal = SVector::<f64, N>::zeros();
        // Row j of L D, so that each product is computed once.
        let mut scaled = SVector::<f64, N>::zeros();
        let mut diagonal = SVector::<f64, N>::zeros();
        for j in 0..N {
            let mut pivot = lower[(j, j)];
            for k in 0..j {
                scaled[k] = lower[(j, k)] * diagonal[k];
                pivot -= lower[(j, k)] * scaled[k];
            }
            diagonal[j] = pivot;
            inverse_diagonal[j] = if pivot > 0.0 { 1.0 / pivot } else { 0.0 };
            for i in j + 1..N {
                let mut sum = lower[(i, j)];
                for k in 0..j {
                    sum -= lower[(i, k)] * scaled[k];
                }
                lower[(i, j)] = sum * inverse_diagonal[j];
            }
        }
        Self {
            lower,
            inverse_diagonal,
        }
    }

    /// The x of A x = b.
    pub(super) fn solve(&self, b: &SVector<f64, N>) -> SVector<f64, N> {
        let mut x = *b;
        for i in 0..N {
            for k in 0..i {
                x[i] -= self.lower[(i, k)] * x[k];
            }
        }
        x.component_mul_assign(&self.inverse_diagonal);
        for i in (0..N).rev() {
            for k in i + 1..N {
                x[i] -= self.lower[(k, i)] * x[k];
            }
        }
        x
    }
}

/// An estimate shrunk towards zero by its variance; zero within so many standard deviations of it
/// (positive-part James-Stein).
pub(super) fn shrunk(estimate: f64, variance: f64, significance: f64) -> f64 {
    let squared = (estimate * estimate).max(f64::MIN_POSITIVE);
    let doubt = significance * significance * variance / squared;
    estimate * (1.0 - doubt).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_solves_the_equations() {
        let rows = SMatrix::<f64, 9, 6>::from_fn(|i, j| ((i * i + 3 * j * j + i * j) as f64).sin());
        let a = rows.transpose() * rows;
        let b = SVector::<f64, 6>::from_fn(|i, _| i as f64 - 2.0);
        let left = a * Ldlt::new(a.lower_triangle()).solve(&b) - b;
        assert!(left.amax() < 1e-9, "{left}");
    }

    #[test]
    fn an_unknown_of_which_nothing_is_known_is_zero() {
        for (second, x) in [(1.0, [2.0, 0.0]), (0.5, [2.0, 0.0]), (3.0, [2.5, -0.5])] {
            let a = SMatrix::<f64, 2, 2>::new(1.0, 0.0, 1.0, second);
            let b = SVector::<f64, 2>::new(2.0, 1.0);
            let found = Ldlt::new(a).solve(&b);
            // Without a positive second pivot the second unknown is zero, and the first solves its own equation.
            let expected = if second > 1.0 { x } else { [b[0], 0.0] };
            assert!(
                (found - SVector::from(expected)).amax() < 1e-12,
                "{second}: {found}"
            );
        }
    }

    #[test]
    fn an_estimate_is_shrunk_by_what_is_not_significant_of_it() {
        for (estimate, variance, significance, left) in [
            (3.0, 1.0, 2.0, 5.0 / 3.0),
            (-3.0, 1.0, 2.0, -5.0 / 3.0),
            (3.0, 4.0, 1.0, 5.0 / 3.0),
            (0.5, 0.0, 2.0, 0.5),
            (0.5, 0.25, 1.0, 0.0),
            (1.0, 0.25, 3.0, 0.0),
            (0.0, 1.0, 2.0, 0.0),
        ] {
            let found = shrunk(estimate, variance, significance);
            assert!(
                (found - left).abs() < 1e-15,
                "{estimate} {variance}: {found}"
            );
        }
    }
}
