//! Where to look: the axis with the largest error, and the time around its worst moment.

use super::Source;
use softdock_analysis::diagnose::{Region, Verdict};
use softdock_physics::model::prediction::Prediction;
use softdock_physics::model::{Axis, Channel};
use std::ops::Range;

/// Time shown before and after a failing window, s.
const MARGIN_S: f64 = 0.15;
/// Longest close-up, s.
const LONGEST_S: f64 = 2.0;
/// Shortest close-up, s.
const SHORTEST_S: f64 = 0.6;
/// If a close-up would show more than this share of the recording, it is left out.
const NOTHING_NEW: f64 = 0.7;

/// An axis of a channel to draw.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Focus {
    pub(super) channel: Channel,
    pub(super) axis: Axis,
    /// Whether the axis is shown for the error that remains with the named effects.
    pub(super) is_rest: bool,
    /// Cycles around the worst moment; None if these were most of the recording.
    pub(super) close_up: Option<Range<usize>>,
}

impl Focus {
    /// The axis with the largest error. If the verdict is `unexplained`, also the axis with the largest remaining error,
    /// where it is another one.
    pub(super) fn of(source: &Source<'_>) -> Vec<Self> {
        let largest = worst_signal(source.before);
        let left = match source.diagnosis.verdict {
            Verdict::Unexplained => {
                worst_signal(source.best()).filter(|rest| Some(*rest) != largest)
            }
            _ => None,
        };
        let focus = |(channel, axis), is_rest, prediction| Self {
            channel,
            axis,
            is_rest,
            close_up: close_up(prediction, &source.diagnosis.regions, channel, axis),
        };
        let largest = largest.map(|signal| focus(signal, false, source.before));
        let left = left.map(|signal| focus(signal, true, source.best()));
        largest.into_iter().chain(left).collect()
    }
}

/// Error of a cycle in units of its expected noise; None where nothing is predicted.
pub(super) fn relative(
    prediction: &Prediction,
    channel: Channel,
    axis: Axis,
    n: usize,
) -> Option<f64> {
    let values = prediction.channel(channel);
    let relative = values.residual(n, axis)? / values.expected_sigma(n, axis);
    relative.is_finite().then_some(relative)
}

/// Root mean square of the relative error over some cycles; None if nothing is predicted there.
pub(super) fn rms(
    prediction: &Prediction,
    channel: Channel,
    axis: Axis,
    cycles: Range<usize>,
) -> Option<f64> {
    let errors = cycles.filter_map(|n| relative(prediction, channel, axis, n));
    let (sum, count) = errors.fold((0.0, 0usize), |(sum, count), e| (sum + e * e, count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// Cycles of a time window, both ends included.
pub(super) fn cycles(prediction: &Prediction, from_s: f64, to_s: f64) -> Range<usize> {
    let time = &prediction.time_s;
    let from = time.partition_point(|t| *t < from_s);
    from..time.partition_point(|t| *t <= to_s).max(from)
}

fn worst_signal(prediction: &Prediction) -> Option<(Channel, Axis)> {
    let all = 0..prediction.time_s.len();
    let signals = Channel::ALL.into_iter().flat_map(|channel| {
        let axes = prediction.judged(channel).iter();
        axes.map(move |axis| (channel, *axis))
    });
    let known = signals.filter_map(|(channel, axis)| {
        Some((
            (channel, axis),
            rms(prediction, channel, axis, all.clone())?,
        ))
    });
    known
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(signal, _)| signal)
}

/// Cycles of the failing window that holds most of the error, with a margin. Without such a window, those around the largest
/// error.
fn close_up(
    prediction: &Prediction,
    regions: &[Region],
    channel: Channel,
    axis: Axis,
) -> Option<Range<usize>> {
    let all = 0..prediction.time_s.len();
    let square = |n: usize| relative(prediction, channel, axis, n).map_or(0.0, |e| e * e);
    let windows = regions
        .iter()
        .filter(|region| region.channel == channel && region.axis == axis)
        .map(|region| cycles(prediction, region.from_s, region.to_s));
    let worst = windows
        .map(|window| (window.clone().map(square).sum::<f64>(), window))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(all.clone(), |(_, window)| window);
    let peak = worst
        .clone()
        .max_by(|a, b| square(*a).total_cmp(&square(*b)))?;
    let time = |n: usize| prediction.time_s.get(n).copied();
    let (first, last, peak) = (
        time(worst.start)?,
        time(worst.end.checked_sub(1)?)?,
        time(peak)?,
    );
    let (from, to) = if last - first + 2.0 * MARGIN_S > LONGEST_S {
        (peak - LONGEST_S / 2.0, peak + LONGEST_S / 2.0)
    } else {
        let middle = (first + last) / 2.0;
        let half = ((last - first) / 2.0 + MARGIN_S).max(SHORTEST_S / 2.0);
        (middle - half, middle + half)
    };
    let shown = cycles(prediction, from, to);
    let part = shown.len() as f64 / all.len() as f64;
    (part <= NOTHING_NEW).then_some(shown)
}
