//! The linear regression of all logs together: whitened residual, nuisance parameters with priors, and the gain of further
//! columns.

use super::gram::{dot, gram};
use crate::diagnose::noise::autoregressive::AutoregressiveNoise;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;
use std::borrow::Borrow;

/// A column is not determined if other columns leave less than this share of its square.
const LEFT: f64 = 1e-6;

/// One log's part of a regression: its noise, and its rows that count.
#[derive(Clone)]
pub(crate) struct Segment {
    /// Autoregressive noise model of each axis.
    pub noise_model: [AutoregressiveNoise; 6],
    /// Rows that count.
    pub fresh: Vec<bool>,
}

/// The regression of what the nominal model leaves of the logs, with the nuisance parameters (nominal values within tolerances)
/// eliminated. In each series the logs follow one another.
pub(crate) struct Problem {
    segments: Vec<Segment>,
    residual: Column,
    tolerances: Vec<Column>,
    /// Cholesky factor L of the normal matrix of the nuisance parameters, priors included.
    factor: DMatrix<f64>,
    /// L⁻¹ times the products of the nuisance columns with the residual.
    spent: DVector<f64>,
    /// χ² with the nuisance parameters at their best, their priors included.
    pub chi2: f64,
    /// The same of each log.
    pub chi2_of_logs: Vec<f64>,
    /// Number of axes that were recorded. One that reads 0 throughout has no noise and is not among these.
    pub axes: usize,
    /// Number of values that count.
    pub count: usize,
}

/// A hypothesis with its best coefficients.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// By how much χ² falls.
    pub gain: f64,
    /// Coefficients in the order of the columns.
    pub coefficients: Vec<f64>,
    /// Their standard deviations.
    pub sigma: Vec<f64>,
    /// Columns whose coefficient has a sign that physics forbids.
    pub wrong: Vec<usize>,
}

impl Problem {
    /// From residual (measured minus nominal) and nuisance columns, each for one tolerance, of each log.
    pub(crate) fn new(
        segments: Vec<Segment>,
        residuals: &[&Column],
        tolerances: &[&[Column]],
    ) -> Self {
        let fresh = segments.iter().flat_map(|s| &s.fresh);
        let counted = fresh.filter(|f| **f).count();
        let recorded = |axis: &usize| residuals.iter().any(|r| !r.0[*axis].is_empty());
        let axes = (0..6).filter(recorded).count().max(1);
        let size = tolerances.first().map_or(0, |t| t.len());
        let mut problem = Self {
            segments,
            residual: Column::default(),
            tolerances: Vec::new(),
            factor: DMatrix::zeros(0, 0),
            spent: DVector::zeros(0),
            chi2: 0.0,
            chi2_of_logs: Vec::new(),
            axes,
            count: axes * counted,
        };
        problem.residual = problem.whitened(residuals);
        problem.tolerances = (0..size)
            .map(|i| {
                let of_logs: Vec<&Column> = tolerances.iter().map(|t| &t[i]).collect();
                problem.whitened(&of_logs)
            })
            .collect();
        let products = problem.all_products(&[] as &[Column]);
        // The prior of each nuisance parameter has unit variance, in units of its tolerance.
        let normal = products.view((0, 0), (size, size)) + DMatrix::identity(size, size);
        // A sum of a unit matrix and a Gram matrix is positive definite.
        problem.factor = normal
            .cholesky()
            .map_or_else(|| DMatrix::identity(size, size), |c| c.l());
        let right = DVector::from_fn(size, |i, _| products[(i, size)]);
        problem.spent = problem.below(&right);
        problem.chi2 = products[(size, size)] - problem.spent.norm_squared();
        problem.chi2_of_logs = problem.chi2_with(&Column::default());
        problem
    }

