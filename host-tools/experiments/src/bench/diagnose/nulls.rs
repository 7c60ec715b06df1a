//! Evidence for any effect in logs with nothing hidden, and the limit that follows.

use super::Row;
use serde::Serialize;
use softdock_analysis::diagnose::{NAMED, StrongestEvidence};
use softdock_hidden_effects::score::quantile;
use softdock_hidden_effects::{NoiseRange, Verdict};
use std::collections::BTreeSet;

/// Accepted share of logs in which the limit lets an effect pass.
const RARE: f64 = 1e-3;
/// Quantile above which the tail is fitted: a fifth of the logs lie there.
const BODY: f64 = 0.8;

/// Evidence of one stage in logs with nothing hidden: quantiles, over the logs, of the largest evidence of each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageEvidence {
    /// Name of the stage; `any` for the largest evidence of all stages.
    pub stage: &'static str,
    /// Number of logs in which an effect gained enough to be examined closely.
    pub logs: usize,
    /// Median over all logs; None where no effect was examined closely.
    pub median: Option<f64>,
    /// 90 % quantile over all logs.
    pub of_90_percent: Option<f64>,
    /// 99 % quantile over all logs.
    pub of_99_percent: Option<f64>,
    /// Largest evidence of all logs.
    pub most: Option<f64>,
}

/// A generalised Pareto distribution of values above a threshold: P(excess > x) = (1 + shape x / scale)^(-1/shape).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tail {
    /// Threshold at which the tail begins.
    pub above: f64,
    /// Number of values in the tail.
    pub count: usize,
    /// Scale.
    pub scale: f64,
    /// Shape: 0 is an exponential tail, more a heavier one.
    pub shape: f64,
}

/// Answers about logs with nothing hidden, for one kind of noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alarms {
    /// Kind of noise.
    pub noise: NoiseRange,
    /// Number of logs.
    pub logs: usize,
    /// Logs in which an effect was named.
    pub false_names: usize,
    /// Number of logs with another verdict than "nothing is missing".
    pub other_verdicts: usize,
    /// The largest evidence of any effect.
    pub most: Option<f64>,
}

/// Result of logs with nothing hidden. The limit is that of logs whose velocities have white noise: under another noise the
/// evidence is no log-odds, and no limit helps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Nothing {
    /// Answers by kind of noise.
    pub alarms: Vec<Alarms>,
    /// Evidence by stage, where the noise of the velocity is white.
    pub stages: Vec<StageEvidence>,
    /// Distribution of the largest evidence of such a log.
    pub tail: Option<Tail>,
    /// Evidence that one log in 1,000 exceeds by that distribution.
    pub limit_of_1_in_1000: Option<f64>,
    /// Evidence from which an effect is named.
    pub limit_in_force: f64,
}

impl Nothing {
    /// Evaluates rows with nothing hidden.
    pub fn of(rows: &[Row]) -> Self {
        let white = rows.iter();
        let white = white.filter(|row| row.noise != NoiseRange::ColouredVelocity);
        let white: Vec<&Row> = white.collect();
        let stage = |stage, of: &dyn Fn(&StrongestEvidence) -> Option<f64>| {
            let values = white.iter().map(|row| of(&row.strongest_evidence));
            StageEvidence::of(stage, values.collect())
        };
        let most = white.iter().filter_map(|row| any(&row.strongest_evidence));
        let mut most: Vec<f64> = most.collect();
        most.sort_by(f64::total_cmp);
        let tail = Tail::of(&most, white.len());
        let noises: BTreeSet<NoiseRange> = rows.iter().map(|row| row.noise).collect();
        Self {
            alarms: noises.into_iter().map(|n| Alarms::of(n, rows)).collect(),
            stages: vec![
                stage("actuator", &|e| e.actuator),
                stage("wrench", &|e| e.wrench),
                stage("body", &|e| e.body),
                stage("any", &any),
            ],
            limit_of_1_in_1000: tail.map(|tail| tail.exceeded_by(RARE, white.len())),
            tail,
            limit_in_force: NAMED,
        }
    }
}

impl Alarms {
    fn of(noise: NoiseRange, rows: &[Row]) -> Self {
        let own = || rows.iter().filter(|row| row.noise == noise);
        let said = |verdict: Verdict| own().filter(|r| r.verdict == verdict).count();
        let (logs, false_names) = (own().count(), said(Verdict::Named));
        let most = own().filter_map(|row| any(&row.strongest_evidence));
        Self {
            noise,
            logs,
            false_names,
            other_verdicts: logs - false_names - said(Verdict::NothingMissing),
            most: most.max_by(f64::total_cmp),
        }
    }
}

