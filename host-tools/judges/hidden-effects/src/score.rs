//! Scores of a tool's answers, as defined by the log format.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::truth::{Channels, Level, Truth, Verdict};

/// A tool's answer to one case.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Answer {
    /// Verdict.
    pub verdict: Verdict,
    /// Ids, best first; for a pair the first two count.
    #[serde(default)]
    pub effects: Vec<String>,
    /// z of [A, B, C, K] on the test log with the named effects, fitted on the training log.
    #[serde(default = "unknown", deserialize_with = "by_channel")]
    pub test_rms: [f64; 4],
    /// Time of the diagnosis, s.
    #[serde(default)]
    pub seconds: f64,
}

fn unknown() -> [f64; 4] {
    [f64::NAN; 4]
}

fn by_channel<'de, D: serde::Deserializer<'de>>(from: D) -> Result<[f64; 4], D::Error> {
    Channels::deserialize(from).map(Into::into)
}

/// Reads an answer file: an object with one [`Answer`] per case.
///
/// # Errors
/// The position in the text, and what was expected there.
pub fn parse_answers(text: &str) -> Result<BTreeMap<String, Answer>, serde_json::Error> {
    serde_json::from_str(text)
}

/// Successes out of tries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rate {
    /// Successes.
    pub right: usize,
    /// Cases that count.
    pub of: usize,
}

impl Rate {
    fn count(&mut self, right: bool) {
        self.of += 1;
        self.right += usize::from(right);
    }
}

/// All scores of one set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scores {
    /// One effect: named, and the first id is right.
    pub single_top1: Rate,
    /// One effect: named, and the id is among the first three.
    pub single_top3: Rate,
    /// Two effects: named, and the first two ids are the pair in any order.
    pub compound_exact: Rate,
    /// Two effects: named, and one of the first two ids is right.
    pub compound_any: Rate,
    /// Three effects: named, and the first three ids are these in any order.
    pub triple_exact: Rate,
    /// One effect far below the noise: named, and the first id is right.
    pub small_top1: Rate,
    /// An effect in one log only, and the logs were said to disagree.
    pub logs_disagree: Rate,
    /// Nothing hidden, and the verdict says so.
    pub null_clean: Rate,
    /// An effect outside the catalogue, and the verdict says so.
    pub outside_unexplained: Rate,
    /// Right verdict, and if named the set of ids is exactly the truth.
    pub rank_all_correct: Rate,
    /// Percentage of the removable error that is removed on the test log, one per case, ascending.
    pub error_drop_percent: Vec<f64>,
    /// Durations of the diagnoses, ascending, s.
    pub seconds: Vec<f64>,
}

impl Scores {
    /// Adds one case. A case without an answer is scored with `None`: wrong everywhere.
    pub fn add(&mut self, truth: &Truth, answer: Option<&Answer>) {
        let named = answer.is_some_and(|a| a.verdict == Verdict::Named);
        let said = |verdict| answer.is_some_and(|a| a.verdict == verdict);
        let ranked = answer.map_or(&[][..], |a| &a.effects[..]);
        let first = |n: usize| &ranked[..ranked.len().min(n)];
        let hits = |n: usize| {
            let found = truth.effects.iter().filter(|id| first(n).contains(id));
            found.count()
        };
        match truth.level {
            Level::Single | Level::SingleWithinTolerance => {
                self.single_top1.count(named && hits(1) == 1);
                self.single_top3.count(named && hits(3) == 1);
            }
            Level::Compound => {
                self.compound_exact.count(named && hits(2) == 2);
                self.compound_any.count(named && hits(2) > 0);
            }
            Level::Triple => self.triple_exact.count(named && hits(3) == 3),
            Level::Small => self.small_top1.count(named && hits(1) == 1),
            Level::OneLog => self.logs_disagree.count(said(Verdict::LogsDisagree)),
            Level::Null | Level::NullWithinTolerance => {
                self.null_clean.count(said(Verdict::NothingMissing));
            }
            Level::Outside => self.outside_unexplained.count(said(Verdict::Unexplained)),
        }
        let same_set =
            hits(ranked.len()) == truth.effects.len() && ranked.len() == truth.effects.len();
        self.rank_all_correct
            .count(said(truth.expected) && (truth.expected != Verdict::Named || same_set));
        if let Some(answer) = answer {
            if let Some(drop) = error_drop_percent(truth, answer) {
                insert(&mut self.error_drop_percent, drop);
            }
            insert(&mut self.seconds, answer.seconds);
        }
    }

    /// Median of the drops, %.
    #[must_use]
    pub fn median_drop_percent(&self) -> Option<f64> {
        quantile(&self.error_drop_percent, 0.5)
    }

    /// Smallest drop, %.
    #[must_use]
    pub fn min_drop_percent(&self) -> Option<f64> {
        self.error_drop_percent.first().copied()
    }

    /// Number of cases in which at least 90 % of the removable error is removed.
    #[must_use]
    pub fn drop_of_90_percent(&self) -> Rate {
        let good = self.error_drop_percent.iter().filter(|d| **d >= 90.0);
        Rate {
            right: good.count(),
            of: self.error_drop_percent.len(),
        }
    }

    /// Time within which this share of the diagnoses is done, s.
    #[must_use]
    pub fn seconds_of(&self, share: f64) -> Option<f64> {
        quantile(&self.seconds, share)
    }
}

/// Scores a set; cases without an answer count as wrong, answers without a case are ignored.
#[must_use]
pub fn score(truths: &BTreeMap<String, Truth>, answers: &BTreeMap<String, Answer>) -> Scores {
    let mut scores = Scores::default();
    for (name, truth) in truths {
        scores.add(truth, answers.get(name));
    }
    scores
}

/// `100 (E(nominal) - E(answer)) / (E(nominal) - E(oracle))`, `E = sqrt(sum of z²)`. None unless the effect was named, should
/// be named, and can be seen (denominator > 0.02). An answer without residuals counts as 0.
#[must_use]
pub fn error_drop_percent(truth: &Truth, answer: &Answer) -> Option<f64> {
    let error = |z: &[f64; 4]| z.iter().map(|v| v * v).sum::<f64>().sqrt();
    let nominal = error(&truth.z_nominal_test);
    let removable = nominal - error(&truth.z_oracle_test);
    let counts = truth.expected == Verdict::Named && answer.verdict == Verdict::Named;
    if !counts || removable <= 0.02 {
        return None;
    }
    let left = error(&answer.test_rms);
    let drop = 100.0 * (nominal - left) / removable;
    Some(if drop.is_finite() { drop } else { 0.0 })
}

/// Inserts a value into an ascending list.
fn insert(sorted: &mut Vec<f64>, value: f64) {
    let at = sorted.partition_point(|v| v.total_cmp(&value).is_lt());
    sorted.insert(at, value);
}

/// Quantile of ascending values, with linear interpolation; None without values.
#[must_use]
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let (lower, upper) = (
        sorted[place.floor() as usize],
        sorted[place.ceil() as usize],
    );
    Some(lower + place.fract() * (upper - lower))
}
