//! Groups of values by a quantity, and how much of a series such a grouping explains (analysis of variance).

use super::correlation::correlated_cycles;
use super::significance::f_p;

/// Smallest number of values in a group.
const LEAST_IN_GROUP: usize = 15;
/// Number of groups of equal size at first; the edges below are added to theirs.
const QUANTILES: usize = 8;
/// Additional edges on both sides of zero, relative to the largest absolute value: a regime of low speed is narrow.
const BESIDE_ZERO: [f64; 5] = [0.002, 1.0 / 16.0, 1.0 / 8.0, 0.25, 0.5];

/// Values of a quantity, sorted into groups.
#[derive(Clone, Debug)]
pub struct Groups {
    /// Edges of the groups in ascending order, one more than there are groups.
    pub edges: Vec<f64>,
    /// Mean of the quantity in each group.
    centres: Vec<f64>,
    /// Values of the quantity; NaN where it is not known.
    values: Vec<f64>,
    /// Group of each value; None for a value in no group. A small type, as there is one for each cycle and quantity.
    of: Vec<Option<u16>>,
    /// Whether values that are in no group form one more group.
    others: bool,
}

impl Groups {
    /// Groups along a quantity. They have equally many values, with additional edges: about zero if that is within the range,
    /// otherwise at equal widths.
    ///
    /// None if the quantity does not fill two groups.
    pub fn along(values: Vec<f64>) -> Option<Self> {
        let sorted = sorted(&values);
        let (low, high) = (*sorted.first()?, *sorted.last()?);
        let mut edges: Vec<f64> = (1..QUANTILES)
            .map(|i| sorted[i * sorted.len() / QUANTILES])
            .collect();
        if low < 0.0 && high > 0.0 {
            let largest = high.max(-low);
            edges.extend(BESIDE_ZERO.iter().flat_map(|p| [p * largest, -p * largest]));
        } else {
            let width = (high - low) / QUANTILES as f64;
            edges.extend((1..QUANTILES).map(|i| low + i as f64 * width));
        }
        Self::between(values, &sorted, edges)
    }

    /// Groups of equal width; small ones are merged.
    pub fn equal(values: Vec<f64>, count: usize) -> Option<Self> {
        let sorted = sorted(&values);
        let (low, high) = (*sorted.first()?, *sorted.last()?);
        let width = (high - low) / count as f64;
        let edges = (1..count).map(|i| low + i as f64 * width).collect();
        Self::between(values, &sorted, edges)
    }

    /// The same groups, and one more of all values that are in none.
    #[must_use]
    pub fn with_others(self) -> Self {
        Self {
            others: true,
            ..self
        }
    }

    /// Groups between inner edges. Small groups are merged.
    fn between(values: Vec<f64>, sorted: &[f64], mut inner: Vec<f64>) -> Option<Self> {
        let (low, high) = (*sorted.first()?, *sorted.last()?);
        inner.sort_by(f64::total_cmp);
        let mut edges = vec![low];
        let mut centres = Vec::new();
        let mut filled = 0;
        let mean = |from: usize, to: usize| {
            sorted[from..to].iter().sum::<f64>() / (to - from).max(1) as f64
        };
        for edge in inner {
            let until = sorted.partition_point(|v| *v < edge);
            let enough = until >= filled + LEAST_IN_GROUP && sorted.len() - until >= LEAST_IN_GROUP;
            if enough {
                edges.push(edge);
                centres.push(mean(filled, until));
                filled = until;
            }
        }
        edges.push(high);
        centres.push(mean(filled, sorted.len()));
        if centres.len() < 2 {
            return None;
        }
        let inner = &edges[1..edges.len() - 1];
        let group = |v: &f64| {
            let place = v.is_finite().then(|| inner.partition_point(|e| e <= v));
            place.and_then(|place| u16::try_from(place).ok())
        };
        let of = values.iter().map(group).collect();
        Some(Self {
            edges,
            centres,
            values,
            of,
            others: false,
        })
    }

    /// Number of groups.
    pub fn len(&self) -> usize {
        self.centres.len()
    }

    /// Never: there are at least two groups.
    pub fn is_empty(&self) -> bool {
        self.centres.is_empty()
    }

    /// Mean of the quantity in each group.
    pub fn centres(&self) -> &[f64] {
        &self.centres
    }

