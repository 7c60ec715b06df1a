//! How much of an error each quantity accounts for.

use super::candidates::Candidate;
use super::{Bin, Dependence, Interval, Quantity, Regime, beside_offset, frequency};
use crate::compare::Source;
use crate::compare::series::Series;
use softdock_statistics::Fit;
use std::ops::Range;

/// If the mean along a quantity explains this share of the error, it is preferred to an interval in which the error is large.
const MEAN_FIRST: f64 = 0.4;
/// Share of an error that the bins of an interval have to hold.
const HELD: f64 = 0.8;

/// Scores that differ by less are about the same.
const AS_GOOD: f64 = 0.15;

/// What a candidate says about an error.
struct Judged<'a> {
    candidate: &'a Candidate,
    fit: Fit,
    /// Share of the error that a constant explains.
    offset: f64,
    /// Share of the error that the means explain beyond that.
    mean: f64,
    /// Bins that hold most of the error.
    concentration: Concentration,
}

/// Neighbouring bins, their share of the error, and of the time.
#[derive(Clone, Debug, Default, PartialEq)]
struct Concentration {
    bins: Range<usize>,
    share: f64,
    time_share: f64,
}

impl Concentration {
    /// Share of the error minus share of the cycles.
    fn gain(&self) -> f64 {
        self.share - self.time_share
    }
}

impl Judged<'_> {
    fn by_mean(&self) -> bool {
        let mean = beside_offset(self.mean, self.offset);
        let same_everywhere = self.offset > MEAN_FIRST;
        !self.candidate.absolute
            && (same_everywhere || mean >= MEAN_FIRST || mean >= self.concentration.gain())
    }

    /// Explained share, less a handicap: simpler quantities, and those of the same axis, are preferred.
    fn score(&self, series: &Series) -> f64 {
        let candidate = self.candidate;
        let share = if self.by_mean() {
            beside_offset(self.mean, self.offset)
        } else if self.offset > MEAN_FIRST {
            0.0
        } else {
            self.concentration.gain()
        };
        let elsewhere = if candidate.along.is_none_or(|along| along == series.axis) {
            0.0
        } else {
            0.08
        };
        let gated = if candidate.in_contact { 0.03 } else { 0.0 };
        let proxy = match candidate.quantity {
            // What happens in a contact happens at the same time after its beginning, too.
            Quantity::TimeSinceContact => 0.08,
            Quantity::TimeInRun => 0.05,
            Quantity::Acceleration | Quantity::Force => 0.02,
            _ => 0.0,
        };
        share - elsewhere - gated - proxy
    }
}

/// The best of each kind of quantity, best first.
pub(super) fn ranked(
    source: &Source<'_>,
    candidates: &[Candidate],
    series: &Series,
    level: f64,
) -> Vec<Regime> {
    let (squares, count) = series.squares();
    let excess = squares - count as f64;
    if excess <= 0.0 || !series.is_there() {
        return Vec::new();
    }
    let mut best: Vec<(f64, Judged<'_>)> = Vec::new();
    for candidate in candidates {
        let judged = judge(candidate, series, excess);
        let score = judged.score(series);
        let same = best
            .iter_mut()
            .find(|(_, b)| b.candidate.quantity == candidate.quantity);
        match same {
            Some(known) if score > known.0 => *known = (score, judged),
            Some(_) => {}
            None => best.push((score, judged)),
        }
    }
    let mut regimes: Vec<(f64, Regime)> = best
        .iter()
        .map(|(score, judged)| (*score, regime(source, judged, series, excess, level)))
        .collect();
    regimes.extend(frequency::of(source, series, excess, level));
    regimes.sort_by(|a, b| b.0.total_cmp(&a.0));
    surest_first(&mut regimes);
    regimes.into_iter().map(|(_, regime)| regime).collect()
}

/// Among regimes about as good as the best, puts one first that is significant. Among intervals, that with the smallest p comes
/// first, as a short event shows as an interval of every quantity.
fn surest_first(regimes: &mut [(f64, Regime)]) {
    let Some(best) = regimes.first().map(|(score, _)| *score) else {
        return;
    };
    let near = regimes.partition_point(|(score, _)| *score >= best - AS_GOOD);
    let near = &mut regimes[..near];
    let place = |r: &Regime| r.dependence == Dependence::Size;
    let surest = if near.first().is_some_and(|(_, r)| place(r)) {
        let places = near.iter().enumerate().filter(|(_, (_, r))| place(r));
        places.min_by(|(_, (_, a)), (_, (_, b))| a.p.total_cmp(&b.p))
    } else {
        let mut means = near.iter().enumerate();
        means.find(|(_, (score, r))| r.significant && *score >= best - AS_GOOD / 3.0)
    };
    if let Some(index) = surest.map(|(index, _)| index) {
        near[..=index].rotate_right(1);
    }
}

fn judge<'a>(candidate: &'a Candidate, series: &Series, excess: f64) -> Judged<'a> {
    let fit = candidate.groups.fit(&series.relative);
    let shares = shares(candidate, &series.relative, excess);
    Judged {
        candidate,
        offset: (fit.explained_by_mean() / excess).min(1.0),
        mean: (fit.explained_squares() / excess).min(1.0),
        fit,
        concentration: narrowest(&shares, series.relative.len()),
    }
}

