//! Where an error shows: windows of time with what happens in them.

use crate::compare::Phase;
use crate::diagnose::finding::Region;
use crate::diagnose::stages::Stages;
use crate::diagnose::wrench::left::RemainingStructure;
use softdock_physics::model::Channel;
use softdock_physics::model::prediction::Prediction;

/// Where structure is left on the log that is drawn.
pub(crate) fn left_over(left: &[RemainingStructure], stages: &Stages) -> Vec<Region> {
    let log = stages.logs.shown();
    let shown = stages.logs.shown_number();
    let at = |n: usize| log.time_s[n.min(log.cycle_count() - 1)];
    left.iter()
        .filter(|l| l.any())
        .flat_map(RemainingStructure::structured)
        .filter_map(|(channel, axis, each)| {
            let shown = each.get(shown)?;
            let ((from, length), regime) = shown.strongest();
            Some(Region {
                channel: *channel,
                axis: *axis,
                from_s: at(from),
                to_s: at(from + length),
                regime,
            })
        })
        .collect()
}

/// Windows in which the named effects reduce the error most, on the log that is drawn; at most six.
pub(crate) fn explained(before: &Prediction, after: &Prediction, stages: &Stages) -> Vec<Region> {
    /// Length of a window, s.
    const WINDOW_S: f64 = 0.25;
    let length = ((WINDOW_S / before.cycle_s) as usize).max(4);
    let mut all: Vec<(f64, Region)> = Vec::new();
    for channel in Channel::ALL {
        let (b, a) = (before.channel(channel), after.channel(channel));
        for axis in before.judged(channel).iter().copied() {
            let sigma = b.expected_sigma(0, axis);
            let gain = |n: usize| {
                let square = |r: Option<f64>| (r.unwrap_or(0.0) / sigma).powi(2);
                square(b.residual(n, axis)) - square(a.residual(n, axis))
            };
            let gains: Vec<f64> = (0..before.time_s.len()).map(gain).collect();
            let best = gains
                .chunks(length)
                .enumerate()
                .map(|(k, chunk)| (k * length, chunk.iter().sum::<f64>()))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((from, sum)) = best.filter(|b| b.1 > 10.0 * length as f64 / 4.0) else {
                continue;
            };
            let to = (from + length).min(before.time_s.len() - 1);
            all.push((
                sum,
                Region {
                    channel,
                    axis,
                    from_s: before.time_s[from],
                    to_s: before.time_s[to],
                    regime: regime(stages, from, to),
                },
            ));
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().take(6).map(|r| r.1).collect()
}

/// What happens in a window, in words.
fn regime(stages: &Stages, from: usize, to: usize) -> String {
    let phase = stages
        .phases
        .get(from..=to.min(stages.phases.len().saturating_sub(1)));
    let Some(phases) = phase else {
        return String::new();
    };
    let count = |p: Phase| phases.iter().filter(|q| **q == p).count();
    Phase::ALL
        .into_iter()
        .max_by_key(|p| count(*p))
        .map_or_else(String::new, Phase::words)
}
