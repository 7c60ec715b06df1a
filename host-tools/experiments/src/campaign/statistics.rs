//! Statistics of many rows: shares and quantiles with intervals, and which factor matters.
//!
//! All intervals have 95 % confidence, and none assumes a distribution of the outcome. Rows of one draw have values and noise
//! in common and may be fully correlated, so an interval is that of as many independent values as there are draws. This holds
//! for any correlation within a draw. A single draw gives no interval.

use serde::Serialize;
use softdock_statistics::DEVIATIONS_95 as Z;
use statrs::distribution::{Binomial, DiscreteCDF};

/// Probability beyond each end of an interval.
const TAIL: f64 = 0.025;

/// An estimate with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Lower end; None if there are too few draws.
    pub low: Option<f64>,
    /// Upper end; None if there are too few draws.
    pub high: Option<f64>,
}

/// A share of rows, with Wilson's score interval (1927) for `draws` independent values, which stays valid at 0 and 1. None
/// without rows.
pub fn share(count: usize, of: usize, draws: usize) -> Option<Estimate> {
    if of == 0 {
        return None;
    }
    let (n, p) = (draws as f64, count as f64 / of as f64);
    let center = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let drawn = draws > 1;
    Some(Estimate {
        value: p,
        low: drawn.then_some((center - half).max(0.0)),
        high: drawn.then_some((center + half).min(1.0)),
    })
}

/// A quantile of ordered values from `draws` independent draws. Its interval lies between two order statistics, which is
/// valid for any distribution (David and Nagaraja, Order Statistics, section 7.1). None without values.
pub fn quantile(ordered: &[f64], draws: usize, q: f64) -> Option<Estimate> {
    let count = ordered.len();
    let place = (q * count as f64).ceil().max(1.0) as usize - 1;
    let value = *ordered.get(place)?;
    let below = Binomial::new(q, draws as u64).ok()?;
    // P(fewer than k of the draws lie below the quantile).
    let fewer = |k: usize| k.checked_sub(1).map_or(0.0, |k| below.cdf(k as u64));
    let all: Vec<usize> = (0..=draws).collect();
    let low = all.partition_point(|k| fewer(*k) <= TAIL).checked_sub(2);
    let high = all
        .partition_point(|k| 1.0 - fewer(*k) > TAIL)
        .checked_sub(1);
    let high = high.filter(|k| *k < draws);
    // Each draw stands for `count / draws` consecutive values: the interval reaches from the first value of one block to the
    // last of another.
    let first = |k: usize| ordered[k * count / draws];
    let last = |k: usize| ordered[((k + 1) * count).div_ceil(draws) - 1];
    Some(Estimate {
        value,
        low: low.map(first),
        high: high.map(last),
    })
}

/// Spearman's rank correlation; None if one of the two does not vary.
pub fn rank_correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    let (x, y) = (ranks(x), ranks(y));
    let (cross, xx, yy) = (covariance(&x, &y), covariance(&x, &x), covariance(&y, &y));
    (xx > 0.0 && yy > 0.0).then(|| cross / (xx * yy).sqrt())
}

/// Correlation ratio of ranks, for a factor with words: square root of the share of the variance of ranks between groups.
/// None if nothing varies.
pub fn rank_ratio(groups: &[usize], y: &[f64]) -> Option<f64> {
    let y = ranks(y);
    let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
    let total = covariance(&y, &y) * y.len() as f64;
    let between = |group: usize| {
        let own: Vec<f64> = groups
            .iter()
            .zip(&y)
            .filter(|(g, _)| **g == group)
            .map(|(_, y)| *y)
            .collect();
        if own.is_empty() {
            return 0.0;
        }
        let count = own.len() as f64;
        count * (own.iter().sum::<f64>() / count - mean).powi(2)
    };
    let count = groups.iter().max().map_or(0, |last| last + 1);
    let between: f64 = (0..count).map(between).sum();
    (total > 0.0).then(|| (between / total).sqrt())
}

/// Ranks from 1; equal values share the mean of their ranks.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    for equal in order.chunk_by(|a, b| values[*a] == values[*b]) {
        let first = order.partition_point(|i| values[*i].total_cmp(&values[equal[0]]).is_lt());
        let mean = first as f64 + (equal.len() as f64 + 1.0) / 2.0;
        equal.iter().for_each(|i| ranks[*i] = mean);
    }
    ranks
}

fn covariance(x: &[f64], y: &[f64]) -> f64 {
    let count = x.len().max(1) as f64;
    let (mx, my) = (x.iter().sum::<f64>() / count, y.iter().sum::<f64>() / count);
    x.iter()
        .zip(y)
        .map(|(x, y)| (x - mx) * (y - my))
        .sum::<f64>()
        / count
}

/// First-order and total Sobol' index of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SobolIndices {
    /// Share of the variance that the factor explains alone.
    pub first: f64,
    /// Share of the variance that the factor explains alone or in interactions.
    pub total: f64,
}

