//! A smooth remainder beside the effects of a hypothesis: what real machines leave that no law of the
//! catalogue describes.
//!
//! On each axis whose residual has structure it is a sum of smooth [`functions`] of position, of position in each direction, of
//! velocity, of acceleration, of the depth of a contact and of time. Each group of functions has one variance, which is found by
//! the evidence of all logs together (MacKay 1992; Tipping 2001). An effect counts if it explains what the remainder in its place
//! would not: compare Zhu et al., Mech. Syst. Signal Process. 168 (2022) 108660. The power that even the remainder leaves at the
//! frequencies of effects says how much less than a value of white noise each value counts.

mod functions;
mod ripple;

pub(crate) use functions::Quantity;
pub(crate) use ripple::{Ripple, ripples};

use super::regression::fitted::Fitted;
use super::regression::joint::{Joint, Smooth};
use super::regression::problem::subtract;
use super::regression::tested::TestedHypothesis;
use crate::diagnose::evidence;
use crate::diagnose::noise::structure::SLOW_HZ;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use softdock_physics::model::load::Column;
use softdock_physics::model::{Axis, Model};
use softdock_statistics::{DEVIATIONS_95, periodogram};
use std::ops::Range;

/// Most iterations for the variances.
const ROUNDS: usize = 40;
/// Change of 2 ln of the evidence per iteration below which they have converged: decisions need differences of 6 or more.
const SETTLED: f64 = 1e-3;
/// Starting precisions of the amplitudes, relative to the mean precision with which the logs determine them: for a remainder that
/// explains all it can, and for one that explains little.
const STARTS: [f64; 2] = [1e-4, 1e-1];

/// How an effect stands beside the remainder.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    /// Evidence for it beside the remainder and the other effects.
    pub evidence: f64,
    /// Ratio of its amount beside the remainder to that without, and the standard deviation of this ratio.
    pub amount: (f64, f64),
}

impl Standing {
    /// Whether the logs determine the effect: the 95 % interval of its amount leaves out 0.
    pub(crate) fn determines(&self, effect: &Fitted, model: &Model) -> bool {
        let (amount, deviation) = self.amount;
        let mut effect = effect.clone();
        effect.record_amount_ratio(self.amount);
        amount > DEVIATIONS_95 * deviation && effect.is_determined(model)
    }
}

/// How effects stand beside a remainder on these axes. The `earlier` effects, which the residual is already without, come first,
/// then those of a hypothesis.
pub(crate) fn standings(
    joint: &Joint,
    earlier: &[Fitted],
    tested: &TestedHypothesis,
    axes: &[Axis],
) -> Vec<Standing> {
    let regression = Regression::new(joint, earlier, tested, axes);
    let all: Vec<usize> = (0..regression.effects.len()).collect();
    let with = regression.fit(&all);
    let amounts = regression.amounts(&with);
    let price = evidence::price(joint.problem.count);
    let standing = |(k, effect): (usize, &Fitted)| {
        let terms = regression.effects[k].len() as f64;
        let (without, paid) = match effect.plain(&joint.logs[0].scene.model) {
            // A detail is compared with the plain effect that it is a detail of.
            Some(plain) => (regression.with_plain(k, &plain).fit(&all), terms - 1.0),
            None => {
                let others: Vec<usize> = all.iter().copied().filter(|i| *i != k).collect();
                (regression.fit(&others), terms)
            }
        };
        let prior = if paid < terms { 0.0 } else { evidence::prior() };
        let paid = price * paid + prior;
        Standing {
            evidence: with.evidence - without.evidence - paid,
            amount: amounts[k],
        }
    };
    let effects = earlier.iter().chain(&tested.effects).enumerate();
    effects.map(standing).collect()
}