    /// Mean of a series in each group, and how many values it has there.
    pub fn means(&self, series: &[f64]) -> Vec<(f64, usize)> {
        let mut sums = vec![(0.0, 0_usize); self.len() + usize::from(self.others)];
        for (value, group) in series.iter().zip(&self.of) {
            let place = group.map_or(self.len(), usize::from);
            if let Some((sum, count)) = sums.get_mut(place).filter(|_| value.is_finite()) {
                *sum += value;
                *count += 1;
            }
        }
        sums.into_iter()
            .map(|(sum, count)| (sum / count.max(1) as f64, count))
            .collect()
    }

    /// Fits the dependence of a series on the quantity: by steps (the means of the groups) or by straight lines from one mean
    /// to the next, whichever leaves the smaller residual.
    pub fn fit(&self, series: &[f64]) -> Fit {
        let means = self.means(series);
        let steps = self.remainder(series, &means, |_, _, mean| mean);
        let lines = self.remainder(series, &means, |n, group, mean| {
            self.line(&means, n, group).unwrap_or(mean)
        });
        let squares = |rest: &[f64]| -> f64 {
            let known = rest.iter().filter(|v| v.is_finite());
            known.map(|v| v * v).sum()
        };
        let (of_steps, of_lines) = (squares(&steps), squares(&lines));
        let (within, remainder) = if of_lines < of_steps {
            (of_lines, lines)
        } else {
            (of_steps, steps)
        };
        let counted = series.iter().zip(&remainder);
        let counted = counted.filter(|(_, rest)| rest.is_finite());
        let count = counted.clone().count();
        let mean = counted.clone().map(|(v, _)| v).sum::<f64>() / count.max(1) as f64;
        Fit {
            mean,
            about_mean: counted.map(|(v, _)| (v - mean).powi(2)).sum(),
            within,
            groups: means.iter().filter(|(_, n)| *n > 0).count(),
            count,
            remainder,
            straight: self.straight(series),
        }
    }

    /// Fits a straight line through all values. None if there are too few, or if values outside of all groups form a group.
    fn straight(&self, series: &[f64]) -> Option<Straight> {
        let pairs = || {
            let both = series.iter().zip(&self.values);
            both.filter(|(y, x)| y.is_finite() && x.is_finite())
        };
        let count = pairs().count();
        if self.others || count < LEAST_IN_GROUP {
            return None;
        }
        let mean = |sum: f64| sum / count as f64;
        let middle = (
            mean(pairs().map(|(y, _)| y).sum()),
            mean(pairs().map(|(_, x)| x).sum()),
        );
        let along: f64 = pairs().map(|(_, x)| (x - middle.1).powi(2)).sum();
        let both: f64 = pairs().map(|(y, x)| (y - middle.0) * (x - middle.1)).sum();
        let slope = both / along;
        let left = series.iter().zip(&self.values);
        let remainder = left.map(|(y, x)| y - middle.0 - slope * (x - middle.1));
        slope.is_finite().then(|| Straight {
            explained: slope * both,
            remainder: remainder.collect(),
        })
    }

    /// Residual of a series after `fitted(index, group, mean of the group)`; NaN for values that are in no group.
    fn remainder(
        &self,
        series: &[f64],
        means: &[(f64, usize)],
        fitted: impl Fn(usize, usize, f64) -> f64,
    ) -> Vec<f64> {
        let values = series.iter().zip(&self.of).enumerate();
        values
            .map(|(n, (value, group))| {
                let group = group.map_or(self.len(), usize::from);
                means
                    .get(group)
                    .map_or(f64::NAN, |(mean, _)| value - fitted(n, group, *mean))
            })
            .collect()
    }

    /// Value at index n, which is in `group`, on the straight line between the centres on either side of it.
    fn line(&self, means: &[(f64, usize)], n: usize, group: usize) -> Option<f64> {
        let (value, centre) = (*self.values.get(n)?, *self.centres.get(group)?);
        let last = self.len() - 1;
        let other = if group == last || (value < centre && group > 0) {
            group - 1
        } else {
            group + 1
        };
        let run = self.centres.get(other)? - centre;
        let known = means[other].1 > 0 && run != 0.0;
        known.then(|| {
            let rise = means[other].0 - means[group].0;
            means[group].0 + rise * (value - centre) / run
        })
    }
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Sums of squares of an analysis of variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Mean of all values of the series.
    pub mean: f64,
    /// Sum of squares about the mean.
    about_mean: f64,
    /// Sum of squares about the fit.
    within: f64,
    /// Groups with values.
    groups: usize,
    /// Number of values.
    count: usize,
    /// Residual of each value.
    remainder: Vec<f64>,
    straight: Option<Straight>,
}

