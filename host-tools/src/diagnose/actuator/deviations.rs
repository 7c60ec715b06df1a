//! How well a log determines the parameters of stages.

use super::cost::{Cost, Term};
use nalgebra::DMatrix;

/// Standard deviation of each parameter of each term, from the curvature of χ² around them.
pub(crate) fn deviations(terms: &[Term], train: &Cost<'_>) -> Vec<Vec<f64>> {
    let flat: Vec<f64> = terms
        .iter()
        .flat_map(|t| t.values.iter().copied())
        .collect();
    let size = flat.len();
    if size == 0 {
        return Vec::new();
    }
    let with = |values: &[f64]| -> f64 {
        let mut at = 0;
        let moved: Vec<Term> = terms
            .iter()
            .map(|term| {
                let own = values[at..at + term.values.len()].to_vec();
                at += term.values.len();
                Term {
                    values: own,
                    ..term.clone()
                }
            })
            .collect();
        train.of(&moved)
    };
    let least = with(&flat);
    let steps: Vec<f64> = (0..size)
        .map(|i| step_to_one(i, &flat, least, &with))
        .collect();
    let moved = |i: usize, k: usize, si: f64, sk: f64| {
        let mut values = flat.clone();
        values[i] += si * steps[i];
        values[k] += sk * steps[k];
        with(&values)
    };
    let half_hessian = DMatrix::from_fn(size, size, |i, k| {
        if i == k {
            (moved(i, i, 0.5, 0.5) + moved(i, i, -0.5, -0.5) - 2.0 * least) / 2.0
        } else {
            (moved(i, k, 1.0, 1.0) + moved(i, k, -1.0, -1.0)
                - moved(i, k, 1.0, -1.0)
                - moved(i, k, -1.0, 1.0))
                / 8.0
        }
    });
    let covariance = half_hessian.cholesky().map(|c| c.inverse());
    let mut sigma = (0..size).map(|i| {
        let own = covariance.as_ref().map_or(f64::NAN, |c| c[(i, i)].sqrt());
        // A cost that is not smooth has no curvature; one unit of χ² is a deviation still.
        steps[i] * if own.is_finite() { own.max(1.0) } else { 1.0 }
    });
    terms
        .iter()
        .map(|term| sigma.by_ref().take(term.values.len()).collect())
        .collect()
}

/// Step of one parameter that raises χ² by about one.
fn step_to_one(i: usize, flat: &[f64], least: f64, with: &dyn Fn(&[f64]) -> f64) -> f64 {
    let mut step = 1e-6 * flat[i].abs().max(1e-9);
    for _ in 0..48 {
        let rise = [step, -step].into_iter().map(|s| {
            let mut values = flat.to_vec();
            values[i] += s;
            with(&values) - least
        });
        if rise.fold(0.0, f64::max) >= 1.0 {
            break;
        }
        step *= 1.5;
    }
    step
}