/// The smooth remainder beside a hypothesis, for a search beside it.
pub(crate) fn smooth(joint: &Joint, tested: &TestedHypothesis, axes: &[Axis]) -> Smooth {
    let regression = Regression::new(joint, &[], tested, axes);
    let all: Vec<usize> = (0..regression.effects.len()).collect();
    let fit = regression.fit(&all);
    let groups = axes
        .iter()
        .flat_map(|axis| functions::of_axis(&joint.logs, axis.index()));
    let mut functions = vec![Vec::new(); joint.logs.len()];
    for (group, precision) in groups.zip(&fit.precisions) {
        for function in group.functions {
            for (own, mut column) in functions.iter_mut().zip(function) {
                column.scale(precision.sqrt().recip());
                own.push(column);
            }
        }
    }
    Smooth {
        functions,
        axes: axes.to_vec(),
        kappa: regression.kappa,
    }
}

/// 2 ln of the evidence for each hypothesis beside a remainder, less the prices of its parameters. All use the smallest `kappa`,
/// that of the hypothesis that leaves least.
pub(crate) fn worths(joint: &Joint, all: &[&TestedHypothesis], axes: &[Axis]) -> Vec<f64> {
    let mut regressions: Vec<Regression> = all
        .iter()
        .map(|tested| Regression::new(joint, &[], tested, axes))
        .collect();
    let kappas = regressions.iter().map(|r| r.kappa);
    let least = kappas.fold(f64::INFINITY, f64::min);
    let price = evidence::price(joint.problem.count);
    let both = regressions.iter_mut().zip(all);
    let worth = |(regression, tested): (&mut Regression, &&TestedHypothesis)| {
        regression.count_less(least / regression.kappa);
        let each: Vec<usize> = (0..regression.effects.len()).collect();
        let paid = price * tested.parameters as f64 + evidence::prior() * each.len() as f64;
        regression.fit(&each).evidence - paid
    };
    both.map(worth).collect()
}

/// The smooth remainder as a series, and what it depends on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Remainder {
    /// Its values on each log, N or N·m.
    pub of_logs: Vec<Column>,
    /// Axis and quantity of each group, and the power of the group as a share of the sum over all groups; the largest first.
    pub follows: Vec<(Axis, Quantity, f64)>,
}

impl Remainder {
    /// Whether any group depends on the depth of a contact.
    pub(crate) fn is_of_contact(&self) -> bool {
        let contact =
            |quantity: Quantity| matches!(quantity, Quantity::Depth | Quantity::DampedDepth);
        self.follows
            .iter()
            .any(|(_, quantity, _)| contact(*quantity))
    }
}

/// The remainder on these axes, with the effects held at their amounts.
pub(crate) fn remainder(
    joint: &Joint,
    earlier: &[Fitted],
    tested: &TestedHypothesis,
    axes: &[Axis],
) -> Remainder {
    let regression = Regression::new(joint, earlier, tested, axes);
    let all: Vec<usize> = (0..regression.effects.len()).collect();
    let (amplitudes, shares) = regression.amplitudes(&regression.fit(&all));
    let mut of_logs = vec![Column::default(); joint.logs.len()];
    let groups = axes.iter().flat_map(|axis| {
        let groups = functions::of_axis(&joint.logs, axis.index());
        groups.into_iter().map(|group| (*axis, group))
    });
    let (mut follows, mut amplitudes) = (Vec::new(), amplitudes.into_iter());
    for ((axis, group), share) in groups.zip(shares) {
        follows.push((axis, group.quantity, share));
        for (function, amplitude) in group.functions.iter().zip(&mut amplitudes) {
            for (sum, column) in of_logs.iter_mut().zip(function) {
                subtract(sum, column, -amplitude);
            }
        }
    }
    follows.sort_by(|a, b| b.2.total_cmp(&a.2));
    Remainder { of_logs, follows }
}

