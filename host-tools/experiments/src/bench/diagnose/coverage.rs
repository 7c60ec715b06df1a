//! How often a 95 % interval contains the true value.

use super::Row;
use serde::Serialize;
use softdock_hidden_effects::score::Rate;
use std::collections::{BTreeMap, BTreeSet};

/// With fewer cases than this the share is hardly informative.
pub const FEW: usize = 20;

/// Coverage of the intervals of one effect, or of all.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Coverage {
    /// Id of the effect, or `all`.
    pub effect: String,
    /// Cases in which the effect was hidden and named.
    pub cases: usize,
    /// Intervals that contain the true value.
    pub right: usize,
    /// Number of intervals.
    pub of: usize,
}

impl Coverage {
    /// Coverage in some rows, of one effect or (None) of all effects.
    fn of(effect: Option<&str>, rows: &[Row]) -> Self {
        let counts = |id: &str| effect.is_none_or(|effect| effect == id);
        let mut cases = BTreeSet::new();
        let mut rate = Rate::default();
        for row in rows {
            for interval in row.intervals.iter().filter(|i| counts(&i.effect)) {
                cases.insert(&row.name);
                rate.of += 1;
                rate.right += usize::from(interval.covers());
            }
        }
        Self {
            effect: effect.unwrap_or("all").to_owned(),
            cases: cases.len(),
            right: rate.right,
            of: rate.of,
        }
    }

    /// Share of the intervals that contain the true value.
    pub fn share(&self) -> f64 {
        self.right as f64 / self.of.max(1) as f64
    }
}

/// Coverage of each effect, the worst first, and of all of them at the end.
pub fn coverage(rows: &[Row]) -> Vec<Coverage> {
    let intervals = rows.iter().flat_map(|row| &row.intervals);
    let effects: BTreeSet<&str> = intervals.map(|i| i.effect.as_str()).collect();
    let mut all: Vec<Coverage> = effects
        .into_iter()
        .map(|effect| Coverage::of(Some(effect), rows))
        .collect();
    all.sort_by(|a, b| a.share().total_cmp(&b.share()));
    all.push(Coverage::of(None, rows));
    all
}

/// Calibration of probabilities: how many of the effects that were named with a probability in a range were hidden.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReliabilityBin {
    /// Lower end of the range, included.
    pub from: f64,
    /// Upper end of the range.
    pub to: f64,
    /// Number of these effects that were hidden.
    pub right: usize,
    /// Number of effects that were named.
    pub of: usize,
}

/// Ends of the ranges of a probability.
const ENDS: [f64; 6] = [0.0, 0.5, 0.8, 0.95, 0.99, 1.0];

/// Calibration of the probabilities of named effects, by range.
pub fn reliability(rows: &[Row]) -> Vec<ReliabilityBin> {
    let mut named: BTreeMap<usize, Rate> = BTreeMap::new();
    for row in rows {
        for id in &row.effects {
            let Some(p) = row.probability.get(id) else {
                continue;
            };
            let range = ENDS[1..ENDS.len() - 1].partition_point(|end| end <= p);
            let rate = named.entry(range).or_default();
            rate.of += 1;
            rate.right += usize::from(row.hidden.contains(id));
        }
    }
    let ranges = ENDS.windows(2).enumerate();
    ranges
        .map(|(k, ends)| {
            let rate = named.get(&k).copied().unwrap_or_default();
            ReliabilityBin {
                from: ends[0],
                to: ends[1],
                right: rate.right,
                of: rate.of,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::diagnose::truth::Interval;
    use softdock_hidden_effects::{Level, NoiseRange, Verdict};

    fn row(effect: &str, truth: f64, probability: f64) -> Row {
        Row {
            name: format!("{effect} {truth}"),
            level: Level::Single,
            size: 1.0,
            noise: NoiseRange::Usual,
            hidden: vec!["guide_coulomb".to_owned()],
            verdict: Verdict::Named,
            effects: vec![effect.to_owned()],
            right: true,
            drop_percent: None,
            seconds: 1.0,
            sentence: String::new(),
            probability: BTreeMap::from([(effect.to_owned(), probability)]),
            intervals: vec![Interval {
                effect: effect.to_owned(),
                parameter: "force_n".to_owned(),
                truth,
                low: 1.0,
                high: 2.0,
            }],
            strongest_evidence: Default::default(),
        }
    }

    #[test]
    fn an_interval_covers_its_ends_and_the_worst_effect_stands_first() {
        let rows = [
            row("guide_coulomb", 1.0, 1.0),
            row("guide_coulomb", 2.0, 1.0),
            row("guide_viscous", 2.1, 1.0),
            row("guide_viscous", f64::NAN, 1.0),
        ];
        let all = coverage(&rows);
        let of = |k: usize| {
            (
                all[k].effect.as_str(),
                all[k].cases,
                all[k].right,
                all[k].of,
            )
        };
        assert_eq!(of(0), ("guide_viscous", 2, 0, 2));
        assert_eq!(of(1), ("guide_coulomb", 2, 2, 2));
        assert_eq!(of(2), ("all", 4, 2, 4));
    }

    #[test]
    fn a_probability_falls_into_the_range_that_begins_with_it() {
        let rows = [
            row("guide_coulomb", 1.0, 0.8),
            row("guide_viscous", 1.0, 0.9),
            row("guide_coulomb", 1.0, 1.0),
        ];
        let found: Vec<(usize, usize)> =
            reliability(&rows).iter().map(|s| (s.right, s.of)).collect();
        assert_eq!(found, [(0, 0), (0, 0), (1, 2), (0, 0), (1, 1)]);
    }
}