    /// Numbers that identify the problem: equal in every bit for the same logs, rows and nuisance parameters.
    pub(crate) fn fingerprint(&self) -> impl Iterator<Item = u64> + '_ {
        let counts = [self.count, self.tolerances.len()].map(|count| count as u64);
        let spent = self.spent.iter();
        let numbers = spent.chain(&self.chi2_of_logs).chain([&self.chi2]);
        counts
            .into_iter()
            .chain(numbers.map(|number| number.to_bits()))
    }

    fn below(&self, right: &DVector<f64>) -> DVector<f64> {
        self.factor
            .solve_lower_triangular(right)
            .unwrap_or_else(|| right.clone())
    }

    /// Joins the columns of the logs into one and whitens it. Rows that do not count are 0.
    pub(crate) fn whitened(&self, columns: &[&Column]) -> Column {
        let mut out = Column::default();
        for (axis, out) in out.0.iter_mut().enumerate() {
            if columns.iter().all(|c| c.0[axis].is_empty()) {
                continue;
            }
            // A library holds hundreds of these columns, so no memory is reserved in excess.
            out.reserve_exact(self.segments.iter().map(|s| s.fresh.len()).sum());
            for (segment, column) in self.segments.iter().zip(columns) {
                let series = &column.0[axis];
                if series.is_empty() {
                    out.resize(out.len() + segment.fresh.len(), 0.0);
                    continue;
                }
                let white = segment.noise_model[axis].whiten(series);
                let counted = white.iter().zip(&segment.fresh);
                out.extend(counted.map(|(value, fresh)| if *fresh { *value } else { 0.0 }));
            }
        }
        out
    }

    /// Whether any row of a log counts.
    pub(crate) fn counts(&self, log: usize) -> bool {
        self.segments[log].fresh.contains(&true)
    }

    /// The rows of one log, out of a column of all logs.
    pub(crate) fn part(&self, column: &Column, log: usize) -> Column {
        let lengths = self.segments.iter().map(|s| s.fresh.len());
        let from: usize = lengths.take(log).sum();
        let to = from + self.segments[log].fresh.len();
        Column(column.0.each_ref().map(|series| match series.is_empty() {
            true => Vec::new(),
            false => series[from..to].to_vec(),
        }))
    }

    /// A column of all logs, with the rows of all logs but one set to 0.
    pub(crate) fn masked(&self, column: &Column, log: usize) -> Column {
        let lengths = self.segments.iter().map(|s| s.fresh.len());
        let from: usize = lengths.take(log).sum();
        let to = from + self.segments[log].fresh.len();
        let mut masked = column.clone();
        for series in masked.0.iter_mut().filter(|s| !s.is_empty()) {
            series[..from].fill(0.0);
            series[to..].fill(0.0);
        }
        masked
    }

    /// Gram matrix of the nuisance columns, the given whitened columns and the residual, in this order.
    pub(crate) fn all_products(&self, columns: &[impl Borrow<Column> + Sync]) -> DMatrix<f64> {
        let columns = columns.iter().map(Borrow::borrow);
        let all = self.tolerances.iter().chain(columns);
        let all: Vec<&Column> = all.chain([&self.residual]).collect();
        gram(&all)
    }

    /// The same with further columns, where `known` is the matrix with the first ones.
    pub(crate) fn more_products(&self, known: &DMatrix<f64>, columns: &[Column]) -> DMatrix<f64> {
        let old = known.nrows() - 1;
        let all = self
            .tolerances
            .iter()
            .chain(columns)
            .chain([&self.residual]);
        let all: Vec<&Column> = all.collect();
        let last = all.len() - 1;
        let mut products = DMatrix::zeros(all.len(), all.len());
        let was = known.view((0, 0), (old, old));
        products.view_mut((0, 0), (old, old)).copy_from(&was);
        let residual = known.view((0, old), (old, 1));
        products.view_mut((0, last), (old, 1)).copy_from(&residual);
        products[(last, last)] = known[(old, old)];
        let new = (old..last).into_par_iter();
        let new: Vec<Vec<f64>> = new
            .map(|k| all.iter().map(|column| dot(column, all[k])).collect())
            .collect();
        for (k, of_column) in (old..last).zip(new) {
            for (i, product) in of_column.into_iter().enumerate() {
                products[(i, k)] = product;
                products[(k, i)] = product;
            }
        }
        for i in 0..old {
            products[(last, i)] = products[(i, last)];
        }
        products
    }

    /// Products of columns with each other and with the residual, after elimination of the nuisance parameters, from
    /// [`Self::all_products`].
    pub(crate) fn after_tolerances(&self, all: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let first = self.tolerances.len();
        let size = all.nrows() - first - 1;
        let against = all.view((0, first), (first, size)).into_owned();
        let taken = self
            .factor
            .solve_lower_triangular(&against)
            .unwrap_or(against);
        let gram = all.view((first, first), (size, size));
        let right = DVector::from_fn(size, |i, _| all[(first + i, first + size)]);
        (
            gram - taken.transpose() * &taken,
            right - taken.transpose() * &self.spent,
        )
    }

    /// Effective number of nuisance parameters that the logs determine rather than their priors: the trace of prior minus
    /// posterior covariance.
    pub(crate) fn informed(&self) -> f64 {
        let size = self.factor.nrows();
        let below = self
            .factor
            .solve_lower_triangular(&DMatrix::identity(size, size));
        let kept = below.map_or(0.0, |below| below.norm_squared());
        size as f64 - kept
    }

    /// Posterior mean and standard deviation of each nuisance parameter, in tolerances, beside a given contribution. The
    /// amplitudes of `columns` are free. All columns are whitened.
    pub(crate) fn tolerances_beside(&self, white: &Column, columns: &[Column]) -> Vec<[f64; 2]> {
        /// Share of a column's square that keeps the normal matrix definite where columns are equal.
        const RIDGE: f64 = 1e-9;
        let size = self.tolerances.len();
        let left = self.less(white);
        let all = self.all_products(columns);
        let last = all.nrows() - 1;
        let mut normal = all.view((0, 0), (last, last)).into_owned();
        for i in 0..last {
            normal[(i, i)] += if i < size {
                1.0
            } else {
                RIDGE * normal[(i, i)]
            };
        }
        let both = self.tolerances.iter().chain(columns);
        let right = DVector::from_iterator(last, both.map(|column| dot(column, &left)));
        let Some(factor) = normal.cholesky() else {
            return vec![[0.0, 1.0]; size];
        };
        let (mean, variance) = (factor.solve(&right), factor.inverse());
        let of = |i: usize| [mean[i], variance[(i, i)].sqrt()];
        (0..size).map(of).collect()
    }

    /// A whitened column with its products with the nuisance columns and the residual.
    pub(crate) fn projected<C: Borrow<Column>>(&self, column: C) -> Projected<C> {
        let products = self.tolerances.iter();
        let products = products.map(|tolerance| dot(tolerance, column.borrow()));
        let against = self.below(&DVector::from_iterator(self.tolerances.len(), products));
        Projected {
            right: dot(column.borrow(), &self.residual) - against.dot(&self.spent),
            against,
            column,
        }
    }

    /// Best coefficients of whitened columns. `None` if the data do not determine them.
    pub(crate) fn solve_whitened(
        &self,
        white: &[impl Borrow<Column>],
        signs: &[Sign],
    ) -> Option<Solution> {
        let columns: Vec<_> = white.iter().map(|c| self.projected(c.borrow())).collect();
        let right = DVector::from_iterator(columns.len(), columns.iter().map(|c| c.right));
        let all: Vec<usize> = (0..white.len()).collect();
        solve(&products(&columns), &right, &all, signs)
    }

    /// By how much χ² falls with a given whitened contribution, the nuisance parameters at their best.
    pub(crate) fn gain_of(&self, white: &Column) -> f64 {
        self.projected(white).gain()
    }

    /// By how much χ² of each log falls with a whitened contribution, including what the nuisance parameters no longer have to
    /// explain.
    pub(crate) fn gains(&self, white: &Column) -> Vec<f64> {
        let both = self.chi2_of_logs.iter().zip(self.chi2_with(white));
        both.map(|(before, after)| before - after).collect()
    }

    /// χ² of each log with a whitened contribution.
    fn chi2_with(&self, white: &Column) -> Vec<f64> {
        let taken = self.tolerances_with(white);
        let rest = self.rest(white, &taken);
        // The cost of the priors is shared equally by the logs.
        let shared = taken.norm_squared() / self.segments.len().max(1) as f64;
        let of = |log: usize| {
            let part = self.part(&rest, log);
            shared + dot(&part, &part)
        };
        (0..self.segments.len()).map(of).collect()
    }

    /// What a whitened contribution and given values of the nuisance parameters leave of the residual.
    pub(crate) fn rest(&self, white: &Column, taken: &DVector<f64>) -> Column {
        let mut left = self.less(white);
        for (column, taken) in self.tolerances.iter().zip(taken) {
            subtract(&mut left, column, *taken);
        }
        left
    }

    fn less(&self, white: &Column) -> Column {
        let mut left = self.residual.clone();
        subtract(&mut left, white, 1.0);
        left
    }

    /// Best values of the nuisance parameters, in tolerances, beside a whitened contribution.
    pub(crate) fn tolerances_with(&self, white: &Column) -> DVector<f64> {
        let left = self.less(white);
        let products = DVector::from_fn(self.tolerances.len(), |i, _| {
            dot(&self.tolerances[i], &left)
        });
        let below = self.below(&products);
        self.factor
            .transpose()
            .solve_upper_triangular(&below)
            .unwrap_or(below)
    }
}