/// Diagonal of the inverse of a matrix with a given Cholesky factor: the squared norms of the columns of the factor's inverse.
/// The whole inverse would take six times as long.
fn variances(factor: &Cholesky<f64, Dyn>) -> Vec<f64> {
    let lower = factor.l_dirty();
    let size = lower.nrows();
    let of_column = |first: usize| {
        let mut column = vec![0.0; size - first];
        column[0] = 1.0;
        for k in 0..column.len() {
            let below = &lower.as_slice()[(first + k) * (size + 1)..(first + k + 1) * size];
            let value = column[k] / below[0];
            column[k] = value;
            for (left, factor) in column[k + 1..].iter_mut().zip(&below[1..]) {
                *left -= value * factor;
            }
        }
        column.iter().map(|value| value * value).sum()
    };
    (0..size).map(of_column).collect()
}

/// The regression of effects and remainder: whitened, nuisance parameters eliminated.
struct Regression {
    /// Columns of the terms of effects, then of the functions.
    columns: Vec<Column>,
    gram: DMatrix<f64>,
    right: DVector<f64>,
    /// Range of columns of each effect.
    effects: Vec<Range<usize>>,
    /// Range of each group of functions, counted from the first function.
    groups: Vec<Range<usize>>,
    /// Number of values that count as one value of white noise.
    kappa: f64,
}

/// The remainder with the largest evidence beside some effects.
struct Fit {
    /// 2 ln of the evidence for the remainder, with the effects at their best amounts.
    evidence: f64,
    /// One over the variance of each group.
    precisions: Vec<f64>,
}

impl Regression {
    fn new(joint: &Joint, earlier: &[Fitted], tested: &TestedHypothesis, axes: &[Axis]) -> Self {
        let problem = &joint.problem;
        let whole = |columns: &[Column]| problem.whitened(&columns.iter().collect::<Vec<_>>());
        let model = &joint.logs[0].scene.model;
        let mut columns: Vec<Column> = Vec::new();
        let mut effects = Vec::new();
        for effect in earlier.iter().chain(&tested.effects) {
            let from = columns.len();
            let each = effect.terms(model).into_iter();
            columns.extend(each.map(|term| joint.white_part_of(tested, &term)));
            effects.push(from..columns.len());
        }
        let first = columns.len();
        let mut groups = Vec::new();
        for axis in axes {
            for group in functions::of_axis(&joint.logs, axis.index()) {
                let from = columns.len() - first;
                columns.extend(group.functions.iter().map(|function| whole(function)));
                groups.push(from..columns.len() - first);
            }
        }
        let (gram, mut right) = problem.after_tolerances(&problem.all_products(&columns));
        for k in effects[..earlier.len()].iter().flat_map(Range::clone) {
            right += gram.column(k);
        }
        let mut regression = Self {
            columns,
            gram,
            right,
            effects,
            groups,
            kappa: 1.0,
        };
        let all: Vec<usize> = (0..regression.effects.len()).collect();
        let every_value = regression.fit(&all);
        regression.count_less(regression.left_over(joint, earlier.len(), axes, &every_value));
        regression
    }

    /// Number of columns of effects.
    fn terms(&self) -> usize {
        self.effects.last().map_or(0, |last| last.end)
    }

    /// The same regression where effect `k` has one column only: the sum of its columns times these amounts.
    fn with_plain(&self, k: usize, amounts: &[f64]) -> Self {
        let own = self.effects[k].clone();
        let less = own.len() - 1;
        let mut sums = DMatrix::identity(self.gram.nrows(), self.gram.nrows());
        let mut sum = sums.column_mut(own.start);
        sum.rows_range_mut(own.clone()).copy_from_slice(amounts);
        let sums = sums.remove_columns(own.start + 1, less);
        let moved = |range: &Range<usize>| match range.start > own.start {
            true => range.start - less..range.end - less,
            false => range.start..range.end.min(own.start + 1).max(range.start),
        };
        let effects = self.effects.iter().enumerate();
        Self {
            columns: Vec::new(),
            gram: sums.tr_mul(&self.gram) * &sums,
            right: sums.tr_mul(&self.right),
            effects: effects
                .map(|(i, range)| if i < k { range.clone() } else { moved(range) })
                .collect(),
            groups: self.groups.clone(),
            kappa: self.kappa,
        }
    }

