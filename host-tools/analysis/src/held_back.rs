//! Parts of a recording: what is fitted, and the end that is held back as unseen data.

use softdock_app::record::CycleRecord;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::signals::Signals;
use std::ops::Range;

/// Share of a log that is held back where no unseen log is given.
const HELD_BACK: f64 = 0.4;

/// Splits a recording into its beginning, which is fitted, and its end, on which the fit is judged.
pub(crate) fn held_back(recording: &Recording) -> (Recording, Recording) {
    let count = recording.cycles.len();
    let at = count - (count as f64 * HELD_BACK) as usize;
    (part(recording, 0..at), part(recording, at..count))
}

/// [`held_back`] of each log. None if the end of any log excites too little of what its beginning does: then nothing is held
/// back.
pub(crate) fn all_held_back(logs: &[&Recording]) -> Option<Vec<(Recording, Recording)>> {
    let halves = logs.iter().map(|log| held_back(log));
    halves
        .map(|halves| moves_enough(&halves).then_some(halves))
        .collect()
}

/// Whether the end moves at least a tenth as much as the beginning.
fn moves_enough((beginning, end): &(Recording, Recording)) -> bool {
    /// Least motion of the end, as a share of that of the beginning.
    const ENOUGH: f64 = 0.1;
    let of = |commanded: bool| [beginning, end].map(|part| motion(&part.cycles, commanded));
    let is_enough = |[of_beginning, of_end]: [f64; 2]| of_end > ENOUGH * of_beginning;
    let travelled = (0..7).map(|k| travel([beginning, end].map(|part| &part.cycles[..]), k));
    let travelled = travelled.fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]]);
    match is_commanded(&beginning.cycles) {
        // A command may go on while the machine stands at the end of its travel: then the poses have to move as well.
        true => is_enough(of(true)) && (travelled[0] == 0.0 || is_enough(travelled)),
        false => is_enough(of(false)),
    }
}

/// Distance that component `k` of the pose travels in each of two parts. It is that of a follower with play, so that noise does
/// not add up.
fn travel(parts: [&[CycleRecord]; 2], k: usize) -> [f64; 2] {
    /// The play, as a share of the whole range. Set by hand.
    const PLAY: f64 = 0.05;
    let known = |part: &[CycleRecord]| -> Vec<f64> {
        let all = part.iter().map(|c| c.trace.pose[k]);
        all.filter(|v| v.is_finite()).collect()
    };
    let parts = parts.map(known);
    let all = parts.iter().flatten().copied();
    let (least, most) = (
        all.clone().fold(f64::INFINITY, f64::min),
        all.fold(f64::NEG_INFINITY, f64::max),
    );
    let play = 0.5 * PLAY * (most - least);
    parts.map(|part| {
        let (mut at, mut sum) = (part.first().copied().unwrap_or(0.0), 0.0);
        for value in part {
            let beyond = (f64::abs(value - at) - play).max(0.0);
            sum += beyond;
            at += beyond.copysign(value - at);
        }
        sum
    })
}

/// Whether any velocity was sent.
pub(crate) fn is_commanded(cycles: &[CycleRecord]) -> bool {
    let sent = |c: &CycleRecord| c.trace.sent_velocity.iter().any(|v| *v != 0.0);
    cycles.iter().any(sent)
}

/// Sum of absolute changes from cycle to cycle: of the commanded velocity, or, if not `commanded`, of the pose.
pub(crate) fn motion(cycles: &[CycleRecord], commanded: bool) -> f64 {
    let changes = cycles.windows(2).map(|pair| {
        let (a, b) = (&pair[0].trace, &pair[1].trace);
        let of = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
        if commanded {
            of(&a.sent_velocity, &b.sent_velocity)
        } else {
            of(&a.pose, &b.pose)
        }
    });
    changes.filter(|c| c.is_finite()).sum()
}

/// Whether a fitted and an unseen log are parts of one recording: an import has split one table, or the end of one log is held
/// back.
pub(crate) fn are_of_one_log(fitted: &[&Recording], unseen: &[&Recording]) -> bool {
    /// Longest gap between the two, as a share of the earlier one: rows that a filter distorts are left out there, which is much
    /// of a short log. Set by hand: trims of 20 ms leave an eighth of a log of 0.34 s.
    const BETWEEN: f64 = 0.25;
    let ([fitted], [unseen]) = (fitted, unseen) else {
        return false;
    };
    let times = |log: &Recording| {
        let (first, last) = (log.cycles.first()?, log.cycles.last()?);
        Some([first.trace.time_s, last.trace.time_s])
    };
    let (Some(of_fit), Some(of_unseen)) = (times(fitted), times(unseen)) else {
        return false;
    };
    let follows = |[start, end]: [f64; 2], [next, _]: [f64; 2]| {
        next > end && next - end < BETWEEN * (end - start)
    };
    let same = fitted.header.identity == unseen.header.identity;
    same && (follows(of_fit, of_unseen) || follows(of_unseen, of_fit))
}

/// Some rows of a recording. Its header keeps where the whole log begins.
pub(crate) fn part(recording: &Recording, range: Range<usize>) -> Recording {
    let mut header = recording.header.clone();
    // A recording without signals (too few rows) keeps its header as it is.
    if let Ok(whole) = Signals::new(recording) {
        header.whole_turns = whole.whole_turns_at(range.start);
        header.began = (range.start > 0).then_some(whole.began).or(header.began);
    }
    Recording {
        header,
        cycles: recording.cycles[range].to_vec(),
        cut: recording.cut.clone(),
        ..Recording::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_one_log_follow_each_other() {
        let cycle = |n: u32| {
            let mut cycle = CycleRecord::default();
            cycle.trace.time_s = 0.01 * f64::from(n);
            cycle
        };
        let log = Recording {
            cycles: (0..1000).map(cycle).collect(),
            ..Recording::default()
        };
        let (beginning, end) = held_back(&log);
        assert!(are_of_one_log(&[&beginning], &[&end]));
        assert!(are_of_one_log(&[&end], &[&beginning]));
        for trimmed in [30, 140] {
            let trimmed = part(&end, trimmed..400);
            assert!(are_of_one_log(&[&beginning], &[&trimmed]));
        }
        let mut of_another = end.clone();
        of_another.header.identity = "imported from another.csv".to_owned();
        for (fitted, unseen) in [
            (&[&log][..], &[&log][..]),
            (&[&beginning], &[&of_another]),
            (&[&beginning], &[&part(&end, 160..400)]),
            (&[&beginning, &log], &[&end]),
            (&[&beginning], &[]),
        ] {
            assert!(!are_of_one_log(fitted, unseen));
        }
    }

    /// A command that goes on while what it moves stands at the end of its travel.
    #[test]
    fn what_stands_while_it_is_commanded_is_not_held_back() {
        let stands_from = |row: u32| {
            let cycle = |n: u32| {
                let mut cycle = CycleRecord::default();
                cycle.trace.sent_velocity[0] = (0.1 * f64::from(n)).sin();
                let noise = 1e-2 * (1.7 * f64::from(n)).sin();
                cycle.trace.pose[0] = (0.1 * f64::from(n.min(row))).cos() + noise;
                cycle
            };
            let log = Recording {
                cycles: (0..1000).map(cycle).collect(),
                ..Recording::default()
            };
            all_held_back(&[&log]).is_none()
        };
        assert!(stands_from(590) && stands_from(615) && !stands_from(1000));
    }
}