/// A whitened column with its projection on the nuisance columns.
#[derive(Clone)]
pub(crate) struct Projected<C = Column> {
    /// The column.
    pub column: C,
    /// L⁻¹ times its products with the nuisance columns.
    against: DVector<f64>,
    /// Its product with the residual, after elimination of the nuisance parameters.
    pub right: f64,
}

impl<C: Borrow<Column>> Projected<C> {
    /// Product with another column, after elimination of the nuisance parameters.
    pub(crate) fn product(&self, other: &Self) -> f64 {
        dot(self.column.borrow(), other.column.borrow()) - self.against.dot(&other.against)
    }

    /// By how much χ² falls with this column at a coefficient of 1.
    pub(crate) fn gain(&self) -> f64 {
        2.0 * self.right - self.product(self)
    }
}

/// Products of columns with each other, after elimination of the nuisance parameters.
pub(crate) fn products<C: Borrow<Column>>(columns: &[impl Borrow<Projected<C>>]) -> DMatrix<f64> {
    let mut products = DMatrix::zeros(columns.len(), columns.len());
    for (i, one) in columns.iter().enumerate() {
        for (k, other) in columns[i..].iter().enumerate() {
            products[(i + k, i)] = one.borrow().product(other.borrow());
        }
    }
    products.fill_upper_triangle_with_lower_triangle();
    products
}

