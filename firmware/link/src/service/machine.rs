//! State of the board itself: its stack, its Ethernet, its response times, and statistics of its inputs. For people only; no
//! control cycle uses it.

use super::Word;
use serde::{Deserialize, Serialize};

/// Bins of [`AnswerTimes::histogram`]: sixteenths of a cycle, and one for whatever takes longer.
pub const ANSWER_BINS: usize = 17;

/// State of the board itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Cause of the last reset, as the chip reports; empty for a board that is a program.
    pub reset: Word,
    /// Its stack; `None` where an operating system manages it.
    pub stack: Option<StackUse>,
    /// Its Ethernet; `None` where an operating system manages it.
    pub ethernet: Option<EthernetHealth>,
    /// Times from a telegram to its answer.
    pub answers: AnswerTimes,
    /// The inputs of the last second.
    pub inputs: InputStatistics,
    /// Processor cycles for an answer; `None` without a counter of them.
    pub work: Option<Work>,
}

/// Cycles of the processor from the instant at which a telegram was read to that at which its answer was handed to the
/// network. Interrupts in between are counted, sleep in the wait for a sample is not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// For the last answer.
    pub last: u32,
    /// The most since boot.
    pub most: u32,
}

/// The stack of a microcontroller, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StackUse {
    /// Largest depth since boot, from the intact paint.
    pub deepest: u32,
    /// Size of the stack.
    pub available: u32,
}

/// Link and receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EthernetHealth {
    /// There is a link.
    pub link: bool,
    /// Times that it was lost.
    pub losses: u32,
    /// Times that reception was found suspended or stopped, and brought back.
    pub overruns: u32,
}

/// Times from the instant at which a telegram left the network's driver to that at which its answer was handed to the
/// network, for the telegrams that led to a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct AnswerTimes {
    /// The last one, µs.
    pub last_us: u32,
    /// The longest since boot, µs.
    pub longest_us: u32,
    /// Number of answers by duration, in sixteenths of a cycle.
    pub histogram: [u32; ANSWER_BINS],
}

impl AnswerTimes {
    /// Before the first answer.
    pub const NONE: Self = Self {
        last_us: 0,
        longest_us: 0,
        histogram: [0; ANSWER_BINS],
    };

    /// Takes in a further answer; the robot's cycle lasts `cycle_us`.
    pub fn take(&mut self, took_us: u32, cycle_us: u32) {
        self.last_us = took_us;
        self.longest_us = self.longest_us.max(took_us);
        let bin = u64::from(took_us) * (ANSWER_BINS as u64 - 1) / u64::from(cycle_us.max(1));
        let bin = usize::try_from(bin).unwrap_or(usize::MAX);
        if let Some(count) = self.histogram.get_mut(bin.min(ANSWER_BINS - 1)) {
            *count = count.saturating_add(1);
        }
    }

    /// Answers that took longer than a cycle.
    pub fn late_answers(&self) -> u32 {
        let [.., late] = self.histogram;
        late
    }
}

/// Statistics of the inputs over about a second. Square roots are micromath's: up to 6 % off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InputStatistics {
    /// Noise of the force, rms of an axis, N: by differences from sample to sample, so that what changes
    /// slowly does not count.
    pub force_noise_n: f32,
    /// Noise of the torque, rms of an axis, N·m.
    pub torque_noise_n_m: f32,
    /// Mean time between two telegrams, µs.
    pub cycle_us: f32,
    /// Its standard deviation, µs.
    pub cycle_deviation_us: f32,
}

impl InputStatistics {
    /// Before the first second is over.
    pub const NONE: Self = Self {
        force_noise_n: 0.0,
        torque_noise_n_m: 0.0,
        cycle_us: 0.0,
        cycle_deviation_us: 0.0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_counted_by_sixteenths_of_their_cycle() {
        let mut times = AnswerTimes::NONE;
        for took_us in [0, 249, 250, 3999, 4000, u32::MAX, 100] {
            times.take(took_us, 4000);
        }
        assert_eq!((times.last_us, times.longest_us), (100, u32::MAX));
        assert_eq!(times.late_answers(), 2);
        let [first, second, .., last, _] = times.histogram;
        assert_eq!((first, second, last), (3, 1, 1));
        times.take(7, 0);
        assert_eq!(times.late_answers(), 3, "no cycle at all");
    }
}