/// A fitted straight line.
#[derive(Clone, Debug, PartialEq)]
struct Straight {
    /// Sum of squares that its slope explains.
    explained: f64,
    /// Residual of each value.
    remainder: Vec<f64>,
}

impl Fit {
    /// Sum of squares that the fit explains beyond the mean, less the part that so many groups explain by chance.
    pub fn explained_squares(&self) -> f64 {
        let by_chance = self.groups.saturating_sub(1) as f64 * self.residual_variance();
        (self.about_mean - self.within - by_chance).max(0.0)
    }

    /// Sum of squares that the mean explains.
    pub fn explained_by_mean(&self) -> f64 {
        self.count as f64 * self.mean * self.mean
    }

    /// Residual variance of the fit.
    fn residual_variance(&self) -> f64 {
        self.within / self.count.saturating_sub(self.groups).max(1) as f64
    }

    /// p-value of the fit. The residual may be autocorrelated: the number of independent values is reduced by
    /// [`correlated_cycles`].
    ///
    /// Few independent values do not support many groups, but may support a straight line. The smaller p-value of the two
    /// counts, doubled as there are two tests.
    pub fn p(&self) -> f64 {
        let groups = self.groups.saturating_sub(1);
        let of_groups = p_of(self.about_mean - self.within, groups, &self.remainder);
        let straight = self.straight.as_ref();
        let of_line = straight.map_or(1.0, |s| p_of(s.explained, 1, &s.remainder));
        (2.0 * of_groups.min(of_line)).min(1.0)
    }
}

/// p-value of an F test of a fit with `parameters` parameters beside the mean.
fn p_of(explained: f64, parameters: usize, remainder: &[f64]) -> f64 {
    let known = remainder.iter().filter(|v| v.is_finite());
    let (squares, count) = known.fold((0.0, 0), |(sum, n), v| (sum + v * v, n + 1));
    let together = correlated_cycles(remainder);
    let numerator = parameters as f64;
    let left = squares / (f64::from(count) - numerator - 1.0).max(1.0);
    let denominator = f64::from(count) / together - numerator - 1.0;
    if numerator < 1.0 || denominator < 1.0 || explained <= 0.0 {
        return 1.0;
    }
    let statistic = explained / numerator / (left * together);
    f_p(statistic, numerator, denominator)
}

#[cfg(test)]
mod tests {
    use super::super::noise_floor::tests::normal;
    use super::*;

    fn slow(count: usize) -> Vec<f64> {
        (0..count).map(|n| (n as f64 * 0.013).sin()).collect()
    }

    #[test]
    fn groups_are_filled_and_fine_about_zero() {
        let groups = Groups::along(slow(2500)).unwrap();
        let sizes = groups.means(&vec![1.0; 2500]);
        assert!(sizes.iter().all(|(_, n)| *n >= LEAST_IN_GROUP), "{sizes:?}");
        assert_eq!(sizes.iter().map(|(_, n)| n).sum::<usize>(), 2500);
        let narrowest = groups.edges.windows(2).map(|w| w[1] - w[0]);
        assert!(narrowest.fold(9.0, f64::min) < 0.1);
        assert!(Groups::along(vec![1.0; 500]).is_none());
        assert!(Groups::along(vec![f64::NAN; 500]).is_none());
        assert!(Groups::along(Vec::new()).is_none());
    }

    #[test]
    fn signs_and_slopes_are_explained() {
        let along = slow(2500);
        for shape in [|x: f64| 2.0 * x.signum(), |x: f64| 3.0 * x] {
            let series: Vec<f64> = along
                .iter()
                .zip(normal(2500, 1))
                .map(|(x, noise)| 5.0 + shape(*x) + noise)
                .collect();
            let fit = Groups::along(along.clone()).unwrap().fit(&series);
            let signal: f64 = along.iter().map(|x| shape(*x).powi(2)).sum();
            let share = fit.explained_squares() / signal;
            assert!((share - 1.0).abs() < 0.05, "{share}");
            assert!((fit.mean - 5.0).abs() < 0.15, "{}", fit.mean);
            assert!(fit.p() < 1e-12);
        }
    }

    #[test]
    fn noise_white_or_slow_is_not() {
        let groups = Groups::along(slow(2500)).unwrap();
        for seed in 0..50 {
            let noise = normal(2600, seed);
            assert!(groups.fit(&noise[..2500]).p() > 0.001, "white {seed}");
            let slow: Vec<f64> = noise.windows(100).map(|w| w.iter().sum()).collect();
            assert!(groups.fit(&slow[..2500]).p() > 0.001, "slow {seed}");
        }
    }
}
