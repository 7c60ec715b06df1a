//! A contact whose stiffness changes with its depth: a parabola through its loads.
//!
//! ```text
//! λ = b + k s + q s²        s: way into the contact since the first load
//! ```
//!
//! by least squares, beside the contact estimator, whose spring is linear. Impulse matching uses the parabola where it leaves
//! less than half of the spring's residual (rms), and that residual exceeds the expected error of a load.

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
    /// Position of the surface, m: δ counts from here. The parabola is zero here, or has its vertex if it never is.
    pub(super) surface: f64,
    /// k, N/m, and q, N/m².
    pub(super) stiffness: f64,
    pub(super) stiffening: f64,
}

impl Stiffening {
    /// Adds a load (N) at a displacement into the contact (m).
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

    /// The parabola; `None` if a linear spring does. `origin` is the position of the first load along the contact, m, `sigma` the
    /// expected error of a load, N.
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
        // Displacement at which the load is zero; the vertex if it never is.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected error of a load, N, and the position of the first load, m.
    const SIGMA: f64 = 0.1;
    const ORIGIN: f64 = 0.3;
    const LOADS: usize = 12;

    /// b, k and q: N, N/m, N/m².
    type Parabola = [f64; 3];
    /// A contact that hardens from 220 to 820 N/mm over the displacements below.
    const HARDENING: Parabola = [20.0, 220_500.0, 3e8];

    fn load([b, k, q]: Parabola, way: f64) -> f64 {
        b + (k + q * way) * way
    }

    /// Displacements of 0 to 1 mm.
    fn way(n: usize, loads: usize) -> f64 {
        1e-3 * n as f64 / (loads - 1) as f64
    }

    /// Loads on a parabola, plus a cubic of this size (rms, N) that is orthogonal to any parabola.
    fn loads(parabola: Parabola, loads: usize, beside: f64) -> Stiffening {
        let middle = 0.5 * (loads - 1) as f64;
        let powers = |n: i32| -> f64 { (0..loads).map(|i| (i as f64 - middle).powi(n)).sum() };
        let linear = powers(4) / powers(2);
        let cubic = |i: usize| {
            let x = i as f64 - middle;
            x * (x * x - linear)
        };
        let squares: f64 = (0..loads).map(|i| cubic(i) * cubic(i)).sum();
        let size = beside * (loads as f64 / squares).sqrt();
        let mut stiffening = Stiffening::default();
        for i in 0..loads {
            let way = way(i, loads);
            stiffening.add(way, load(parabola, way) + size * cubic(i));
        }
        stiffening
    }

    /// The estimate of a linear spring, with its residual: rms, N, and as a fraction of the load.
    fn spring(error: f64, misfit: f64) -> Estimate {
        let mut spring = Estimate::exact(220_500.0, 0.0, 500.0);
        (spring.error, spring.misfit) = (error, misfit);
        spring
    }

    #[test]
    fn the_curve_of_exact_loads_is_their_parabola_counted_from_where_it_is_free() {
        for parabola in [
            HARDENING,
            [20.0, 220_500.0, -6e7],
            [-5.0, 100_000.0, 1e8],
            [0.0, 50_000.0, 1e9],
            [-1.0, -20_000.0, 8e8],
        ] {
            let curve = loads(parabola, LOADS, 0.0).curve(&spring(1.0, 0.05), ORIGIN, SIGMA);
            let curve = curve.expect("a parabola");
            assert!(curve.stiffness > 0.0, "{parabola:?}: {curve:?}");
            assert!((curve.stiffening / parabola[2] - 1.0).abs() < 1e-9);
            for n in 0..LOADS {
                let way = way(n, LOADS);
                let depth = ORIGIN + way - curve.surface;
                let felt = (curve.stiffness + curve.stiffening * depth) * depth;
                let error = felt - load(parabola, way);
                assert!(error.abs() < 1e-6, "{parabola:?} at {way}: {error:e}");
            }
        }
    }

    /// At its vertex, −0.05 mm, the load is 7.5 N: that is taken as the surface.
    #[test]
    fn a_parabola_that_is_never_zero_is_free_at_its_vertex() {
        let loads = loads([10.0, 1e5, 1e9], LOADS, 0.0);
        let curve = loads.curve(&spring(1.0, 0.05), ORIGIN, SIGMA);
        let curve = curve.expect("a parabola");
        assert!((curve.surface - (ORIGIN - 5e-5)).abs() < 1e-12, "{curve:?}");
        assert!(curve.stiffness.abs() < 1e-3, "{curve:?}");
        assert!((curve.stiffening / 1e9 - 1.0).abs() < 1e-9, "{curve:?}");
    }

    #[test]
    fn fewer_than_eight_loads_are_no_parabola() {
        for count in 4..12 {
            let curve = loads(HARDENING, count, 0.0).curve(&spring(1.0, 0.05), ORIGIN, SIGMA);
            assert_eq!(curve.is_some(), count >= 8, "{count}");
        }
    }

    #[test]
    fn what_a_spring_explains_within_three_errors_of_a_load_is_a_spring() {
        for (errors, stiffens) in [(0.0, false), (2.99, false), (3.01, true), (30.0, true)] {
            let spring = spring(errors * SIGMA, 0.05);
            let curve = loads(HARDENING, LOADS, 0.0).curve(&spring, ORIGIN, SIGMA);
            assert_eq!(curve.is_some(), stiffens, "{errors}");
        }
    }

    #[test]
    fn what_a_spring_misses_by_more_than_a_tenth_is_no_parabola_either() {
        for (misfit, stiffens) in [(0.0, true), (0.099, true), (0.101, false), (1.0, false)] {
            let curve = loads(HARDENING, LOADS, 0.0).curve(&spring(1.0, misfit), ORIGIN, SIGMA);
            assert_eq!(curve.is_some(), stiffens, "{misfit}");
        }
    }

    #[test]
    fn a_parabola_leaves_less_than_half_of_what_the_spring_leaves() {
        for (part, stiffens) in [(0.0, true), (0.49, true), (0.51, false), (1.0, false)] {
            let left = 2.0;
            let beside = loads(HARDENING, LOADS, part * left);
            let curve = beside.curve(&spring(left, 0.05), ORIGIN, SIGMA);
            assert_eq!(curve.is_some(), stiffens, "{part}");
        }
    }

    /// The parabola leaves as much as the spring does.
    #[test]
    fn a_spring_with_loads_beside_it_is_not_taken_for_a_parabola() {
        let straight = [20.0, 220_500.0, 0.0];
        let curve = loads(straight, LOADS, 1.0).curve(&spring(1.0, 0.05), ORIGIN, SIGMA);
        assert!(curve.is_none(), "{curve:?}");
    }
}
