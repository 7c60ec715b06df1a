//! Least squares by Levenberg and Marquardt's method, with Gaussian priors.

use super::parameter::Parameter;
use super::residual::Residuals;
use super::sandwich;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen};
use rayon::prelude::*;
use softdock_physics::model::Model;

/// Evaluations per parameter at most.
const MAX_STALLED_STEPS: usize = 20;
/// Eigenvalues of a correlation matrix are raised to this: smaller ones are round-off.
const SINGULAR: f64 = 1e-12;

/// Values of the free parameters, and how well they are known.
pub(super) struct Solution {
    /// Best values.
    pub values: Vec<f64>,
    /// Their covariance, priors included, widened for residuals that are not white.
    covariance: DMatrix<f64>,
    /// Covariance from the curvature of χ² alone.
    curvature: DMatrix<f64>,
}

impl Solution {
    /// Values of the model file, with a covariance of zero.
    pub(super) fn start(free: &[Parameter]) -> Self {
        Self {
            values: free.iter().map(|p| p.value).collect(),
            covariance: DMatrix::zeros(free.len(), free.len()),
            curvature: DMatrix::zeros(free.len(), free.len()),
        }
    }

    /// Best values of all parameters if the parameters at the places `held` have the given values: χ² is taken as a parabola
    /// about its minimum.
    pub(super) fn values_with_held(&self, held: &[(usize, f64)]) -> Vec<f64> {
        let of_held = DMatrix::from_fn(held.len(), held.len(), |i, k| {
            self.curvature[(held[i].0, held[k].0)]
        });
        let away = held.iter().map(|(k, value)| value - self.values[*k]);
        let away = DVector::from_iterator(held.len(), away);
        let Some(pull) = of_held.cholesky().map(|factor| factor.solve(&away)) else {
            return self.values.clone();
        };
        let moved = |other: usize| -> f64 {
            let of = |((k, _), pull): (&(usize, f64), &f64)| self.curvature[(other, *k)] * pull;
            held.iter().zip(pull.iter()).map(of).sum()
        };
        let values = self.values.iter().enumerate();
        values.map(|(k, value)| value + moved(k)).collect()
    }

    /// Standard deviation of a parameter.
    pub(super) fn sigma(&self, k: usize) -> f64 {
        self.covariance[(k, k)].sqrt()
    }

    /// Correlation of two parameters, −1 to 1.
    pub(super) fn correlation(&self, i: usize, k: usize) -> f64 {
        self.covariance[(i, k)] / (self.sigma(i) * self.sigma(k))
    }

    /// The model with these values.
    pub(super) fn model(&self, model: &Model, free: &[Parameter]) -> Model {
        with_values(model, free, &self.values)
    }
}

fn with_values(model: &Model, free: &[Parameter], values: &[f64]) -> Model {
    let mut changed = model.clone();
    for (parameter, value) in free.iter().zip(values) {
        parameter.set(&mut changed, *value);
    }
    changed
}

/// Derivatives of the residuals at the values of the model file: one column per parameter.
pub(super) fn jacobian(
    residuals: &Residuals<'_>,
    model: &Model,
    free: &[Parameter],
) -> Vec<Vec<f64>> {
    let values: Vec<f64> = free.iter().map(|p| p.value).collect();
    columns(residuals, model, free, &values)
}

/// Derivatives by central differences; one-sided where a range ends, and where the prediction is linear.
fn columns(
    residuals: &Residuals<'_>,
    model: &Model,
    free: &[Parameter],
    values: &[f64],
) -> Vec<Vec<f64>> {
    residuals.keep(&with_values(model, free, values));
    let known = residuals.slopes();
    let slope = |(k, parameter): (usize, &Parameter)| {
        if let Some((_, slope)) = known.iter().find(|(id, _)| *id == parameter.id) {
            return (parameter.id.clone(), slope.clone());
        }
        let at = |value: f64| {
            let mut moved = values.to_vec();
            moved[k] = value;
            residuals.relative(&with_values(model, free, &moved))
        };
        let value = values[k].clamp(parameter.low, parameter.high);
        let more = (value + parameter.step).min(parameter.high);
        let less = match parameter.linear && more > value {
            true => value,
            false => (value - parameter.step).max(parameter.low),
        };
        let (low, high) = (at(less), at(more));
        let slope = |(a, b): (&f64, &f64)| (b - a) / (more - less);
        let slopes = low.iter().zip(&*high).map(slope).collect();
        (parameter.id.clone(), slopes)
    };
    let slopes: Vec<_> = free.par_iter().enumerate().map(slope).collect();
    let weighted = slopes.iter().map(|(_, slope)| residuals.weighted(slope));
    let columns = weighted.collect();
    residuals.keep_slopes(slopes);
    columns
}

