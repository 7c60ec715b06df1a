//! Selects the part of its logs that a diagnosis uses.

use super::logs::Logs;
use crate::held_back::{is_commanded, motion, part};
use softdock_io::recording::Recording;
use softdock_physics::model::Model;
use softdock_physics::model::log::stretches;
use softdock_physics::model::prediction::signals::Signals;
use std::ops::Range;

/// Most rows of all logs together; short logs stay whole. Time and memory grow with them: two logs of 50,000 rows take about 45 s
/// of processor time. Four times as many rows make intervals half as wide.
const MOST_ROWS: usize = 100_000;
/// Stretches of a long log among which the one that moves most is chosen.
const STRETCHES: usize = 8;

/// The stretch of each log that moves most; `None` if all logs together have no more than [`MOST_ROWS`].
pub(super) fn of_long(logs: &Logs<&Recording>) -> Option<Logs<Recording>> {
    let longest = longest(&logs.all)?;
    Some(logs.map(|log| part(log, liveliest(log, longest))))
}

/// The number of rows up to which a log stays whole, so that all together have no more than [`MOST_ROWS`]; `None` if they have no
/// more anyway.
fn longest(logs: &[&Recording]) -> Option<usize> {
    let mut counts: Vec<usize> = logs.iter().map(|log| log.cycles.len()).collect();
    counts.sort_unstable();
    let mut left = MOST_ROWS;
    for (place, count) in counts.iter().enumerate() {
        let share = left / (counts.len() - place);
        if *count > share {
            return Some(share);
        }
        left -= count;
    }
    None
}

/// Logs that are cut at their gaps: the longest stretches between gaps, in their order, each as a log of its own. `None` where
/// one stretch is nearly all of each log, where each row is a measurement of its own, and where a gap separates more than
/// stretches: a rig begins a new run, and a docking mechanism keeps what it has caught.
pub(super) fn between_gaps(model: &Model, logs: &Logs<&Recording>) -> Option<Logs<Recording>> {
    let cut: Vec<Option<Vec<Range<usize>>>> = logs.all.iter().map(|log| cut(log)).collect();
    let of_a_rig = |log: &&Recording| !log.header.settings_toml.trim().is_empty();
    let is_whole = model.sensor.at_rest || !model.contact.docking.is_empty();
    if is_whole || cut.iter().all(Option::is_none) || logs.all.iter().any(of_a_rig) {
        return None;
    }
    let each = logs.all.iter().zip(cut);
    let mut each = each.map(|(log, stretches)| {
        let ranges = stretches.unwrap_or_else(|| std::iter::once(0..log.cycles.len()).collect());
        let parts = ranges.into_iter().map(|range| part(log, range));
        parts.collect::<Vec<Recording>>()
    });
    let fitted = each.by_ref().take(logs.fitted).flatten().collect();
    Some(Logs::new(fitted, each.flatten().collect()))
}

/// The stretches of a log that are used; `None` if the longest is nearly all of it.
fn cut(log: &Recording) -> Option<Vec<Range<usize>>> {
    /// If the longest stretch has this share of the rows, the log is not cut. Set by hand, as are the following.
    const WHOLE: f64 = 0.8;
    /// Most stretches of a log, as time grows with their number.
    const MOST: usize = 8;
    /// Shortest one as a share of the longest.
    const SHORTEST: f64 = 0.25;
    let mut all = stretches(&Signals::new(log).ok()?);
    // A stretch in which nothing is sent says nothing about a drive.
    let commanded = is_commanded(&log.cycles);
    all.retain(|stretch| !commanded || is_commanded(&log.cycles[stretch.clone()]));
    all.sort_by_key(|stretch| std::cmp::Reverse(stretch.len()));
    let longest = all.first()?.len() as f64;
    all.truncate(MOST);
    all.retain(|stretch| stretch.len() as f64 >= SHORTEST * longest);
    all.sort_by_key(|stretch| stretch.start);
    (longest < WHOLE * log.cycles.len() as f64).then_some(all)
}

/// The note about logs that are cut at gaps.
pub(super) fn note_of_gaps(whole: &Logs<&Recording>, looked_at: &Logs<&Recording>) -> String {
    let [all, used] = [whole, looked_at].map(|logs| rows(&logs.all));
    let rest = match used < all {
        true => {
            ", the longest ones, of a drive those with commands (`gaps = \"bridge\"` in [time] of a mapping fills short gaps)"
        }
        false => "",
    };
    format!(
        "Gaps cut the logs: of {all} rows {used} were looked at, in {} stretches{rest}, each as a log of its own; whether they are of one \
         machine is not asked.",
        looked_at.all.len()
    )
}

