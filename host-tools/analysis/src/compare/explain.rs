//! A one-parameter description of an error, where one is supported: the measurement is late, or
//! larger by a factor, or shifted.
//!
//! It describes, and names no cause. It is only given if it accounts for most of what exceeds
//! the noise and the data determine its parameter.

use super::{Phase, Source};
use serde::Serialize;
use softdock_physics::model::prediction::{ChannelPrediction, executed};
use softdock_physics::model::{Axis, Channel};
use softdock_physics::optimise::lowest_valley;
use softdock_statistics::{DEVIATIONS_95, median};

/// Share of the error beyond the noise that a description has to account for.
const EXPLAINED: f64 = 0.8;
/// Range of the delays that are tried, s; negative where the measurement comes earlier.
const LATE_S: (f64, f64) = (-0.02, 0.2);
/// How closely the delay is found, in cycles.
const TOLERANCE: f64 = 1e-3;
/// Half width of the narrowest interval of a delay, in cycles.
const INSIDE_A_CYCLE: f64 = 0.05;

/// An estimated number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Best value.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// A description of an error by one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Explanation {
    /// The actuator fits best with this delay in addition to the model's, s.
    Late(Estimate),
    /// Measured = value × predicted, for the part beyond the level of free flight.
    Factor(Estimate),
    /// Measured = predicted + value, in the channel's unit.
    Offset(Estimate),
}

/// One cycle of the error that is to be described.
struct Sample {
    cycle: usize,
    error: f64,
    /// 1 / variance of the error.
    weight: f64,
}

/// The best description of the errors of an axis in the given cycles.
pub(super) fn explain(
    source: &Source<'_>,
    channel: Channel,
    axis: Axis,
    cycles: &[usize],
) -> Option<Explanation> {
    let values = source.prediction.channel(channel);
    let samples: Vec<Sample> = cycles
        .iter()
        .filter_map(|cycle| {
            let sigma = values.expected_sigma(*cycle, axis);
            Some(Sample {
                cycle: *cycle,
                error: values.residual(*cycle, axis)?,
                weight: 1.0 / (sigma * sigma),
            })
        })
        .collect();
    let load = loads(values, source.phases, axis);
    let ones: Vec<f64> = vec![1.0; samples.len()];
    let loaded: Vec<f64> = samples.iter().map(|s| load[s.cycle]).collect();
    let offset = linear(&samples, &ones).map(|(e, share)| (Explanation::Offset(e), share));
    let factor = linear(&samples, &loaded).map(|(e, share)| {
        let plus_one = Estimate {
            value: 1.0 + e.value,
            low: 1.0 + e.low,
            high: 1.0 + e.high,
        };
        (Explanation::Factor(plus_one), share)
    });
    let late = (channel == Channel::ExecutedVelocity)
        .then(|| delay_estimate(source, axis, &samples))
        .flatten()
        .map(|(e, share)| (Explanation::Late(e), share));
    [late, factor, offset]
        .into_iter()
        .flatten()
        .filter(|(_, share)| *share >= EXPLAINED)
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(explanation, _)| explanation)
}

/// The part of the prediction that a factor would scale: velocities, changes of the model's
/// velocity and of the pose, and the wrench beyond its median in free flight.
fn loads(values: &ChannelPrediction, phases: &[Phase], axis: Axis) -> Vec<f64> {
    let i = axis.index();
    let predicted = |n: usize| values.predicted[n].map(|p| p[i]);
    let rest = match values.channel {
        Channel::Wrench => {
            let free = (0..phases.len()).filter(|n| phases[*n] == Phase::FreeFlight);
            let mut values: Vec<f64> = free.filter_map(predicted).collect();
            median(&mut values).unwrap_or(0.0)
        }
        _ => 0.0,
    };
    (0..values.predicted.len())
        .map(|n| {
            let from = match values.channel {
                Channel::ModelVelocity | Channel::Pose => n
                    .checked_sub(1)
                    .map_or(0.0, |last| values.measured[last][i]),
                Channel::ExecutedVelocity | Channel::Wrench => rest,
            };
            predicted(n).map_or(0.0, |p| p - from)
        })
        .collect()
}