    /// Divides the weight of all values by `kappa`.
    fn count_less(&mut self, kappa: f64) {
        self.gram /= kappa;
        self.right /= kappa;
        self.kappa *= kappa;
    }

    /// The best remainder beside some of the effects, from two starting points.
    fn fit(&self, chosen: &[usize]) -> Fit {
        let fits = STARTS.map(|start| self.fit_from(chosen, start));
        let [much, little] = fits;
        match much.evidence > little.evidence {
            true => much,
            false => little,
        }
    }

    fn fit_from(&self, chosen: &[usize], start: f64) -> Fit {
        let (gram, right, gain) = self.beside(chosen);
        let known = |group: &Range<usize>| {
            let sum: f64 = group.clone().map(|i| gram[(i, i)]).sum();
            start * (sum / group.len() as f64).max(f64::MIN_POSITIVE)
        };
        let mut precisions: Vec<f64> = self.groups.iter().map(known).collect();
        let mut best = Fit {
            evidence: f64::NEG_INFINITY,
            precisions: precisions.clone(),
        };
        let mut last = f64::NEG_INFINITY;
        for _ in 0..ROUNDS {
            let Some(normal) = self.normal(&gram, 0, &precisions) else {
                break;
            };
            let mean = normal.solve(&right);
            let both = self.groups.iter().zip(&precisions);
            let prior: f64 = both.map(|(group, p)| group.len() as f64 * p.ln()).sum();
            let determinant = 2.0 * normal.l_dirty().diagonal().map(f64::ln).sum();
            let evidence = gain + right.dot(&mean) - determinant + prior;
            if evidence > best.evidence {
                best = Fit {
                    evidence,
                    precisions: precisions.clone(),
                };
            }
            if (evidence - last).abs() < SETTLED {
                break;
            }
            last = evidence;
            let variances = variances(&normal);
            for (group, precision) in self.groups.iter().zip(&mut precisions) {
                let squares: f64 = group.clone().map(|i| mean[i] * mean[i]).sum();
                let trace: f64 = variances[group.clone()].iter().sum();
                let informed = (group.len() as f64 - *precision * trace).max(1e-6);
                *precision = (informed / squares).clamp(1e-12, 1e12);
            }
        }
        best
    }

    /// Cholesky factor of the normal matrix: products plus the precisions of the functions, whose first row is `first`.
    fn normal(
        &self,
        gram: &DMatrix<f64>,
        first: usize,
        precisions: &[f64],
    ) -> Option<Cholesky<f64, Dyn>> {
        let mut normal = gram.clone();
        for (group, precision) in self.groups.iter().zip(precisions) {
            for i in group.clone() {
                normal[(first + i, first + i)] += precision;
            }
        }
        Cholesky::new(normal)
    }

    /// Products of the functions with the effects projected out, and the gain in χ² of the effects alone.
    fn beside(&self, chosen: &[usize]) -> (DMatrix<f64>, DVector<f64>, f64) {
        let (functions, right) = self.functions();
        if chosen.is_empty() {
            return (functions, right, 0.0);
        }
        let terms = chosen.iter().flat_map(|k| self.effects[*k].clone());
        let terms: Vec<usize> = terms.collect();
        let rows = self.gram.select_rows(&terms);
        let across = rows.columns(self.terms(), functions.nrows()).into_owned();
        let own_right = self.right.select_rows(&terms);
        let Some(own) = Cholesky::new(rows.select_columns(&terms)) else {
            return (functions, right, 0.0);
        };
        let best = own.solve(&own_right);
        (
            functions - across.tr_mul(&own.solve(&across)),
            right - across.tr_mul(&best),
            own_right.dot(&best),
        )
    }

    /// Products of the functions, effects not considered.
    fn functions(&self) -> (DMatrix<f64>, DVector<f64>) {
        let first = self.terms();
        let size = self.gram.nrows() - first;
        (
            self.gram.view((first, first), (size, size)).into_owned(),
            self.right.rows(first, size).into_owned(),
        )
    }