/// Best coefficients of the `chosen` columns of a Gram matrix; `None` if the data do not determine them.
pub(crate) fn solve(
    gram: &DMatrix<f64>,
    right: &DVector<f64>,
    chosen: &[usize],
    signs: &[Sign],
) -> Option<Solution> {
    let (best, open) = best(gram, right, chosen, signs)?;
    let mut sigma = vec![0.0; chosen.len()];
    if let Some(open) = open {
        let covariance = open.cholesky.inverse();
        for (i, &place) in open.places.iter().enumerate() {
            sigma[place] = covariance[(i, i)].max(0.0).sqrt() / open.scale[i];
        }
    }
    Some(Solution {
        gain: best.gain,
        coefficients: best.coefficients,
        sigma,
        wrong: best.wrong,
    })
}

/// A [`Solution`] without standard deviations, which cost more to compute than all the rest.
pub(crate) struct Best {
    /// By how much χ² falls.
    pub gain: f64,
    coefficients: Vec<f64>,
    /// Columns whose coefficient has a sign that physics forbids.
    pub wrong: Vec<usize>,
    /// Smallest share of the square of a column that the columns before it cannot imitate.
    pub own: f64,
}

/// The columns whose coefficients are free, scaled to unit length, so that one limit on "undetermined" fits all.
struct Open {
    places: Vec<usize>,
    scale: Vec<f64>,
    cholesky: Cholesky<f64, Dyn>,
}

