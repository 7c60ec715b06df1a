//! A contact estimated from all its loads at once, by a dense QR decomposition: the reference for the tests of the recursive
//! estimator.

use super::V6;
use super::contact_estimator::{DAMPING, Estimate, OFFSET, Prior, UNKNOWNS, Unknowns};
use nalgebra::{SMatrix, SVector};

/// A least-squares problem with all information on a contact, in units of a load's error: rows, right side, the number of rows,
/// and how many of them are not prior.
pub(super) struct Batch {
    rows: SMatrix<f64, 80, UNKNOWNS>,
    right: SVector<f64, 80>,
    used: usize,
    data: usize,
}

impl Batch {
    pub(super) fn new() -> Self {
        Self {
            rows: SMatrix::zeros(),
            right: SVector::zeros(),
            used: 0,
            data: 0,
        }
    }

    pub(super) fn push(&mut self, row: Unknowns, right: f64, weight: f64) {
        self.rows.set_row(self.used, &(row.transpose() * weight));
        self.right[self.used] = right * weight;
        self.used += 1;
    }

    /// The prior: κ is k₀ h with a factor of two along h and a tenth across it, any damping up to critical, any offset.
    pub(super) fn push_prior(&mut self, prior: &Prior) {
        self.data = self.used;
        let (k0, sigma) = (prior.stiffness, prior.sigma);
        let size = prior.direction.norm();
        let unit = prior.direction / size;
        let of_kappa = |v: V6| Unknowns::from_fn(|i, _| if i < 6 { v[i] } else { 0.0 });
        self.push(of_kappa(unit), k0 * size, sigma / (2.0 * k0) / size);
        for i in 0..6 {
            let across = V6::ith(i, 1.0) - unit * unit[i];
            self.push(of_kappa(across), 0.0, sigma / (0.1 * k0) / size);
        }
        let mass = 1.0 / prior.direction.dot(&prior.mobility);
        let critical = 2.0 * (k0 * mass).sqrt();
        self.push(Unknowns::ith(DAMPING, 1.0), 0.0, sigma / critical);
        self.push(Unknowns::ith(OFFSET, 1.0), 0.0, 1e-9_f64.sqrt());
    }

    /// The best unknowns, with a fixed damping or a free one.
    fn solve(&self, damping: Option<f64>) -> Unknowns {
        let (mut rows, mut right) = (self.rows, self.right);
        if let Some(damping) = damping {
            right -= rows.column(DAMPING) * damping;
            rows.column_mut(DAMPING).fill(0.0);
            (rows[(self.used, DAMPING)], right[self.used]) = (1.0, damping);
        }
        let qr = rows.qr();
        let right = qr.q().transpose() * right;
        qr.r().solve_upper_triangular(&right).expect("a rank")
    }

    /// Sum of squared residuals of the measurements, without those of the prior.
    fn residual_squares(&self, unknowns: &Unknowns) -> f64 {
        let left = self.rows * unknowns - self.right;
        left.rows(0, self.data).norm_squared()
    }

    /// Variance of the damping, in units of σ².
    fn variance(&self) -> f64 {
        let information = self.rows.transpose() * self.rows;
        let inverse = information.try_inverse().expect("a rank");
        inverse[(DAMPING, DAMPING)]
    }
}

fn assert_same(found: f64, expected: f64, what: &str) {
    let apart = (found - expected).abs();
    assert!(
        apart <= 1e-6 * expected.abs() + 1e-12,
        "{what}: {found} {expected}"
    );
}

/// Asserts that an estimate follows from the best unknowns of a batch.
pub(super) fn assert_batch(
    estimate: &Estimate,
    batch: &Batch,
    prior: &Prior,
    (origin, closing): (V6, f64),
    loads: (f64, f64),
) {
    let (squares, count) = loads;
    let inverse_mass = prior.direction.dot(&prior.mobility);
    let stiffness_of = |u: &Unknowns| {
        let k = u.fixed_rows::<6>(0).dot(&prior.mobility) / inverse_mass;
        k.clamp(0.02 * prior.stiffness, 50.0 * prior.stiffness)
    };
    let free = batch.solve(None);
    let late = stiffness_of(&free) * prior.delay_s;
    let variance = batch.variance() * prior.sigma * prior.sigma + late * late;
    let doubt = 1.5 * 1.5 * variance / (free[DAMPING] * free[DAMPING]);
    let most = 1.9 * (stiffness_of(&free) / inverse_mass).sqrt();
    let damping = (free[DAMPING] * (1.0 - doubt).max(0.0)).clamp(0.0, most);
    let best = batch.solve(Some(damping));
    let (stiffness, left) = (stiffness_of(&best), batch.residual_squares(&best));
    assert_same(estimate.damping, damping, "damping");
    assert_same(estimate.stiffness, stiffness, "stiffness");
    let not_negative = batch.solve(Some(free[DAMPING].max(0.0)));
    assert_same(
        estimate.squared_error,
        batch.residual_squares(&not_negative),
        "squared error",
    );
    assert_same(estimate.error, (left / count).sqrt(), "error");
    assert_same(estimate.misfit, (left / squares).sqrt(), "misfit");
    assert_same(estimate.mass, 1.0 / inverse_mass, "mass");
    // The surface is where a robot at rest feels no force.
    let kappa: V6 = best.fixed_rows::<6>(0).into();
    let way = estimate.surface - estimate.gradient.dot(&origin);
    let at_rest = best[OFFSET] - best[DAMPING] * closing;
    assert_same(way * stiffness, -at_rest, "surface");
    let along = kappa.dot(&prior.mobility) / inverse_mass;
    let expected = match along > 0.5 * stiffness {
        true => kappa / along,
        false => prior.direction,
    };
    assert!((estimate.gradient - expected).amax() < 1e-6, "{expected}");
    assert_same(estimate.gradient.dot(&estimate.push), 1.0, "push");
}
