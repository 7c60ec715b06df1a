//! A cycle cut into parts in which the command is constant.

use super::Reading;

/// Instants of the cycles.
#[derive(Clone, Copy, Debug)]
pub struct Timing<'a> {
    /// Nominal cycle time, s.
    pub cycle_s: f64,
    /// True duration of the cycle that ends with cycle n, s; empty where all have the nominal one.
    pub intervals_s: &'a [f64],
}

impl Timing<'_> {
    /// Cycles that all last equally long.
    pub fn uniform(cycle_s: f64) -> Self {
        Self {
            cycle_s,
            intervals_s: &[],
        }
    }

    /// Duration of the cycle that ends with cycle n, s.
    pub fn interval(&self, n: usize) -> f64 {
        self.intervals_s.get(n).copied().unwrap_or(self.cycle_s)
    }

    /// Velocities as they are recorded: the difference of two poses is divided by the nominal
    /// cycle time, however long the cycle was.
    pub fn as_recorded(&self, velocities: &mut [f64], reading: Reading) {
        if reading == Reading::Mean {
            for (velocity, interval_s) in velocities.iter_mut().zip(self.intervals_s) {
                *velocity *= interval_s / self.cycle_s;
            }
        }
    }
}

/// A part of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    pub duration_s: f64,
    /// Cycle whose command acts; None before the first.
    pub command: Option<usize>,
}

/// Cuts cycles at the arrivals of commands, and into equal parts.
pub(super) struct Cut<'a> {
    delay_s: f64,
    equal: usize,
    timing: Timing<'a>,
    /// Parts of a cycle and how many cycles ago their command was sent, if all cycles are alike.
    pattern: Vec<(f64, usize)>,
    /// Start of the cycle, and arrival of the next command, after the first cycle, s.
    now_s: f64,
    next: usize,
    next_arrival_s: f64,
    buffer: Vec<Part>,
}

/// Parts shorter than this share of a cycle are none.
const SHORTEST: f64 = 1e-9;

impl<'a> Cut<'a> {
    pub(super) fn new(delay_s: f64, equal: usize, timing: &Timing<'a>) -> Self {
        let cycles = (delay_s / timing.cycle_s).max(0.0);
        let (whole, fraction) = (cycles.floor(), cycles.fract());
        let mut ends: Vec<f64> = (1..=equal).map(|i| i as f64 / equal as f64).collect();
        ends.push(fraction);
        ends.sort_by(f64::total_cmp);
        let mut pattern = Vec::new();
        let mut from = 0.0;
        for end in ends {
            if end - from > SHORTEST {
                // The older command acts until `fraction`, then the newer one.
                let ago = 1 + whole as usize + usize::from(end <= fraction);
                pattern.push(((end - from) * timing.cycle_s, ago));
                from = end;
            }
        }
        Self {
            delay_s: delay_s.max(0.0),
            equal,
            timing: *timing,
            pattern,
            now_s: 0.0,
            next: 0,
            next_arrival_s: delay_s.max(0.0),
            buffer: Vec::new(),
        }
    }

    /// Parts of the cycle that ends with cycle n; called for n = 1, 2, ... in turn.
    pub(super) fn parts(&mut self, n: usize) -> &[Part] {
        self.buffer.clear();
        if self.timing.intervals_s.is_empty() {
            let parts = self.pattern.iter().map(|(duration_s, ago)| Part {
                duration_s: *duration_s,
                command: n.checked_sub(*ago),
            });
            self.buffer.extend(parts);
        } else {
            self.cut_exactly(n);
        }
        &self.buffer
    }

    fn cut_exactly(&mut self, n: usize) {
        let interval = self.timing.interval(n);
        let end_of_cycle = self.now_s + interval;
        let shortest = SHORTEST * self.timing.cycle_s;
        for i in 1..=self.equal {
            let end = self.now_s + interval * i as f64 / self.equal as f64;
            let mut from = self.now_s + interval * (i - 1) as f64 / self.equal as f64;
            while self.next_arrival_s < end - shortest {
                self.push(self.next_arrival_s - from);
                from = from.max(self.next_arrival_s);
                self.next += 1;
                // A command is sent at the instant of its cycle.
                self.next_arrival_s = self.sent_at(self.next, n, end_of_cycle) + self.delay_s;
            }
            self.push(end - from);
        }
        self.now_s = end_of_cycle;
    }

    /// Instant of a cycle that is not far from cycle n, s.
    fn sent_at(&self, cycle: usize, n: usize, instant_of_n: f64) -> f64 {
        let mut instant = instant_of_n;
        for k in cycle + 1..=n {
            instant -= self.timing.interval(k);
        }
        for k in n + 1..=cycle {
            instant += self.timing.interval(k);
        }
        instant
    }

    fn push(&mut self, duration_s: f64) {
        if duration_s > SHORTEST * self.timing.cycle_s {
            self.buffer.push(Part {
                duration_s,
                command: self.next.checked_sub(1),
            });
        }
    }
}
