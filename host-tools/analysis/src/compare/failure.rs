//! Channels and axes in which the model fails, and the phases in which it does.

use super::Source;
use super::errors::AxisError;
use super::explain::{Explanation, explain};
use super::regime::Regime;
use super::{Phase, Window, window, windows};
use serde::Serialize;
use softdock_physics::model::{Axis, Channel};
use std::ops::Range;

/// Phases are named, the worst first, until together they hold this share of the error ...
const NAMED_SHARE: f64 = 0.8;
/// ... but no more than so many.
const MOST_NAMED: usize = 3;
/// Windows of named phases with gaps shorter than this are joined, s.
const JOINED_S: f64 = 0.02;

/// A phase's part of an error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PhaseShare {
    /// Phase.
    pub phase: Phase,
    /// Part of the error beyond the noise, 0 to 1.
    pub share: f64,
}

/// An axis of a channel in which the model fails.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// Channel.
    pub channel: Channel,
    /// Axis.
    pub axis: Axis,
    /// Part of what all channels have beyond the noise, 0 to 1.
    pub share: f64,
    /// Phases that hold most of the error, worst first.
    pub phases: Vec<PhaseShare>,
    /// Part of the recorded time that these phases take, 0 to 1.
    pub time_share: f64,
    /// The window of these phases with the largest error.
    pub worst: Window,
    /// Number of such windows.
    pub windows: usize,
    /// The regime that explains most of the error, if one does.
    pub regime: Option<Regime>,
    /// A one-parameter description of the error in these phases, if one fits.
    pub explanation: Option<Explanation>,
    /// The failure in words.
    pub sentence: String,
}

/// All failures, worst first, and behind all others those of a recorded motion that contradicts itself: no effect changes them.
///
/// `regimes` are sorted: on each axis the best comes first.
pub(super) fn find(source: &Source<'_>, errors: &[AxisError], regimes: &[Regime]) -> Vec<Failure> {
    let all: f64 = errors.iter().map(AxisError::excess).sum();
    let mut failing: Vec<&AxisError> = errors.iter().filter(|e| e.excess() > 0.0).collect();
    failing.sort_by(|a, b| {
        let of_motion = |e: &AxisError| source.is_within_motion(e.channel);
        let behind = of_motion(a).cmp(&of_motion(b));
        behind.then(b.excess().total_cmp(&a.excess()))
    });
    failing
        .into_iter()
        .map(|error| {
            let best = regimes
                .iter()
                .find(|r| r.channel == error.channel && r.axis == error.axis);
            let regime = best.filter(|r| r.explains()).cloned();
            failure(source, error, regime, all)
        })
        .collect()
}

fn failure(source: &Source<'_>, error: &AxisError, regime: Option<Regime>, all: f64) -> Failure {
    let (prediction, phases) = (source.prediction, source.phases);
    let named = named_phases(error);
    let is_named = |phase: Phase| named.iter().any(|n| n.phase == phase);
    let parts = joined(windows(prediction, phases, is_named), prediction.cycle_s);
    let channel = prediction.channel(error.channel);
    let squares = |cycles: &Range<usize>| -> f64 {
        let relative = |n| {
            let error_here = channel.residual(n, error.axis)?;
            Some((error_here / channel.expected_sigma(n, error.axis)).powi(2))
        };
        cycles.clone().filter_map(relative).sum()
    };
    let worst = parts
        .iter()
        .max_by(|a, b| squares(a).total_cmp(&squares(b)));
    let cycles: Vec<usize> = (0..phases.len()).filter(|n| is_named(phases[*n])).collect();
    Failure {
        channel: error.channel,
        axis: error.axis,
        share: error.excess() / all,
        time_share: cycles.len() as f64 / phases.len().max(1) as f64,
        worst: window(prediction, worst.unwrap_or(&(0..1))),
        windows: parts.len(),
        regime,
        explanation: explain(source, error.channel, error.axis, &cycles),
        phases: named,
        sentence: String::new(),
    }
}

fn named_phases(error: &AxisError) -> Vec<PhaseShare> {
    // An excess that is not significant within its phase still belongs to the error.
    let overall = error.overall();
    let all = error.excess().max(overall.squares - overall.count as f64);
    let mut shares = Phase::ALL.map(|phase| PhaseShare {
        phase,
        share: error.in_phase(phase).excess() / all,
    });
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    let mut named: Vec<PhaseShare> = Vec::new();
    for share in shares
        .into_iter()
        .filter(|s| s.share > 0.0)
        .take(MOST_NAMED)
    {
        let sum: f64 = named.iter().map(|n| n.share).sum();
        if sum < NAMED_SHARE {
            named.push(share);
        }
    }
    named
}

/// Joins windows across short gaps.
fn joined(windows: Vec<Range<usize>>, cycle_s: f64) -> Vec<Range<usize>> {
    let gap = (JOINED_S / cycle_s) as usize;
    let mut found: Vec<Range<usize>> = Vec::new();
    for window in windows {
        match found.last_mut() {
            Some(last) if window.start <= last.end + gap => last.end = window.end,
            _ => found.push(window),
        }
    }
    found
}