/// Share of the error beyond the noise and number of cycles in each bin.
fn shares(candidate: &Candidate, relative: &[f64], excess: f64) -> Vec<(f64, usize)> {
    let squares: Vec<f64> = relative.iter().map(|v| v * v).collect();
    let bins = candidate.groups.means(&squares).into_iter();
    bins.take(candidate.groups.len())
        .map(|(mean, count)| (((mean - 1.0) * count as f64 / excess).max(0.0), count))
        .collect()
}

/// The neighbouring bins that hold most of the error and have most error for their number of cycles.
fn narrowest(shares: &[(f64, usize)], cycles: usize) -> Concentration {
    let mut best = Concentration::default();
    for from in 0..shares.len() {
        let (mut share, mut count) = (0.0, 0);
        for (i, (of_bin, cycles_of_bin)) in shares.iter().enumerate().skip(from) {
            share += of_bin;
            count += cycles_of_bin;
            let concentration = Concentration {
                bins: from..i + 1,
                share: share.min(1.0),
                time_share: count as f64 / cycles.max(1) as f64,
            };
            if share >= HELD {
                if concentration.gain() > best.gain() {
                    best = concentration;
                }
                break;
            }
        }
    }
    best
}

fn regime(
    source: &Source<'_>,
    judged: &Judged<'_>,
    series: &Series,
    excess: f64,
    level: f64,
) -> Regime {
    let candidate = judged.candidate;
    let groups = &candidate.groups;
    let (dependence, share, p) = if judged.by_mean() {
        (Dependence::Mean, judged.mean, judged.fit.p())
    } else {
        let size: Vec<f64> = series.relative.iter().map(|v| v.abs()).collect();
        (
            Dependence::Size,
            judged.concentration.share,
            groups.fit(&size).p(),
        )
    };
    Regime {
        channel: series.channel,
        axis: series.axis,
        variable: candidate.quantity,
        along: candidate.along,
        unit: candidate.unit,
        in_contact: candidate.in_contact,
        absolute: candidate.absolute,
        dependence,
        share,
        offset_share: judged.offset,
        offset: mean_error(source, series),
        at: (dependence == Dependence::Size).then(|| Interval {
            from: groups.edges[judged.concentration.bins.start],
            to: groups.edges[judged.concentration.bins.end],
            time_share: judged.concentration.time_share,
        }),
        p,
        significant: p < level,
        bins: bins(source, candidate, series, excess),
    }
}

/// Mean error in the channel's unit.
fn mean_error(source: &Source<'_>, series: &Series) -> f64 {
    let values = source.prediction.channel(series.channel);
    let errors = (0..series.relative.len()).filter_map(|n| values.residual(n, series.axis));
    let (sum, count) = errors.fold((0.0, 0), |(sum, count), e| (sum + e, count + 1));
    sum / f64::from(count.max(1))
}

fn bins(source: &Source<'_>, candidate: &Candidate, series: &Series, excess: f64) -> Vec<Bin> {
    let groups = &candidate.groups;
    let values = source.prediction.channel(series.channel);
    let errors: Vec<f64> = (0..series.relative.len())
        .map(|n| values.residual(n, series.axis).unwrap_or(f64::NAN))
        .collect();
    let squares = |values: &[f64]| -> Vec<f64> { values.iter().map(|v| v * v).collect() };
    let means = groups.means(&errors);
    let powers = groups.means(&squares(&errors));
    let relative = groups.means(&squares(&series.relative));
    let shares = shares(candidate, &series.relative, excess);
    (0..groups.len())
        .map(|i| Bin {
            from: groups.edges[i],
            to: groups.edges[i + 1],
            centre: groups.centres()[i],
            cycles: means[i].1,
            mean: means[i].0,
            spread: (powers[i].0 - means[i].0.powi(2)).max(0.0).sqrt(),
            rms_sigma: relative[i].0.sqrt(),
            share: shares[i].0,
        })
        .collect()
}