/// The values with the smallest χ², from `values` on; `tolerance`: the relative fall of χ², and the relative step, at which the search
/// ends.
pub(super) fn minimise(
    residuals: &Residuals<'_>,
    model: &Model,
    free: &[Parameter],
    values: &[f64],
    tolerance: f64,
) -> Solution {
    if free.is_empty() {
        return Solution::start(free);
    }
    let steps = free.iter().zip(values).map(|(p, v)| (v - p.value) / p.step);
    let problem = Problem {
        residuals,
        model,
        free,
        steps: DVector::from_iterator(free.len(), steps),
    };
    let search = LevenbergMarquardt::new()
        .with_patience(MAX_STALLED_STEPS)
        .with_ftol(tolerance)
        .with_xtol(tolerance);
    let (found, _) = search.minimize(problem);
    let values = found.values();
    let columns = columns(residuals, model, free, &values);
    let curvature = covariance(&columns, free);
    let mut covariance = curvature.clone();
    let left = residuals.of(&with_values(model, free, &values));
    let tolerances: Vec<Option<f64>> = free.iter().map(|p| p.tolerance).collect();
    sandwich::widen(
        &mut covariance,
        &columns,
        &left,
        &residuals.parts(),
        &tolerances,
    );
    Solution {
        values,
        covariance,
        curvature,
    }
}

/// Inverse of the information of recording and priors.
fn covariance(columns: &[Vec<f64>], free: &[Parameter]) -> DMatrix<f64> {
    let count = free.len();
    let mut information = DMatrix::from_fn(count, count, |i, k| dot(&columns[i], &columns[k]));
    for (k, parameter) in free.iter().enumerate() {
        information[(k, k)] += parameter.tolerance.map_or(0.0, |t| 1.0 / (t * t));
    }
    // Scaled to ones on the diagonal: the parameters' units differ by ten orders.
    let scale: Vec<f64> = (0..count)
        .map(|k| 1.0 / information[(k, k)].max(f64::MIN_POSITIVE).sqrt())
        .collect();
    let scaled = DMatrix::from_fn(count, count, |i, k| {
        information[(i, k)] * scale[i] * scale[k]
    });
    let eigen = SymmetricEigen::new(scaled);
    let inverse = eigen.eigenvalues.map(|e| 1.0 / e.max(SINGULAR));
    let vectors = &eigen.eigenvectors;
    DMatrix::from_fn(count, count, |i, k| {
        let sum: f64 = (0..count)
            .map(|e| vectors[(i, e)] * inverse[e] * vectors[(k, e)])
            .sum();
        sum * scale[i] * scale[k]
    })
}

/// Length of a column.
pub(super) fn norm(column: &[f64]) -> f64 {
    dot(column, column).sqrt()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The least-squares problem; its unknowns are counted in steps from the model file's values.
struct Problem<'a> {
    residuals: &'a Residuals<'a>,
    model: &'a Model,
    free: &'a [Parameter],
    steps: DVector<f64>,
}

impl Problem<'_> {
    fn values(&self) -> Vec<f64> {
        let value = |(p, step): (&Parameter, &f64)| (p.value + step * p.step).clamp(p.low, p.high);
        self.free.iter().zip(self.steps.iter()).map(value).collect()
    }

    /// Parameters with a prior, and their tolerances in steps.
    fn priors(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let of = |(k, p): (usize, &Parameter)| p.tolerance.map(|t| (k, t / p.step));
        self.free.iter().enumerate().filter_map(of)
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, steps: &DVector<f64>) {
        self.steps.copy_from(steps);
    }

    fn params(&self) -> DVector<f64> {
        self.steps.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let model = with_values(self.model, self.free, &self.values());
        self.residuals.keep(&model);
        let mut all = self.residuals.of(&model);
        all.extend(
            self.priors()
                .map(|(k, tolerance)| self.steps[k] / tolerance),
        );
        all.iter().all(|r| r.is_finite()).then(|| all.into())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns = columns(self.residuals, self.model, self.free, &self.values());
        let priors: Vec<(usize, f64)> = self.priors().collect();
        let data = self.residuals.len();
        let jacobian = DMatrix::from_fn(data + priors.len(), self.free.len(), |row, k| {
            match row.checked_sub(data) {
                None => columns[k][row] * self.free[k].step,
                Some(prior) if priors[prior].0 == k => 1.0 / priors[prior].1,
                Some(_) => 0.0,
            }
        });
        jacobian.iter().all(|v| v.is_finite()).then_some(jacobian)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// χ² = (x − 1)² + (x + y − 3)²: with y held at 0, its minimum is at x = 2.
    #[test]
    fn what_is_held_moves_the_others() {
        let information = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 1.0]);
        let inverse = information.try_inverse().expect("regular");
        let solution = Solution {
            values: vec![1.0, 2.0],
            covariance: inverse.clone(),
            curvature: inverse,
        };
        let [x, y] = solution.values_with_held(&[(1, 0.0)])[..] else {
            panic!("two values");
        };
        assert!((x - 2.0).abs() < 1e-12 && y.abs() < 1e-12, "{x} {y}");
        assert_eq!(solution.values_with_held(&[]), [1.0, 2.0]);
    }
}
