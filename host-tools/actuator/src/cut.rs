//! A cycle cut into segments in which the command is constant, and these into parts.

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

/// Segment of a cycle in which the command is constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// Cycle whose command acts; None before the first.
    pub command: Option<usize>,
    /// Its begin after that of the cycle, s.
    from_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Equal parts of the cycle, at which the segment is cut as well.
    equal: usize,
    /// Duration of the cycle, s.
    cycle_s: f64,
}

impl Segment {
    /// Durations of its parts, s.
    pub(super) fn parts_s(&self) -> impl Iterator<Item = f64> + use<> {
        let Self {
            from_s,
            duration_s,
            equal,
            cycle_s,
            ..
        } = *self;
        let (to_s, shortest) = (from_s + duration_s, SHORTEST * cycle_s);
        let ends = (1..=equal).map(move |i| cycle_s * i as f64 / equal as f64);
        let inside = ends.filter(move |end| *end > from_s + shortest && *end < to_s - shortest);
        let mut last = from_s;
        let all = inside.chain(std::iter::once(to_s));
        all.map(move |end| end - std::mem::replace(&mut last, end))
    }
}

/// Cuts cycles at the arrivals of commands, and these segments into equal parts.
pub(super) struct Cut<'a> {
    delay_s: f64,
    equal: usize,
    timing: Timing<'a>,
    segments: Vec<Segment>,
    /// Number of cycles ago in which each segment's command was sent, if all cycles are alike.
    ago: Vec<usize>,
    /// Start of the cycle, and arrival of the next command, after the first cycle, s.
    now_s: f64,
    next: usize,
    next_arrival_s: f64,
}

/// Parts shorter than this share of a cycle are none.
const SHORTEST: f64 = 1e-9;

impl<'a> Cut<'a> {
    pub(super) fn new(delay_s: f64, equal: usize, timing: &Timing<'a>) -> Self {
        let delay_s = delay_s.max(0.0);
        let mut cut = Self {
            delay_s,
            equal,
            timing: *timing,
            segments: Vec::new(),
            ago: Vec::new(),
            now_s: 0.0,
            next: 0,
            next_arrival_s: delay_s,
        };
        if cut.cycles_are_alike() {
            cut.cut_once();
        }
        cut
    }

    /// Whether all cycles have the same segments, apart from the commands.
    pub(super) fn cycles_are_alike(&self) -> bool {
        self.timing.intervals_s.is_empty()
    }

    /// Segments of the cycle that ends with cycle n; called for n = 1, 2, ... in turn.
    pub(super) fn segments(&mut self, n: usize) -> &[Segment] {
        if self.cycles_are_alike() {
            for (segment, ago) in self.segments.iter_mut().zip(&self.ago) {
                segment.command = n.checked_sub(*ago);
            }
        } else {
            self.cut_exactly(n);
        }
        &self.segments
    }

    /// All cycles are cut in the same way: the older command acts until the newer one arrives.
    fn cut_once(&mut self) {
        let cycle_s = self.timing.cycle_s;
        let cycles = self.delay_s / cycle_s;
        let (whole, arrival_s) = (cycles.floor() as usize, cycles.fract() * cycle_s);
        for (from_s, to_s, ago) in [(0.0, arrival_s, whole + 2), (arrival_s, cycle_s, whole + 1)] {
            if self.push(None, from_s, to_s, cycle_s) {
                self.ago.push(ago);
            }
        }
    }

    fn cut_exactly(&mut self, n: usize) {
        self.segments.clear();
        let interval = self.timing.interval(n);
        let end_of_cycle = self.now_s + interval;
        let shortest = SHORTEST * self.timing.cycle_s;
        let mut from_s = 0.0;
        while self.next_arrival_s < end_of_cycle - shortest {
            let to_s = self.next_arrival_s - self.now_s;
            self.push(self.next.checked_sub(1), from_s, to_s, interval);
            from_s = from_s.max(to_s);
            self.next += 1;
            // A command is sent at the instant of its cycle.
            self.next_arrival_s = self.sent_at(self.next, n, end_of_cycle) + self.delay_s;
        }
        self.push(self.next.checked_sub(1), from_s, interval, interval);
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

    /// Adds a segment unless it is too short. Returns whether it was added.
    fn push(&mut self, command: Option<usize>, from_s: f64, to_s: f64, cycle_s: f64) -> bool {
        let is_one = to_s - from_s > SHORTEST * self.timing.cycle_s;
        if is_one {
            self.segments.push(Segment {
                command,
                from_s,
                duration_s: to_s - from_s,
                equal: self.equal,
                cycle_s,
            });
        }
        is_one
    }
}