impl Open {
    /// `None` where a column is 0 or not finite, or depends linearly on the others.
    fn new(gram: &DMatrix<f64>, chosen: &[usize], places: Vec<usize>) -> Option<Self> {
        let columns: Vec<usize> = places.iter().map(|&place| chosen[place]).collect();
        let scale: Vec<f64> = columns.iter().map(|&c| gram[(c, c)].sqrt()).collect();
        if scale.iter().any(|s| !s.is_finite() || *s <= 0.0) {
            return None;
        }
        let size = places.len();
        let normal = DMatrix::from_fn(size, size, |i, k| {
            gram[(columns[i], columns[k])] / (scale[i] * scale[k])
        });
        Some(Self {
            places,
            scale,
            cholesky: normal.cholesky()?,
        })
    }

    /// See [`Best::own`].
    fn own(&self) -> f64 {
        let shares = self.cholesky.l_dirty().diagonal().map(|d| d * d);
        shares.iter().copied().fold(1.0, f64::min)
    }
}

/// As [`solve`], without standard deviations.
pub(crate) fn best_gain(
    gram: &DMatrix<f64>,
    right: &DVector<f64>,
    chosen: &[usize],
    signs: &[Sign],
) -> Option<Best> {
    Some(best(gram, right, chosen, signs)?.0)
}

fn best(
    gram: &DMatrix<f64>,
    right: &DVector<f64>,
    chosen: &[usize],
    signs: &[Sign],
) -> Option<(Best, Option<Open>)> {
    let (fixed, places): (Vec<usize>, Vec<usize>) =
        (0..chosen.len()).partition(|k| signs[*k] == Sign::One);
    let beside = |column: usize| -> f64 {
        let products = fixed.iter().map(|&k| gram[(column, chosen[k])]);
        products.sum()
    };
    let mut best = Best {
        gain: fixed
            .iter()
            .map(|&i| 2.0 * right[chosen[i]] - beside(chosen[i]))
            .sum(),
        coefficients: vec![1.0; chosen.len()],
        wrong: Vec::new(),
        own: 1.0,
    };
    if places.is_empty() {
        return best.gain.is_finite().then_some((best, None));
    }
    let open = Open::new(gram, chosen, places)?;
    best.own = open.own();
    if best.own < LEFT {
        return None;
    }
    let product = DVector::from_fn(open.places.len(), |i, _| {
        let column = chosen[open.places[i]];
        (right[column] - beside(column)) / open.scale[i]
    });
    let values = open.cholesky.solve(&product);
    best.gain += values.dot(&product);
    for (i, &place) in open.places.iter().enumerate() {
        best.coefficients[place] = values[i] / open.scale[i];
        if signs[place] == Sign::Positive && values[i] < 0.0 {
            best.wrong.push(place);
        }
    }
    best.gain.is_finite().then_some((best, Some(open)))
}

/// Subtracts a multiple of a column.
pub(crate) fn subtract(from: &mut Column, column: &Column, factor: f64) {
    for (from, series) in from.0.iter_mut().zip(&column.0) {
        if from.is_empty() && !series.is_empty() {
            *from = vec![0.0; series.len()];
        }
        from.iter_mut()
            .zip(series)
            .for_each(|(f, s)| *f -= factor * s);
    }
}