/// The note about logs of which stretches are used.
pub(super) fn note(whole: &Logs<&Recording>, looked_at: &Logs<&Recording>) -> String {
    format!(
        "Of {} rows {} were looked at, in each log the stretch that moves most; errors are those of these rows. \
         [rows] of the mapping chooses others.",
        rows(&whole.all),
        rows(&looked_at.all)
    )
}

fn rows(logs: &[&Recording]) -> usize {
    logs.iter().map(|log| log.cycles.len()).sum()
}

/// The rows of a log, at most `longest`, that move most.
fn liveliest(log: &Recording, longest: usize) -> Range<usize> {
    let count = log.cycles.len();
    let length = longest.min(count);
    let commanded = is_commanded(&log.cycles);
    let starts = (0..STRETCHES).map(|k| k * (count - length) / (STRETCHES - 1));
    let each = starts.map(|from| from..from + length);
    let of = |range: &Range<usize>| motion(&log.cycles[range.clone()], commanded);
    each.max_by(|a, b| of(a).total_cmp(&of(b)))
        .unwrap_or(0..count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use softdock_app::record::CycleRecord;

    /// A log that rests for three quarters and then moves.
    fn log(rows: usize) -> Recording {
        let cycle = |n: usize| {
            let mut cycle = CycleRecord::default();
            cycle.trace.cycle = n as u64;
            cycle.trace.pose[0] = n.saturating_sub(3 * rows / 4) as f64;
            cycle
        };
        Recording {
            cycles: (0..rows).map(cycle).collect(),
            ..Recording::default()
        }
    }

    #[test]
    fn a_long_log_is_looked_at_where_it_moves() {
        let (train, test) = (log(MOST_ROWS), log(MOST_ROWS));
        let whole = Logs::new(vec![&train], vec![&test]);
        let found = of_long(&whole).expect("too many rows");
        for part in &found.all {
            assert_eq!(part.cycles.len(), MOST_ROWS / 2);
            let last = part.cycles.last().map(|c| c.trace.cycle);
            assert_eq!(last, Some(MOST_ROWS as u64 - 1));
        }
        let said = note(&whole, &found.map_refs());
        assert!(
            said.contains("Of 200000 rows 100000 were looked at"),
            "{said}"
        );
        let (long, short) = (log(2 * MOST_ROWS), log(3_000));
        let found = of_long(&Logs::new(vec![&long], vec![&short])).expect("too many rows");
        let counts = found.all.iter().map(|part| part.cycles.len());
        assert_eq!(counts.collect::<Vec<_>>(), [MOST_ROWS - 3_000, 3_000]);
        let short = Logs::new(vec![&train], Vec::new());
        assert!(of_long(&short).is_none());
    }

    /// A log whose rows have these numbers.
    fn numbered(numbers: impl Iterator<Item = u64>, sent: impl Fn(u64) -> f64) -> Recording {
        let cycle = |n: u64| {
            let mut cycle = CycleRecord::default();
            (cycle.trace.cycle, cycle.trace.time_s) = (n, 0.01 * n as f64);
            (cycle.trace.pose[0], cycle.trace.pose[3]) = (n as f64, 1.0);
            cycle.trace.sent_velocity[0] = sent(n);
            cycle
        };
        Recording {
            cycles: numbers.map(cycle).collect(),
            ..Recording::default()
        }
    }

    /// Of three stretches the two long ones are used, in their order, and for a drive only the one in which anything is sent; a
    /// log without gaps stays whole.
    #[test]
    fn stretches_between_gaps_are_logs_of_their_own() {
        let model = Model::from_toml("", "model.toml").expect("all has defaults");
        let rows = || (0..100).chain(150..300).chain(310..320);
        let (train, test) = (numbered(rows(), |_| 0.0), numbered(0..80, |_| 0.0));
        let found = between_gaps(&model, &Logs::new(vec![&train], vec![&test]));
        let found = found.expect("gaps");
        let first = |part: &Recording| part.cycles[0].trace.cycle;
        let lengths: Vec<(u64, usize)> = found
            .all
            .iter()
            .map(|part| (first(part), part.cycles.len()))
            .collect();
        assert_eq!(lengths, [(0, 100), (150, 150), (0, 80)]);
        assert_eq!(found.fitted, 2);
        let driven = numbered(rows(), |n| if n < 100 { 1.0 } else { 0.0 });
        let found = between_gaps(&model, &Logs::new(vec![&driven], Vec::new()));
        let found = found.expect("gaps");
        assert_eq!(found.all.iter().map(first).collect::<Vec<_>>(), [0]);
        assert!(between_gaps(&model, &Logs::new(vec![&test], Vec::new())).is_none());
    }
}