    /// Amplitudes of the functions beside the effects at their amounts, and the power of each group as a share of the sum over
    /// all.
    fn amplitudes(&self, fit: &Fit) -> (Vec<f64>, Vec<f64>) {
        let (functions, mut right) = self.functions();
        for k in 0..self.terms() {
            right -= self.gram.view((self.terms(), k), (right.len(), 1));
        }
        let Some(normal) = self.normal(&functions, 0, &fit.precisions) else {
            return (vec![0.0; right.len()], vec![0.0; self.groups.len()]);
        };
        let amplitudes = normal.solve(&right);
        // Each group is taken by itself, as groups that cancel each other in part would have more power than their sum.
        let power = |group: &Range<usize>| -> f64 {
            let (from, count) = (group.start, group.len());
            let own = amplitudes.rows(from, count);
            own.dot(&(functions.view((from, from), (count, count)) * own))
        };
        let all: f64 = self.groups.iter().map(power).sum();
        let share = |group: &Range<usize>| power(group) / all.max(f64::MIN_POSITIVE);
        let shares = self.groups.iter().map(share).collect();
        (amplitudes.as_slice().to_vec(), shares)
    }

    /// Ratio of each effect's amount beside the remainder to that without, and its standard deviation. Of an effect with several
    /// terms it is the amount along their values without the remainder.
    fn amounts(&self, fit: &Fit) -> Vec<(f64, f64)> {
        let Some(normal) = self.normal(&self.gram, self.terms(), &fit.precisions) else {
            return vec![(0.0, f64::INFINITY); self.effects.len()];
        };
        let mean = normal.solve(&self.right);
        let inverse = normal.inverse();
        let amount = |terms: &Range<usize>| {
            let own = self
                .gram
                .view((terms.start, terms.start), (terms.len(), terms.len()));
            let along = own.column_sum();
            let along = &along / along.sum().max(f64::MIN_POSITIVE);
            let covariance = inverse.view((terms.start, terms.start), (terms.len(), terms.len()));
            let variance = along.dot(&(covariance * &along));
            let amount = along.dot(&mean.rows_range(terms.clone()));
            (amount, variance.max(0.0).sqrt())
        };
        self.effects.iter().map(amount).collect()
    }

    /// Mean power, in units of the noise, that effects and remainder leave on these axes at the frequencies of effects; at least
    /// 1.
    fn left_over(&self, joint: &Joint, earlier: usize, axes: &[Axis], fit: &Fit) -> f64 {
        let Some(normal) = self.normal(&self.gram, self.terms(), &fit.precisions) else {
            return 1.0;
        };
        let known = self.effects[..earlier].last().map_or(0, |last| last.end);
        let mut sum = Column::default();
        let amounts = normal.solve(&self.right);
        for (k, (column, amount)) in self.columns.iter().zip(&amounts).enumerate() {
            let known = if k < known { 1.0 } else { 0.0 };
            subtract(&mut sum, column, known - amount);
        }
        let rest = joint
            .problem
            .rest(&sum, &joint.problem.tolerances_with(&sum));
        let mut powers = Vec::new();
        for (k, log) in joint.logs.iter().enumerate() {
            let part = joint.problem.part(&rest, k);
            for axis in axes {
                let counted = part.0[axis.index()].iter().zip(&log.fresh);
                let series: Vec<f64> = counted
                    .filter(|(_, fresh)| **fresh)
                    .map(|(r, _)| *r)
                    .collect();
                let bins = (SLOW_HZ * log.counted_cycle_s() * series.len() as f64) as usize;
                let power: Vec<f64> = periodogram(&series).into_iter().take(bins.max(1)).collect();
                powers.push(power.iter().sum::<f64>() / power.len().max(1) as f64);
            }
        }
        (powers.iter().sum::<f64>() / powers.len().max(1) as f64).max(1.0)
    }
}