/// Weighted least squares of `error = value × regressor`: the estimate, and the share of the error that it explains. None if the
/// regressor is zero, or the estimate not clearly other than zero.
fn linear(samples: &[Sample], regressor: &[f64]) -> Option<(Estimate, f64)> {
    let pairs = || samples.iter().zip(regressor);
    let normal: f64 = pairs().map(|(s, x)| s.weight * x * x).sum();
    if normal <= 0.0 || !normal.is_finite() {
        return None;
    }
    let value = pairs().map(|(s, x)| s.weight * s.error * x).sum::<f64>() / normal;
    let left: Vec<f64> = pairs()
        .map(|(s, x)| (s.error - value * x) * s.weight.sqrt())
        .collect();
    determined(samples, &left, value, normal)
}

/// Finds the delay, in addition to the model's, with which the actuator fits best, and the share of the error that it explains.
fn delay_estimate(source: &Source<'_>, axis: Axis, samples: &[Sample]) -> Option<(Estimate, f64)> {
    let cycle_s = source.signals.cycle_s;
    let least = LATE_S.0.max(-source.model.actuator.transport_delay_s);
    let left = |late_s: f64| -> Vec<f64> {
        let mut model = source.model.clone();
        model.actuator.transport_delay_s += late_s.max(least);
        let values = executed::predict(&model, source.signals, &[]);
        let of = |s: &Sample| values.residual(s.cycle, axis).unwrap_or(s.error) * s.weight.sqrt();
        samples.iter().map(of).collect()
    };
    let cost = |late_s: f64| left(late_s).iter().map(|e| e * e).sum::<f64>();
    // The cost has one valley per reversal of the motion: look at all of them, then descend.
    let cells = ((LATE_S.1 - least) / cycle_s).ceil().max(1.0);
    let range = (least, least + cells * cycle_s);
    let (best, _) = lowest_valley(range, cells as u32, TOLERANCE, cost);
    let (before, after) = (left(best - 0.5 * cycle_s), left(best + 0.5 * cycle_s));
    let slope = |(a, b): (&f64, &f64)| ((b - a) / cycle_s).powi(2);
    let normal: f64 = before.iter().zip(&after).map(slope).sum();
    let (mut estimate, explained) = determined(samples, &left(best), best, normal)?;
    // The samples say little about what happens inside a cycle.
    let half = (estimate.high - best).max(INSIDE_A_CYCLE * cycle_s);
    (estimate.low, estimate.high) = (best - half, best + half);
    Some((estimate, explained))
}

/// The interval of an estimate from its residuals `left`, and the explained share; None unless zero is clearly outside of the
/// interval.
///
/// The standard error is `√(s² (1+ρ)/(1−ρ) / normal)` with the variance s² of the residuals (at least 1, the noise) and their
/// correlation ρ from sample to sample.
fn determined(
    samples: &[Sample],
    left: &[f64],
    value: f64,
    normal: f64,
) -> Option<(Estimate, f64)> {
    let n = left.len() as f64;
    let squares: f64 = left.iter().map(|e| e * e).sum();
    let neighbours: f64 = left.windows(2).map(|w| w[0] * w[1]).sum();
    let correlation = (neighbours / squares.max(f64::MIN_POSITIVE)).clamp(0.0, 0.98);
    let variance = (squares / n.max(1.0)).max(1.0);
    let inflation = (1.0 + correlation) / (1.0 - correlation);
    let half = DEVIATIONS_95 * (variance * inflation / normal.max(f64::MIN_POSITIVE)).sqrt();
    let before: f64 = samples.iter().map(|s| s.error * s.error * s.weight).sum();
    let explained = 1.0 - (squares - n).max(0.0) / (before - n).max(f64::MIN_POSITIVE);
    let estimate = Estimate {
        value,
        low: value - half,
        high: value + half,
    };
    (value.abs() > 2.0 * half).then_some((estimate, explained))
}
