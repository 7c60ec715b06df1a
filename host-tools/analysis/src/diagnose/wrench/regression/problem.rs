//! The regression of all logs together: whitened residual, tolerances, and what further columns
//! would gain.

use super::gram::{dot, gram};
use crate::diagnose::noise::autoregressive::AutoregressiveNoise;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;
use std::borrow::Borrow;

/// A column of which tolerances and other columns leave less than this is not determined.
const LEFT: f64 = 1e-6;

/// One log's part of a regression: its noise, and its rows that count.
#[derive(Clone)]
pub(crate) struct Segment {
    /// Autoregressive noise model of each axis.
    pub noise_model: [AutoregressiveNoise; 6],
    /// Rows that count.
    pub fresh: Vec<bool>,
}

/// What is left of the logs after the nominal model, with the tolerances taken into account. The
/// logs stand one behind the other in each series.
pub(crate) struct Problem {
    segments: Vec<Segment>,
    residual: Column,
    tolerances: Vec<Column>,
    /// Cholesky factor of the normal matrix of the tolerances with their priors.
    factor: DMatrix<f64>,
    /// Factor⁻¹ times products of tolerances and residual.
    spent: DVector<f64>,
    /// χ² with the tolerances spent.
    pub chi2: f64,
    /// The same of each log.
    pub chi2_of_logs: Vec<f64>,
    /// Number of axes that were recorded: one that reads 0 throughout has no noise to speak of.
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
    /// From the residual (measured minus nominal) and the tolerances, one column per one tolerance,
    /// of each log.
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
        // One tolerance each is the prior.
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

    /// What is left of the logs, beside what, and how much of it each of them has: equal in every bit for the same problem.
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

    /// Columns of each log as one, in units of the noise.
    pub(crate) fn whitened(&self, columns: &[&Column]) -> Column {
        let mut out = Column::default();
        for (axis, out) in out.0.iter_mut().enumerate() {
            if columns.iter().all(|c| c.0[axis].is_empty()) {
                continue;
            }
            // A library holds hundreds of them.
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

    /// Whether rows of a log count.
    pub(crate) fn counts(&self, log: usize) -> bool {
        self.segments[log].fresh.contains(&true)
    }

    /// The rows of one log in a column of all.
    pub(crate) fn part(&self, column: &Column, log: usize) -> Column {
        let lengths = self.segments.iter().map(|s| s.fresh.len());
        let from: usize = lengths.take(log).sum();
        let to = from + self.segments[log].fresh.len();
        Column(column.0.each_ref().map(|series| match series.is_empty() {
            true => Vec::new(),
            false => series[from..to].to_vec(),
        }))
    }

    /// A column of all logs without the rows of all but one.
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

    /// Products of the tolerances, of whitened columns and of the residual with each other, in this
    /// order.
    pub(crate) fn all_products(&self, columns: &[impl Borrow<Column> + Sync]) -> DMatrix<f64> {
        let columns = columns.iter().map(Borrow::borrow);
        let all = self.tolerances.iter().chain(columns);
        let all: Vec<&Column> = all.chain([&self.residual]).collect();
        gram(&all)
    }

    /// The same with more columns behind those of which `known` are the products.
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

    /// Products of columns with each other and with the residual, after the tolerances have taken
    /// what they can, from [`Self::all_products`].
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

    /// How many nominal parameters the logs determine rather than their tolerances: the trace of what
    /// they add to the knowledge of each.
    pub(crate) fn informed(&self) -> f64 {
        let size = self.factor.nrows();
        let below = self
            .factor
            .solve_lower_triangular(&DMatrix::identity(size, size));
        let kept = below.map_or(0.0, |below| below.norm_squared());
        size as f64 - kept
    }

    /// Mean and standard deviation of each tolerance after the logs, in tolerances, beside a contribution, and where of each of
    /// some columns there may be more or less. All in units of the noise.
    pub(crate) fn tolerances_beside(&self, white: &Column, columns: &[Column]) -> Vec<[f64; 2]> {
        /// Share of a column's square that keeps the sum definite where columns are the same.
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

    /// A column with its products with the tolerances and the residual.
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

    /// Best coefficients of columns in units of the noise.
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

    /// By how much χ² falls with a given contribution, in units of the noise.
    pub(crate) fn gain_of(&self, white: &Column) -> f64 {
        self.projected(white).gain()
    }

    /// By how much a contribution, in units of the noise, lets χ² of each log fall, with what the
    /// tolerances no longer have to take.
    pub(crate) fn gains(&self, white: &Column) -> Vec<f64> {
        let both = self.chi2_of_logs.iter().zip(self.chi2_with(white));
        both.map(|(before, after)| before - after).collect()
    }

    /// χ² of each log with a contribution.
    fn chi2_with(&self, white: &Column) -> Vec<f64> {
        let taken = self.tolerances_with(white);
        let rest = self.rest(white, &taken);
        // What the tolerances cost is of no log more than of another.
        let shared = taken.norm_squared() / self.segments.len().max(1) as f64;
        let of = |log: usize| {
            let part = self.part(&rest, log);
            shared + dot(&part, &part)
        };
        (0..self.segments.len()).map(of).collect()
    }

    /// What a contribution, in units of the noise, and the tolerances leave.
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

    /// What the tolerances take, in units of one tolerance each, beside a contribution in units of
    /// the noise.
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

/// A column in units of the noise, with what the tolerances can take of it.
#[derive(Clone)]
pub(crate) struct Projected<C = Column> {
    /// The column.
    pub column: C,
    /// Its products with the tolerances, in units in which these are independent.
    against: DVector<f64>,
    /// Its product with the residual, after the tolerances.
    pub right: f64,
}

impl<C: Borrow<Column>> Projected<C> {
    /// Product with another one, after the tolerances.
    pub(crate) fn product(&self, other: &Self) -> f64 {
        dot(self.column.borrow(), other.column.borrow()) - self.against.dot(&other.against)
    }

    /// By how much χ² falls with it as it is.
    pub(crate) fn gain(&self) -> f64 {
        2.0 * self.right - self.product(self)
    }
}

/// Products of columns with each other, after the tolerances.
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

/// Best coefficients of some columns of products; None if the data does not determine them.
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

/// A [`Solution`] without its deviations, which cost more than all the rest.
pub(crate) struct Best {
    /// By how much χ² falls.
    pub gain: f64,
    coefficients: Vec<f64>,
    /// Columns whose coefficient has a sign that physics forbids.
    pub wrong: Vec<usize>,
    /// Least share of a column that those before it do not imitate.
    pub own: f64,
}

/// The columns whose coefficients are open, in units of their own length, so that "undetermined" has one meaning.
struct Open {
    places: Vec<usize>,
    scale: Vec<f64>,
    cholesky: Cholesky<f64, Dyn>,
}

impl Open {
    /// None where a column is 0, is no number or follows from the others.
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

    /// See [`Best`].
    fn own(&self) -> f64 {
        let shares = self.cholesky.l_dirty().diagonal().map(|d| d * d);
        shares.iter().copied().fold(1.0, f64::min)
    }
}

/// What [`solve`] finds, without the deviations.
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
