//! Groups of observations that contradict all others: somebody leaned on the tool.
//!
//! A fit in which large errors count less orders the groups by how well they agree. From the best
//! two thirds on, groups are taken in while they are what the fit so far predicts (forward search,
//! Atkeson and Riani 2000); those that are left are outliers.

use super::equations::Unknowns;
use super::gravity::Gravity;
use super::least_squares::{Solution, solve, solve_weighted};
use super::observation::Group;
use anyhow::{Result, bail};
use nalgebra::{DMatrix, DVector};
use softdock_statistics::{f_p, median};

/// Fewer groups than this cannot outvote an outlier.
const FEWEST: usize = 6;
/// Probability below which a group contradicts the others, over the number of groups: one set in a
/// thousand without outliers loses a group.
const IMPROBABLE: f64 = 1e-3;
/// Steps of the robust fit.
const STEPS: usize = 15;

/// A fit without outliers, and the groups that it used, in their order.
///
/// # Errors
///
/// A third of the groups contradict the rest: then nobody knows which of them are right.
pub(super) fn robust(
    groups: &[Group],
    unknowns: &Unknowns,
    start: &Gravity,
) -> Result<(Solution, Vec<usize>)> {
    let count = groups.len();
    if count < FEWEST {
        return Ok((solve(groups, unknowns, start), (0..count).collect()));
    }
    let by_agreement = ordered(groups, unknowns, start);
    let core = count - count / 3;
    let mut kept: Vec<usize> = by_agreement[..core].to_vec();
    let mut outside: Vec<usize> = by_agreement[core..].to_vec();
    loop {
        let chosen: Vec<&Group> = kept.iter().map(|n| &groups[*n]).collect();
        let fit = solve(&chosen, unknowns, start);
        let excess = excess(&chosen, &fit, unknowns);
        let distance = |n: &usize| outside_distance(&groups[*n], &fit, unknowns) / excess;
        let nearest = outside.iter().map(|n| (*n, distance(n)));
        let nearest = nearest.min_by(|a, b| relative(groups, a).total_cmp(&relative(groups, b)));
        let Some((n, squared)) = nearest else {
            kept.sort_unstable();
            return Ok((fit, kept));
        };
        let size = 6.0 * groups[n].observations.len() as f64;
        let freedom = fit.freedom[0] + fit.freedom[1];
        if f_p(squared / size, size, freedom) < IMPROBABLE / count as f64 {
            if kept.len() == core {
                bail!(
                    "{} of {count} parts of the recording or more contradict the rest, so that nobody \
                     knows which are right: keep hands, cables and hoses off the tool, and \
                     record again",
                    outside.len()
                );
            }
            kept.sort_unstable();
            return Ok((fit, kept));
        }
        outside.retain(|other| *other != n);
        kept.push(n);
    }
}

/// Squared distance per number.
fn relative(groups: &[Group], (n, squared): &(usize, f64)) -> f64 {
    squared / groups[*n].observations.len().max(1) as f64
}

/// The groups by their agreement with a fit in which an error beyond the median counts by its
/// size, not by its square. No pose has leverage over others: gravity is equally strong in all.
fn ordered(groups: &[Group], unknowns: &Unknowns, start: &Gravity) -> Vec<usize> {
    let mut weights = vec![1.0; groups.len()];
    let mut errors = vec![0.0; groups.len()];
    for _ in 0..STEPS {
        let fit = solve_weighted(groups, &weights, unknowns, start);
        for (error, group) in errors.iter_mut().zip(groups) {
            let squares: f64 = white(group, &fit, unknowns).norm_squared();
            *error = (squares / group.observations.len().max(1) as f64).sqrt();
        }
        let middle = median(&mut errors.clone())
            .unwrap_or(0.0)
            .max(f64::MIN_POSITIVE);
        for (weight, error) in weights.iter_mut().zip(&errors) {
            *weight = (middle / error.max(middle)).sqrt();
        }
    }
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by(|a, b| errors[*a].total_cmp(&errors[*b]));
    order
}

/// Errors of a group in units of the noise.
fn white(group: &Group, fit: &Solution, unknowns: &Unknowns) -> DVector<f64> {
    let mut all = DVector::zeros(6 * group.observations.len());
    for (n, observation) in group.observations.iter().enumerate() {
        let error = fit.error(observation, unknowns);
        for i in 0..6 {
            all[6 * n + i] = error[i] / fit.sigma[i / 3];
        }
    }
    all
}

/// Factor by which the mean squared error of a group exceeds the noise: median over the kept groups, at least 1.
fn excess(kept: &[&Group], fit: &Solution, unknowns: &Unknowns) -> f64 {
    let share = |group: &&Group| {
        let errors = white(group, fit, unknowns);
        errors.norm_squared() / errors.len().max(1) as f64
    };
    let mut shares: Vec<f64> = kept.iter().map(share).collect();
    median(&mut shares).unwrap_or(1.0).max(1.0)
}

/// Squared distance of a group from what a fit without it predicts, in units of the noise of both.
fn outside_distance(group: &Group, fit: &Solution, unknowns: &Unknowns) -> f64 {
    let errors = white(group, fit, unknowns);
    let mut rows = DMatrix::zeros(errors.len(), unknowns.count());
    for (n, observation) in group.observations.iter().enumerate() {
        let mut own = observation.rows(unknowns, &fit.gravity, &fit.values);
        for i in 0..6 {
            own.row_mut(i).scale_mut(1.0 / fit.sigma[i / 3]);
        }
        rows.rows_mut(6 * n, 6).copy_from(&own);
    }
    let size = errors.len();
    let spread = DMatrix::identity(size, size) + &rows * &fit.covariance * rows.transpose();
    match spread.cholesky() {
        Some(cholesky) => errors.dot(&cholesky.solve(&errors)),
        None => errors.norm_squared(),
    }
}