/// The largest evidence of all stages.
fn any(evidence: &StrongestEvidence) -> Option<f64> {
    let each = [evidence.actuator, evidence.wrench, evidence.body];
    each.into_iter().flatten().max_by(f64::total_cmp)
}

impl StageEvidence {
    /// Quantiles of one stage. A log in which no effect was examined closely (None) counts as less than all others.
    fn of(stage: &'static str, values: Vec<Option<f64>>) -> Self {
        let below = |value: Option<f64>| value.unwrap_or(f64::NEG_INFINITY);
        let logs = values.iter().flatten().count();
        let mut sorted: Vec<f64> = values.into_iter().map(below).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share| quantile(&sorted, share).filter(|value| value.is_finite());
        Self {
            stage,
            logs,
            median: at(0.5),
            of_90_percent: at(0.9),
            of_99_percent: at(0.99),
            most: at(1.0),
        }
    }
}

impl Tail {
    /// Fewest values to which a distribution is fitted.
    const FEWEST: usize = 10;

    /// Fits the tail of ascending values of `logs` logs by probability-weighted moments (Hosking and Wallis 1987,
    /// Technometrics 29). A negative shape, which means an upper bound, is replaced by an exponential tail, as evidence has
    /// none. None if there are too few values.
    fn of(sorted: &[f64], logs: usize) -> Option<Self> {
        let count = ((1.0 - BODY) * logs as f64) as usize;
        let begin = sorted.len().checked_sub(count + 1)?;
        if count < Self::FEWEST {
            return None;
        }
        let above = sorted[begin];
        let excess: Vec<f64> = sorted[begin + 1..].iter().map(|v| v - above).collect();
        let n = count as f64;
        let mean = excess.iter().sum::<f64>() / n;
        let weight = |i: usize| 1.0 - (i as f64 + 0.65) / n;
        let weighted = excess.iter().enumerate().map(|(i, x)| weight(i) * x);
        let weighted = weighted.sum::<f64>() / n;
        let shape = 2.0 - mean / (mean - 2.0 * weighted);
        let scale = 2.0 * mean * weighted / (mean - 2.0 * weighted);
        let (scale, shape) = if shape > 0.0 {
            (scale, shape)
        } else {
            (mean, 0.0)
        };
        Some(Self {
            above,
            count,
            scale,
            shape,
        })
    }

    /// The value that this share of `logs` exceeds.
    fn exceeded_by(&self, share: f64, logs: usize) -> f64 {
        let part = self.count as f64 / (share * logs as f64);
        let multiple = if self.shape > 1e-6 {
            (part.powf(self.shape) - 1.0) / self.shape
        } else {
            part.ln()
        };
        self.above + self.scale * multiple
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of a distribution at equal distances of probability.
    fn values(of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..1000)
            .map(|i| of((f64::from(i) + 0.5) / 1000.0))
            .collect()
    }

    #[test]
    fn the_limit_of_a_known_tail_is_found() {
        let exponential = values(|p| -2.0 * (1.0 - p).ln());
        let tail = Tail::of(&exponential, 1000).unwrap();
        assert!(
            tail.shape < 0.05 && (tail.scale - 2.0).abs() < 0.1,
            "{tail:?}"
        );
        let limit = tail.exceeded_by(1e-3, 1000);
        assert!((limit / (2.0 * 1e3_f64.ln()) - 1.0).abs() < 0.03, "{limit}");
        let heavy = values(|p| ((1.0 - p).powf(-0.3) - 1.0) / 0.3);
        let tail = Tail::of(&heavy, 1000).unwrap();
        let limit = tail.exceeded_by(1e-3, 1000);
        let expected = (1e3_f64.powf(0.3) - 1.0) / 0.3;
        assert!((limit / expected - 1.0).abs() < 0.1, "{limit} {expected}");
        let bounded = Tail::of(&values(|p| p), 1000).unwrap();
        assert_eq!(bounded.shape, 0.0);
        assert_eq!(Tail::of(&[1.0; 9], 20), None);
    }

    #[test]
    fn a_log_in_which_nothing_was_looked_at_lies_below_the_others() {
        let stage = StageEvidence::of("wrench", vec![Some(4.0), None, None, Some(2.0), None]);
        assert_eq!((stage.logs, stage.median, stage.most), (2, None, Some(4.0)));
    }
}
