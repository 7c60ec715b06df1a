//! A contact integrated anew from its touch, with everything that is known by now.

use super::SmithSettings;
use super::spring::Spring;
use crate::delay::contact::{Along, saturated};
use crate::scalar::Scalar;

/// Cycles that are integrated anew; what is older stays as it was. 0.26 s at 4 ms.
const LOG: usize = 64;
/// Longest time before the first sample that is integrated, cycles.
const LONGEST_HEAD: f64 = 72.0;
/// Cycles by which the touch may lie before the first sample.
const LONGEST_ONSET: f64 = 8.0;
/// Integration steps per cycle.
const SUB_STEPS: usize = 2;
/// Largest rebound, in approach speeds. Above 1 by more than the noise of a bounce: a bound at 1 would
/// slow every second bounce down.
const FASTEST_REBOUND: f64 = 1.1;
/// Ranges of depth, mm, speed, mm/s, and push per mass, mm/s².
const DEEPEST_MM: f64 = 100.0;
const FASTEST_MM_S: f64 = 1e4;
const LARGEST_MM_S2: f64 = 1e5;

/// Depth behind the wall, mm, and speed into it, mm/s.
#[derive(Clone, Copy, Debug)]
struct Motion<S> {
    depth: S,
    speed: S,
}

/// A contact and its log.
#[derive(Clone, Debug)]
pub(super) struct Replay<S: Scalar> {
    latency: usize,
    ts: S,
    sub_step: S,
    spring: Option<Spring<S>>,
    /// Motion before the log, and the cycles from there to its first sample.
    base: Motion<S>,
    head: S,
    lead: S,
    /// Velocity of the model at the first sample, and before the touch, mm/s.
    entry: S,
    approach: S,
    /// Push per mass, mm/s², of each cycle.
    pushes: [S; LOG],
    /// Reported depth, mm, in the same cycle; the last `latency` are not known yet.
    depths: [S; LOG],
    len: usize,
    known: usize,
    /// Reported depth, mm, from the cycle of the touch.
    reported: S,
    /// Cycles since the touch.
    since: usize,
    /// Smallest push that tells of the contact, mm/s².
    least: S,
    now: Motion<S>,
    velocity: S,
    misfit: S,
    mass_kg: f64,
}

impl<S: Scalar> Replay<S> {
    /// No contact yet.
    pub(super) fn new(latency: usize, cycle_s: f64) -> Self {
        let rest = Motion {
            depth: S::zero(),
            speed: S::zero(),
        };
        Self {
            latency,
            ts: S::of(cycle_s),
            sub_step: S::of(cycle_s / SUB_STEPS as f64),
            spring: None,
            base: rest,
            head: S::zero(),
            lead: S::zero(),
            entry: S::zero(),
            approach: S::zero(),
            pushes: [S::zero(); LOG],
            depths: [S::zero(); LOG],
            len: 0,
            known: 0,
            reported: S::zero(),
            since: 0,
            least: S::zero(),
            now: rest,
            velocity: S::zero(),
            misfit: S::zero(),
            mass_kg: 0.0,
        }
    }

    /// A contact begins; `lead` is in cycles.
    pub(super) fn open(&mut self, settings: &SmithSettings, along: &Along<S>, lead: S) {
        // Once per contact, and in numbers that no scalar type rounds.
        let mobility = along.mobility.get();
        self.mass_kg = 1.0 / mobility;
        // A quarter of the threshold stands for the noise; the given stiffness may be wrong by 2.
        let doubt_mm = settings.threshold_n / settings.stiffness_n_per_m * 1e3 / 8.0;
        self.spring = Some(Spring::new(
            S::of(settings.stiffness_n_per_m * mobility),
            S::of(settings.damping_n_s_per_m * mobility),
            S::of((doubt_mm * doubt_mm).max(1e-8)),
            settings.identify,
        ));
        self.entry = saturated(-along.velocity * S::of(1e3), FASTEST_MM_S);
        self.approach = self.entry;
        self.base = Motion {
            depth: S::zero(),
            speed: self.approach,
        };
        (self.lead, self.head) = (lead, lead);
        (self.len, self.known, self.since) = (0, 0, 0);
        self.reported = S::zero();
        self.least = S::of(settings.threshold_n * mobility * 1e3);
    }

    /// A cycle of the contact.
    pub(super) fn push(&mut self, along: &Along<S>) {
        if self.since > 0 {
            self.reported -= saturated(along.moved * S::of(1e3), DEEPEST_MM);
            self.reported = saturated(self.reported, DEEPEST_MM);
        }
        if self.len == LOG {
            self.forget_oldest();
        }
        let load = saturated(along.load * along.mobility, LARGEST_MM_S2 * 1e-3);
        self.pushes[self.len] = load * S::of(1e3);
        self.len += 1;
        if self.since >= self.latency {
            self.depths[self.known] = self.reported;
            self.known += 1;
        }
        self.since = self.since.saturating_add(1);
    }