/// Sobol' indices of each axis from the runs A, B, A with axis 1 of B, ... of each sample: Saltelli et al. (Comput.
/// Phys. Commun. 181, 2010, table 2: b and f). None where nothing varies.
pub fn sobol_indices(samples: &[Vec<f64>]) -> Vec<SobolIndices> {
    let axes = samples
        .first()
        .map_or(0, |runs| runs.len().saturating_sub(2));
    let count = samples.len().max(1) as f64;
    let ab: Vec<f64> = samples.iter().flat_map(|runs| [runs[0], runs[1]]).collect();
    if ab.iter().all(|value| *value == ab[0]) {
        return Vec::new();
    }
    let variance = covariance(&ab, &ab);
    let mean = ab.iter().sum::<f64>() / ab.len().max(1) as f64;
    let index = |axis: usize| {
        let first = |runs: &Vec<f64>| (runs[1] - mean) * (runs[axis + 2] - runs[0]);
        let total = |runs: &Vec<f64>| (runs[0] - runs[axis + 2]).powi(2) / 2.0;
        SobolIndices {
            first: samples.iter().map(first).sum::<f64>() / count / variance,
            total: samples.iter().map(total).sum::<f64>() / count / variance,
        }
    };
    (0..axes).map(index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::design::{Design, Kind};
    use std::f64::consts::PI;

    #[test]
    fn wilson_intervals_are_those_of_the_tables() {
        // Newcombe, Statistics in Medicine 17 (1998), table I: 81/263, 15/148, 0/20, 1/29.
        for (count, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let share = share(count, of, of).unwrap();
            assert!((share.low.unwrap() - low).abs() < 5e-5, "{share:?}");
            assert!((share.high.unwrap() - high).abs() < 5e-5, "{share:?}");
        }
        assert_eq!(share(0, 0, 0), None);
    }

    /// Four equal rows give no narrower interval than one, and a single draw gives none.
    #[test]
    fn rows_of_one_draw_narrow_no_interval() {
        assert_eq!(share(388, 400, 100), share(97, 100, 100));
        let draws: Vec<f64> = (1..=20).map(f64::from).collect();
        let rows: Vec<f64> = draws.iter().flat_map(|value| [*value; 4]).collect();
        for q in [0.05, 0.5, 0.95] {
            assert_eq!(quantile(&rows, 20, q), quantile(&draws, 20, q));
        }
        let exhaustive = [share(3, 4, 1).unwrap(), quantile(&draws, 1, 0.5).unwrap()];
        for estimate in exhaustive {
            assert_eq!((estimate.low, estimate.high), (None, None));
        }
    }

    #[test]
    fn bounds_of_the_median_are_those_of_the_sign_test() {
        // The sign test's interval at n = 10 is the 2nd to the 9th value, at n = 20 the 6th to the 15th.
        for (count, low, high) in [(10, 2.0, 9.0), (20, 6.0, 15.0)] {
            let values: Vec<f64> = (1..=count).map(f64::from).collect();
            let median = quantile(&values, values.len(), 0.5).unwrap();
            assert_eq!((median.low, median.high), (Some(low), Some(high)));
        }
        let five = quantile(&[1.0, 2.0, 3.0, 4.0, 5.0], 5, 0.95).unwrap();
        assert_eq!((five.value, five.high), (5.0, None));
        assert_eq!(quantile(&[], 0, 0.5), None);
    }

    #[test]
    fn rank_correlation_sees_any_monotonic_law() {
        let x: Vec<f64> = (0..50).map(f64::from).collect();
        let cubed: Vec<f64> = x.iter().map(|x| -x.powi(3)).collect();
        assert!((rank_correlation(&x, &cubed).unwrap() + 1.0).abs() < 1e-12);
        assert_eq!(rank_correlation(&x, &[1.0; 50]), None);
        // With ties: Kendall, Rank Correlation Methods, ranks 1.5 1.5 3 against 1 2 3.
        let tied = rank_correlation(&[1.0, 1.0, 2.0], &[1.0, 2.0, 3.0]).unwrap();
        assert!((tied - 0.75_f64.sqrt()).abs() < 1e-12);
        assert!((rank_ratio(&[0, 0, 1, 1], &[1.0, 1.0, 2.0, 2.0]).unwrap() - 1.0).abs() < 1e-12);
    }

    /// Known answer: Ishigami's function (a = 7, b = 0.1): S = 0.3139, 0.4424, 0; T = 0.5576, 0.4424, 0.2437.
    #[test]
    fn sobol_indices_of_the_ishigami_function() {
        let axes = ["x", "y", "z"].map(str::to_owned);
        let design = Design::new(Kind::Saltelli, 1, &axes, 4096).unwrap();
        let f = |point: u64| {
            let [x, y, z] = [0, 1, 2].map(|axis| PI * (2.0 * design.coordinate(point, axis) - 1.0));
            x.sin() + 7.0 * y.sin().powi(2) + 0.1 * z.powi(4) * x.sin()
        };
        let samples: Vec<Vec<f64>> = (0..4096)
            .map(|s| (0..5).map(|run| f(5 * s + run)).collect())
            .collect();
        let expected = [(0.3139, 0.5576), (0.4424, 0.4424), (0.0, 0.2437)];
        for (found, (first, total)) in sobol_indices(&samples).into_iter().zip(expected) {
            assert!(
                (found.first - first).abs() < 0.02,
                "{found:?} instead of {first}"
            );
            assert!(
                (found.total - total).abs() < 0.02,
                "{found:?} instead of {total}"
            );
        }
        assert_eq!(sobol_indices(&vec![vec![0.1; 5]; 100]), []);
    }
}
