//! Covariance of estimates where the residual is not white.
//!
//! The inverse of the information matrix is the covariance of the estimates only if residuals are independent. Errors that last
//! are therefore judged by parts of the logs. Each part moves the estimates by the sum of its residuals times their influence;
//! the variance is the sum of the squares of these moves (the sandwich of White 1980, with parts of the logs as clusters).

use nalgebra::DMatrix;
use std::collections::BTreeSet;

/// Number of parts of all logs together: with 32 of them a standard deviation is known to an eighth. An error that lasts longer
/// than a part is not seen.
const PARTS: usize = 32;

/// Widens the `covariance` of parameters by what the parts of the logs say. `columns` are the derivatives of the residuals, one
/// column per parameter; `part_of` is the part of each residual; a parameter without a prior has no tolerance. No variance
/// becomes smaller: residuals that are anticorrelated in the fit need not be so elsewhere.
pub(super) fn widen(
    covariance: &mut DMatrix<f64>,
    columns: &[Vec<f64>],
    residuals: &[f64],
    part_of: &[usize],
    tolerances: &[Option<f64>],
) {
    let parts = part_of.iter().max().map_or(0, |last| last + 1);
    // Parts may be without residuals, as of a wrench that is judged in contacts alone.
    let judged = part_of.iter().collect::<BTreeSet<_>>().len();
    if judged < PARTS / 2 {
        return;
    }
    let mut scores = DMatrix::zeros(parts, tolerances.len());
    for (k, column) in columns.iter().enumerate() {
        for ((slope, residual), part) in column.iter().zip(residuals).zip(part_of) {
            scores[(*part, k)] += slope * residual;
        }
    }
    let moved = scores * &*covariance;
    let unbiased = judged as f64 / (judged - 1) as f64;
    let factors: Vec<f64> = (0..tolerances.len())
        .map(|k| {
            let of_data = unbiased * parts as f64 * moved.column(k).variance();
            let of_priors = (0..tolerances.len()).filter_map(|j| {
                let tolerance = tolerances[j]?;
                Some((covariance[(k, j)] / tolerance).powi(2))
            });
            let variance = of_data + of_priors.sum::<f64>();
            (variance / covariance[(k, k)]).sqrt().max(1.0)
        })
        .collect();
    // Correlations stay those of the fit: there are too few parts to estimate them.
    for (i, of_row) in factors.iter().enumerate() {
        for (k, of_column) in factors.iter().enumerate() {
            covariance[(i, k)] *= of_row * of_column;
        }
    }
}

/// The part of each row of logs, `cycles` of which each has: rows are given by log and cycle.
pub(super) fn parts(cycles: &[usize], rows: impl Iterator<Item = (usize, usize)>) -> Vec<usize> {
    let each = (PARTS / cycles.len().max(1)).max(1);
    let part = |(log, cycle): (usize, usize)| log * each + cycle * each / cycles[log].max(1);
    rows.map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;
    use softdock_statistics::{DEVIATIONS_95, RandomStream};

    const COUNT: usize = 4000;
    const TRUTH: [f64; 2] = [2.0, -1.0];

    /// Fits an offset and a slow swing to a series with autoregressive noise of coefficient `kept`. Returns the errors of both in
    /// standard deviations, and the standard deviation of the offset over the one for white noise.
    fn fitted(seed: u64, kept: f64) -> ([f64; 2], f64) {
        let mut random = RandomStream::new(seed, 0);
        let swing = |n: usize| (0.02 * n as f64).sin();
        let columns = [vec![1.0; COUNT], (0..COUNT).map(swing).collect()];
        let mut noise = 0.0;
        let series = (0..COUNT).map(|n| {
            noise = kept * noise + (1.0 - kept * kept).sqrt() * random.normal();
            TRUTH[0] + TRUTH[1] * columns[1][n] + noise
        });
        let series = DVector::from_iterator(COUNT, series);
        let design = DMatrix::from_fn(COUNT, 2, |n, k| columns[k][n]);
        let mut covariance = (design.transpose() * &design)
            .try_inverse()
            .expect("two functions");
        let values = &covariance * design.transpose() * &series;
        let left: Vec<f64> = (series - design * &values).iter().map(|r| -r).collect();
        let part_of = parts(&[COUNT], (0..COUNT).map(|n| (0, n)));
        let of_white = covariance[(0, 0)].sqrt();
        widen(&mut covariance, &columns, &left, &part_of, &[None, None]);
        let off = |k: usize| (values[k] - TRUTH[k]) / covariance[(k, k)].sqrt();
        ([off(0), off(1)], covariance[(0, 0)].sqrt() / of_white)
    }

    /// With noise that lasts for 20 values, intervals for white noise would contain the truth in a third of the cases.
    #[test]
    fn intervals_hold_the_truth_under_noise_that_lasts() {
        const SEEDS: u64 = 200;
        for kept in [0.0, 0.9] {
            let all: Vec<[f64; 2]> = (0..SEEDS).map(|seed| fitted(seed, kept).0).collect();
            for k in [0, 1] {
                let held = all
                    .iter()
                    .filter(|off| off[k].abs() < DEVIATIONS_95)
                    .count();
                assert!(
                    (180..=198).contains(&held),
                    "{kept}, {k}: {held} of {SEEDS}"
                );
            }
        }
    }

    #[test]
    fn white_noise_keeps_its_intervals_but_for_the_scatter_of_32_parts() {
        let mean = (0..100).map(|seed| fitted(seed, 0.0).1).sum::<f64>() / 100.0;
        assert!((1.0..1.1).contains(&mean), "{mean}");
    }

    /// A parameter that its tolerance alone determines is as uncertain as that.
    #[test]
    fn a_tolerance_is_no_noise() {
        let mut covariance = DMatrix::from_element(1, 1, 0.04);
        let rows = (0..64).map(|n| (0, n));
        let part_of = parts(&[64], rows);
        widen(
            &mut covariance,
            &[vec![0.0; 64]],
            &[1.0; 64],
            &part_of,
            &[Some(0.2)],
        );
        assert!((covariance[(0, 0)] - 0.04).abs() < 1e-12);
    }
}