    /// Identifies the contact and integrates it up to now, and for one cycle more.
    pub(super) fn run(&mut self) {
        let Some(mut spring) = self.spring else {
            return;
        };
        let touched = |(_, a, _): &(S, S, S)| *a >= self.least;
        spring.fit((0..self.known).map(|i| self.sample(i)).filter(touched));
        self.spring = Some(spring);
        let mut motion = self.touch(&spring);
        let (mut misfit, mut sum) = (S::zero(), S::zero());
        for i in 0..self.len {
            let rest = self.residual(i, &spring);
            misfit += rest.abs();
            sum += self.pushes[i].abs();
            self.now = motion;
            motion = self.cycle(motion, &spring, rest, self.sub_step);
        }
        self.misfit = if sum > self.least {
            misfit / sum
        } else {
            S::zero()
        };
        // No wall gives back more than it got, whatever a wrong spring says.
        let velocity = (motion.depth - self.now.depth) / self.ts;
        let fastest = self.approach * S::of(FASTEST_REBOUND);
        self.velocity = velocity.clamp(-fastest, fastest);
    }

    /// Depth of the model behind the wall, mm.
    pub(super) fn depth(&self) -> S {
        self.now.depth
    }

    /// Velocity of the model into the wall over the coming cycle, mm/s.
    pub(super) fn velocity(&self) -> S {
        self.velocity
    }

    /// Velocity before the touch, mm/s.
    pub(super) fn approach(&self) -> S {
        self.approach
    }

    /// Depth of the robot behind the wall by its reported pose, mm; none before the wall is known.
    pub(super) fn reported_depth(&self) -> Option<S> {
        let wall = self.spring?.wall?;
        Some(self.reported - wall)
    }

    /// Stiffness of the present or last contact, N/m; 0 before the first.
    pub(super) fn stiffness_n_per_m(&self) -> f64 {
        self.spring
            .map_or(0.0, |spring| spring.stiffness.get() * self.mass_kg)
    }

    /// Part of the measured push that the contact model does not explain.
    pub(super) fn misfit(&self) -> S {
        self.misfit
    }

    /// Motion in the model's time of the first sample: a delay after the touch.
    fn touch(&mut self, spring: &Spring<S>) -> Motion<S> {
        if self.head > S::zero() {
            self.begin(spring);
        }
        let mut motion = self.base;
        let mut left = self.head.min(S::of(LONGEST_HEAD));
        let part = left - left.floor();
        motion = self.cycle(motion, spring, S::zero(), self.sub_step * part);
        left -= part;
        while left > S::of(0.5) {
            motion = self.cycle(motion, spring, S::zero(), self.sub_step);
            left -= S::one();
        }
        motion
    }

    /// When and how fast the touch was, from the depth of the first sample that counted.
    fn begin(&mut self, spring: &Spring<S>) {
        let first = match spring.wall {
            Some(wall) if self.known > 0 => self.depths[0] - wall,
            _ => self.pushes[0] / spring.stiffness,
        };
        // Samples below the threshold have slowed the model already: κ Ts times the sum of their
        // depths, which are a cycle's way apart.
        let before = first - self.entry * self.ts;
        self.approach = self.entry;
        if before > S::zero() && first < self.entry * self.ts * S::of(LONGEST_ONSET) {
            let slowed = spring.stiffness * before * (first / self.entry) * S::of(0.5);
            self.approach += slowed.min(self.entry * S::of(0.25));
        }
        self.base.speed = self.approach;
        self.head = self.lead + self.onset(first);
    }

    /// Cycles from the touch to a first sample at this depth.
    fn onset(&self, depth: S) -> S {
        let per_cycle = self.approach * self.ts;
        if depth <= S::zero() {
            S::zero()
        } else if depth >= per_cycle * S::of(LONGEST_ONSET) {
            S::of(LONGEST_ONSET)
        } else {
            depth / per_cycle
        }
    }

    /// (reported depth, push, speed) of a cycle whose depth is known.
    fn sample(&self, i: usize) -> (S, S, S) {
        let speed = match i {
            0 => self.approach,
            _ => saturated(
                (self.depths[i] - self.depths[i - 1]) / self.ts,
                FASTEST_MM_S,
            ),
        };
        (self.depths[i], self.pushes[i], speed)
    }

    /// F_meas − F̂(x_exec) of a cycle, per mass; 0 while it is not known.
    fn residual(&self, i: usize, spring: &Spring<S>) -> S {
        let Some(wall) = spring.wall.filter(|_| i < self.known) else {
            return S::zero();
        };
        let (depth, push, speed) = self.sample(i);
        push - spring.push(depth - wall, speed)
    }

    /// A cycle under F̂ of the motion's own depth and a further push (leapfrog).
    fn cycle(&self, from: Motion<S>, spring: &Spring<S>, further: S, sub_step: S) -> Motion<S> {
        let half = sub_step * S::of(0.5);
        let mut motion = from;
        for _ in 0..SUB_STEPS {
            let middle = motion.depth + motion.speed * half;
            let push = spring.push(middle, motion.speed) + further;
            let push = saturated(push, LARGEST_MM_S2);
            motion.speed = saturated(motion.speed - push * sub_step, FASTEST_MM_S);
            motion.depth = saturated(middle + motion.speed * half, DEEPEST_MM);
        }
        motion
    }

    /// Integrates the oldest cycle for good.
    fn forget_oldest(&mut self) {
        if let Some(spring) = self.spring {
            let start = self.touch(&spring);
            let rest = self.residual(0, &spring);
            self.base = self.cycle(start, &spring, rest, self.sub_step);
        }
        self.head = S::zero();
        self.pushes.copy_within(1.., 0);
        self.depths.copy_within(1.., 0);
        self.len -= 1;
        self.known = self.known.saturating_sub(1);
    }
}
