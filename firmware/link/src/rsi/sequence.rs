//! Interpretation of the next `IPOC`: progress, a repetition, a loss, or a new run.

/// How a telegram follows the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// The first telegram since power-up or [`SequenceTracker::reset`].
    First,
    /// The next cycle.
    Next,
    /// The same `IPOC` again: send the same answer again and do not integrate again.
    Duplicate,
    /// Telegrams were lost. The correction of the lost cycles is gone; it must not be made up for in one cycle.
    Gap {
        /// Cycles without a telegram.
        lost: u32,
    },
    /// Slightly older than the last one: it was overtaken on its way, and no cycle runs for it.
    Late,
    /// The time stamp went backwards or jumped: RSI was started anew, begin from zero.
    NewRun,
}

/// Cycles by which a telegram may be older than the last one without belonging to a new run: as far as a network reorders. A
/// robot that restarts RSI is silent for longer.
const MOST_LATE_CYCLES: u64 = 3;

/// Follows the `IPOC` of accepted telegrams.
#[derive(Clone, Copy, Debug)]
pub struct SequenceTracker {
    cycle_ms: u64,
    max_gap_cycles: u32,
    last: Option<u64>,
}

impl SequenceTracker {
    /// Tracker for a sensor cycle of `cycle_ms` (4 in `#IPO_FAST`, 12 in `#IPO`). A step of more than
    /// `max_gap_cycles` cycles is a new run.
    pub fn new(cycle_ms: u64, max_gap_cycles: u32) -> Self {
        Self {
            cycle_ms: cycle_ms.max(1),
            max_gap_cycles,
            last: None,
        }
    }

    /// Classifies `ipoc` and makes it the last one, unless it is late.
    ///
    /// The time stamp is in whole milliseconds and some controllers and simulators step it unevenly (some by 1), so a
    /// step is rounded to the nearest number of cycles, and a step forwards is never less than one cycle.
    pub fn classify(&mut self, ipoc: u64) -> Sequence {
        let Some(last) = self.last.replace(ipoc) else {
            return Sequence::First;
        };
        let Some(step_ms) = ipoc.checked_sub(last) else {
            if self.is_late(ipoc, last) {
                self.last = Some(last);
                return Sequence::Late;
            }
            return Sequence::NewRun;
        };
        if step_ms == 0 {
            return Sequence::Duplicate;
        }
        let whole = step_ms / self.cycle_ms;
        let rounds_up = step_ms % self.cycle_ms >= self.cycle_ms.div_ceil(2);
        let cycles = whole.saturating_add(rounds_up.into()).max(1);
        match u32::try_from(cycles) {
            Ok(1) => Sequence::Next,
            Ok(cycles) if cycles <= self.max_gap_cycles => Sequence::Gap { lost: cycles - 1 },
            _ => Sequence::NewRun,
        }
    }

    /// Whether a telegram was overtaken on its way by another one.
    pub fn is_late(&self, ipoc: u64, other: u64) -> bool {
        let most_ms = MOST_LATE_CYCLES.saturating_mul(self.cycle_ms);
        (1..=most_ms).contains(&other.saturating_sub(ipoc))
    }

    /// Forgets the last telegram, after the connection was given up.
    pub fn reset(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn follow<const N: usize>(mut tracker: SequenceTracker, ipocs: [u64; N]) -> [Sequence; N] {
        ipocs.map(|ipoc| tracker.classify(ipoc))
    }

    #[test]
    fn follows_the_rules() {
        use Sequence::{Duplicate, First, Gap, NewRun, Next};
        let tracker = SequenceTracker::new(4, 10);
        assert_eq!(
            follow(tracker, [100, 104, 104, 108, 116, 156, 200, 160, 164]),
            [
                First,
                Next,
                Duplicate,
                Next,
                Gap { lost: 1 },
                Gap { lost: 9 },
                NewRun,
                NewRun,
                Next
            ]
        );
        let slow = SequenceTracker::new(12, 2);
        assert_eq!(
            follow(slow, [0, 12, 36, 72]),
            [First, Next, Gap { lost: 1 }, NewRun]
        );
    }

    #[test]
    fn what_was_overtaken_is_late_and_changes_nothing() {
        use Sequence::{Duplicate, First, Gap, Late, NewRun, Next};
        assert_eq!(
            follow(
                SequenceTracker::new(4, 10),
                [100, 104, 100, 108, 116, 104, 116, 120, 107]
            ),
            [
                First,
                Next,
                Late,
                Next,
                Gap { lost: 1 },
                Late,
                Duplicate,
                Next,
                NewRun
            ]
        );
    }

    #[test]
    fn uneven_steps_are_rounded() {
        use Sequence::{First, Gap, Next};
        assert_eq!(
            follow(SequenceTracker::new(4, 10), [0, 1, 2, 7, 10, 19]),
            [First, Next, Next, Next, Next, Gap { lost: 1 }]
        );
    }

    #[test]
    fn extremes_do_not_overflow() {
        use Sequence::{First, NewRun, Next};
        assert_eq!(
            follow(
                SequenceTracker::new(0, u32::MAX),
                [0, u64::MAX, 0, 1, u64::MAX]
            ),
            [First, NewRun, NewRun, Next, NewRun]
        );
        assert_eq!(
            follow(SequenceTracker::new(u64::MAX, 1), [0, 1]),
            [First, Next]
        );
    }

    #[test]
    fn reset_starts_over() {
        let mut tracker = SequenceTracker::new(4, 10);
        tracker.classify(100);
        tracker.reset();
        assert_eq!(tracker.classify(100), Sequence::First);
    }
}
