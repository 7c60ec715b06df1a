//! The contact, integrated anew from its onset in each cycle with all samples known by then. All per mass: accelerations in
//! mm/s², depths in mm.

use super::SmithSettings;
use super::spring::Spring;
use crate::delay::contact::{Along, saturated};
use crate::scalar::Scalar;

/// Cycles that are integrated anew, 0.26 s at 4 ms; the motion before them is not changed any more.
const LOG: usize = 64;
/// Longest time from the onset to the first sample that is integrated, cycles.
const LONGEST_HEAD: f64 = 72.0;
/// Cycles by which the onset may lie before the first sample.
const LONGEST_ONSET: f64 = 8.0;
/// Integration steps per cycle.
const SUB_STEPS: usize = 2;
/// Largest rebound, in approach speeds. Above 1 by more than the noise of a bounce: a bound at 1 would
/// slow every second bounce down.
const FASTEST_REBOUND: f64 = 1.1;
/// Limits of depth, mm, speed, mm/s, and force per mass, mm/s².
const DEEPEST_MM: f64 = 100.0;
const FASTEST_MM_S: f64 = 1e4;
const LARGEST_MM_S2: f64 = 1e5;
/// Largest force that [`Replay::expected_n`] returns, N.
const LARGEST_N: f64 = 1e5;
/// Depth behind the surface, mm, and speed into it, mm/s.
#[derive(Clone, Copy, Debug)]
struct Motion<S> {
    depth: S,
    speed: S,
}

/// A contact and its samples.
#[derive(Clone, Debug)]
pub(super) struct Replay<S: Scalar> {
    latency: usize,
    ts: S,
    sub_step: S,
    spring: Option<Spring<S>>,
    /// Motion at the beginning of the integration, and the cycles from there to the first sample that is kept.
    base: Motion<S>,
    head: S,
    lead: S,
    /// Velocity of the model at the first sample, and before the onset, mm/s.
    entry: S,
    approach: S,
    /// Measured force per mass of each cycle, mm/s².
    pushes: [S; LOG],
    /// Reported depth of the same cycles, mm; those of the last `latency` cycles are not known yet.
    depths: [S; LOG],
    len: usize,
    known: usize,
    /// Reported depth relative to that in the cycle of the onset, mm.
    reported: S,
    /// Cycles since the onset.
    since: usize,
    /// Smallest force per mass that is used for the fit, mm/s²: the threshold.
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

    /// A contact begins. `lead` is the number of cycles from the model's velocity to its execution.
    pub(super) fn open(&mut self, settings: &SmithSettings, along: &Along<S>, lead: S) {
        // Once per contact, and in f64, which does not lose digits.
        let mobility = along.mobility.get();
        self.mass_kg = 1.0 / mobility;
        // Error of a depth: noise of a quarter of the threshold, divided by the stiffness, of which the given value may be wrong
        // by a factor of 2.
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

    /// Takes in a cycle of the contact.
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

    /// Identifies the contact, and integrates it up to now and for one cycle more.
    pub(super) fn run(&mut self) {
        let Some(mut spring) = self.spring else {
            return;
        };
        let touched = |(_, a, _): &(S, S, S)| *a >= self.least;
        spring.fit((0..self.known).map(|i| self.sample(i)).filter(touched));
        self.spring = Some(spring);
        let mut motion = self.at_first_sample(&spring);
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
        // No contact gives back more than it got, even if the identified spring is wrong.
        let velocity = (motion.depth - self.now.depth) / self.ts;
        let fastest = self.approach * S::of(FASTEST_REBOUND);
        self.velocity = velocity.clamp(-fastest, fastest);
    }

    /// Depth of the model behind the surface, mm.
    pub(super) fn depth(&self) -> S {
        self.now.depth
    }

    /// Velocity of the model into the surface over the coming cycle, mm/s.
    pub(super) fn velocity(&self) -> S {
        self.velocity
    }

    /// Velocity before the onset, mm/s.
    pub(super) fn approach(&self) -> S {
        self.approach
    }

    /// Depth of the robot behind the surface by its reported pose, mm; `None` before the surface is known.
    pub(super) fn reported_depth(&self) -> Option<S> {
        let surface = self.spring?.surface?;
        Some(self.reported - surface)
    }

    /// F̂ at the last reported depth, N; `None` before the surface is known.
    pub(super) fn expected_n(&self) -> Option<S> {
        let last = self.known.checked_sub(1)?;
        let (depth, _, speed) = self.sample(last);
        let spring = self.spring?;
        let push = spring.push(depth - spring.surface?, speed).get();
        Some(S::of((push * 1e-3 * self.mass_kg).min(LARGEST_N)))
    }

    /// Stiffness of the present or last contact, N/m; 0 before the first.
    pub(super) fn stiffness_n_per_m(&self) -> f64 {
        self.spring
            .map_or(0.0, |spring| spring.stiffness.get() * self.mass_kg)
    }

    /// Fraction of the measured force that the contact model does not explain.
    pub(super) fn misfit(&self) -> S {
        self.misfit
    }

    /// Motion of the model at the time of the first sample, a delay after the onset.
    fn at_first_sample(&mut self, spring: &Spring<S>) -> Motion<S> {
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

    /// Time and speed of the onset, from the depth of the first sample.
    fn begin(&mut self, spring: &Spring<S>) {
        let first = match spring.surface {
            Some(surface) if self.known > 0 => self.depths[0] - surface,
            _ => self.pushes[0] / spring.stiffness,
        };
        // Loads below the threshold have slowed the model already: by κ Ts times the sum of their depths, which are a cycle's
        // displacement apart.
        let before = first - self.entry * self.ts;
        self.approach = self.entry;
        if before > S::zero() && first < self.entry * self.ts * S::of(LONGEST_ONSET) {
            let slowed = spring.stiffness * before * (first / self.entry) * S::of(0.5);
            self.approach += slowed.min(self.entry * S::of(0.25));
        }
        self.base.speed = self.approach;
        self.head = self.lead + self.onset(first);
    }

    /// Cycles from the onset to a first sample at this depth.
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

    /// (reported depth, force per mass, speed) of a cycle whose depth is known.
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

    /// F_meas − F̂(x_exec) of a cycle, per mass; 0 while its depth or the surface is not known.
    fn residual(&self, i: usize, spring: &Spring<S>) -> S {
        let Some(surface) = spring.surface.filter(|_| i < self.known) else {
            return S::zero();
        };
        let (depth, push, speed) = self.sample(i);
        push - spring.push(depth - surface, speed)
    }

    /// Integrates a cycle under F̂ at the motion's own depth plus a `further` force per mass (leapfrog).
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

    /// Integrates the oldest cycle for the last time and drops its sample.
    fn forget_oldest(&mut self) {
        if let Some(spring) = self.spring {
            let start = self.at_first_sample(&spring);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::spacecraft::CYCLE_S;
    use softdock_delay_plants::truth;

    const MASS: f64 = 500.0;
    /// Approach, m/s.
    const SPEED: f64 = 0.005;
    /// Cycles from the model's velocity to its execution.
    const LEAD: f64 = 8.5;

    /// The exact bounce of a mass off a spring and damper of this frequency (rad/s) and damping ratio.
    #[derive(Clone, Copy)]
    struct Bounce {
        omega: f64,
        zeta: f64,
        /// Cycles from the onset to the first sample.
        phase: f64,
        /// Velocity of the model at the first sample, m/s.
        entry: f64,
        /// Loads on the way out, relative to those of the spring and damper.
        way_out: f64,
    }

    impl Bounce {
        fn new(omega: f64, zeta: f64, phase: f64) -> Self {
            let (entry, way_out) = (SPEED, 1.0);
            Self {
                omega,
                zeta,
                phase,
                entry,
                way_out,
            }
        }

        fn load(&self, cycles: f64) -> f64 {
            let (_, rate, load) = self.at(cycles);
            load * if rate < 0.0 { self.way_out } else { 1.0 }
        }

        /// Depth (m), its rate (m/s) and the push (N) at a time after the onset, cycles.
        fn at(&self, cycles: f64) -> (f64, f64, f64) {
            let (t, stiffness) = (cycles * CYCLE_S, MASS * self.omega * self.omega);
            let truth = truth::Bounce::new(MASS, stiffness, self.zeta, SPEED);
            (truth.displacement_m(t), truth.rate_m_s(t), truth.force_n(t))
        }

        fn settings(&self, stiffness_error: f64, identify: bool) -> SmithSettings {
            SmithSettings {
                stiffness_n_per_m: MASS * self.omega * self.omega * stiffness_error,
                damping_n_s_per_m: 2.0 * self.zeta * self.omega * MASS,
                identify,
                threshold_n: 0.1,
                ..SmithSettings::default()
            }
        }

        /// A robot that executes the bounce with the believed delay, seen by a pose that is `latency` cycles old; calls the check
        /// after each cycle.
        fn follow(
            &self,
            settings: &SmithSettings,
            latency: usize,
            cycles: usize,
            mut ask: impl FnMut(usize, &Replay<f64>),
        ) {
            let mut replay = Replay::new(latency, CYCLE_S);
            assert_eq!(
                (replay.stiffness_n_per_m(), replay.reported_depth()),
                (0.0, None)
            );
            for n in 0..cycles {
                let now = n as f64 + self.phase;
                let then = now - latency as f64;
                let along = Along {
                    opened: n == 0,
                    load: self.load(now),
                    load_then: self.load(then),
                    // Away from the surface is positive.
                    moved: self.at(then - 1.0).0 - self.at(then).0,
                    velocity: -self.entry,
                    mobility: 1.0 / MASS,
                };
                if along.opened {
                    replay.open(settings, &along, LEAD);
                }
                replay.push(&along);
                replay.run();
                ask(n, &replay);
            }
        }
    }

    fn bounces() -> [Bounce; 4] {
        [
            Bounce::new(21.0, 0.0, 0.6),
            Bounce::new(21.0, 0.1, 0.3),
            Bounce::new(9.0, 0.0, 0.9),
            Bounce::new(40.0, 0.0, 0.5),
        ]
    }

    /// This holds also for a contact that lasts longer than the 64 cycles that are kept.
    #[test]
    fn the_model_moves_as_the_contact_will_a_delay_later() {
        for bounce in bounces() {
            for latency in [0, 3] {
                let settings = bounce.settings(1.0, false);
                bounce.follow(&settings, latency, 90, |n, replay| {
                    // Before the surface is known, the depth is taken from the first load, of which a damper may make a part.
                    if n <= latency + 2 && bounce.zeta > 0.0 {
                        return;
                    }
                    let model = n as f64 + bounce.phase + LEAD;
                    let (depth, ..) = bounce.at(model);
                    // Long apart.
                    if depth < -SPEED / bounce.omega {
                        return;
                    }
                    let velocity = (bounce.at(model + 1.0).0 - depth) / CYCLE_S;
                    let (omega, zeta) = (bounce.omega, bounce.zeta);
                    let found = replay.velocity() * 1e-3;
                    let apart = (found - velocity).abs() / SPEED;
                    assert!(
                        apart < 0.02,
                        "{omega} {zeta} {latency} {n}: {found} {velocity}"
                    );
                    let apart = (replay.depth() * 1e-3 - depth).abs() * omega / SPEED;
                    assert!(apart < 0.06, "{omega} {zeta} {latency} {n}: {apart}");
                    assert!(replay.misfit() < 0.03, "{n}: {}", replay.misfit());
                    assert!((replay.approach() * 1e-3 / SPEED - 1.0).abs() < 1e-2);
                    let stiffness = replay.stiffness_n_per_m() / MASS / omega / omega;
                    assert!((stiffness - 1.0).abs() < 1e-9);
                });
            }
        }
    }

    /// The depth at the time of the reported pose, and the load there.
    #[test]
    fn the_robots_depth_is_that_of_its_reported_pose() {
        for latency in [0, 3] {
            let bounce = bounces()[1];
            bounce.follow(&bounce.settings(1.0, false), latency, 60, |n, replay| {
                if n <= latency + 2 {
                    return;
                }
                let seen = (n - latency) as f64 + bounce.phase;
                // The reported pose is counted from the first cycle of the contact.
                let (depth, _, push) = bounce.at(n as f64 + bounce.phase - latency as f64);
                let found = replay.reported_depth().unwrap() * 1e-3;
                assert!(
                    (found - depth).abs() < 2e-6,
                    "{latency} {n}: {found} {depth}"
                );
                let load = replay.expected_n().unwrap();
                let expected = bounce.at(seen).2.max(0.0);
                assert!(
                    (load - push).abs() < 1.5 && (expected - push).abs() < 1e-9,
                    "{latency} {n}: {load} {push}"
                );
            });
        }
    }

    /// Starting from half and from twice the true stiffness.
    #[test]
    fn a_stiffness_that_is_not_known_is_found() {
        for error in [0.5, 2.0] {
            let bounce = bounces()[0];
            let mut last = (0.0, 0.0);
            bounce.follow(&bounce.settings(error, true), 0, 45, |_, replay| {
                let stiffness = replay.stiffness_n_per_m() / MASS / 441.0;
                last = (stiffness, replay.velocity() * 1e-3);
            });
            assert!((last.0 - 1.0).abs() < 2e-3, "{error}: {}", last.0);
            assert!((last.1 / SPEED + 1.0).abs() < 0.01, "{error}: {}", last.1);
        }
    }

    /// Before the first sample above a threshold far above the noise, the model has been slowed already: by a quarter of its
    /// speed at most.
    #[test]
    fn the_approach_is_what_it_was_before_loads_too_small_to_count() {
        for (late, tolerance) in [(3.6, 2e-3), (1.4, 1e-3), (6.5, 1e-2)] {
            let mut bounce = Bounce::new(21.0, 0.0, late);
            // The model has felt the loads of the cycles before.
            let felt = (1..8).map(|n| bounce.load(late - f64::from(n)));
            bounce.entry -= felt.sum::<f64>() * CYCLE_S / MASS;
            let mut approach = 0.0;
            bounce.follow(&bounce.settings(1.0, false), 0, 30, |_, replay| {
                approach = replay.approach() * 1e-3;
            });
            assert!(
                (approach / SPEED - 1.0).abs() < tolerance,
                "{late}: {approach}"
            );
        }
    }

    /// With loads that are twice as large on the way out, it leaves at 1.1 times the approach speed.
    #[test]
    fn the_model_does_not_leave_much_faster_than_it_came() {
        let mut bounce = bounces()[0];
        bounce.way_out = 2.0;
        let mut fastest = 0.0_f64;
        bounce.follow(&bounce.settings(1.0, false), 0, 36, |_, replay| {
            fastest = fastest.max(-replay.velocity() / replay.approach());
        });
        assert!((fastest - 1.1).abs() < 1e-9, "{fastest}");
    }

    /// The weight is that of a depth of the threshold over the stiffness, with a quarter for the noise and a half for the
    /// uncertainty of the stiffness. Loads count from the threshold on.
    #[test]
    fn a_given_stiffness_weighs_as_much_as_the_noise_of_the_sensor() {
        let settings = SmithSettings {
            stiffness_n_per_m: 1e5,
            threshold_n: 2.0,
            ..SmithSettings::default()
        };
        let along = Along {
            opened: true,
            load: 1e12,
            load_then: 0.0,
            moved: 1e3,
            velocity: -SPEED,
            mobility: 1.0 / MASS,
        };
        let mut replay = Replay::new(0, CYCLE_S);
        replay.open(&settings, &along, LEAD);
        let ridge = replay.spring.unwrap().ridge;
        let doubt_mm = 2.0 / 1e5 * 1e3 / 8.0;
        assert!((ridge / doubt_mm / doubt_mm - 1.0).abs() < 1e-12, "{ridge}");
        assert!((replay.least - 2.0 / MASS * 1e3).abs() < 1e-12);
        // A depth beyond its limit stays at the limit; the motion before the contact does not count.
        replay.push(&along);
        assert_eq!((replay.pushes[0], replay.reported), (LARGEST_MM_S2, 0.0));
        replay.push(&along);
        assert_eq!(replay.reported, -DEEPEST_MM);
    }

    /// A spring that is a third too soft leaves a third of the load.
    #[test]
    fn the_misfit_is_the_part_of_the_load_that_is_not_explained() {
        let bounce = bounces()[0];
        let mut last = 0.0;
        // The surface is such that the mean of the loads is explained.
        bounce.follow(&bounce.settings(2.0 / 3.0, false), 0, 36, |_, replay| {
            last = replay.misfit()
        });
        assert!((0.1..0.2).contains(&last), "{last}");
    }

    /// The age of the onset is that of a first sample at this depth. The model was slowed already by κ Ts times the depths in
    /// between, a quarter of its speed at most. More than eight cycles do not count as an onset.
    #[test]
    fn the_onset_is_as_old_as_the_first_depth_says() {
        let slowed = 441.0 * CYCLE_S * CYCLE_S * 2.6 * 3.6 / 2.0;
        for (stiffness, cycles, approach, onset) in [
            (441.0, -1.0, 1.0, 0.0),
            (441.0, 0.9, 1.0, 0.9),
            (441.0, 3.6, 1.0 + slowed, 3.6 / (1.0 + slowed)),
            (1e4, 6.0, 1.25, 6.0 / 1.25),
            (
                441.0,
                7.9,
                1.0 + 441.0 * CYCLE_S * CYCLE_S * 6.9 * 7.9 / 2.0,
                6.6258,
            ),
            (441.0, 8.1, 1.0, 8.0),
            (441.0, 50.0, 1.0, 8.0),
        ] {
            let mut replay = Replay::<f64>::new(0, CYCLE_S);
            (replay.entry, replay.lead) = (5.0, LEAD);
            replay.pushes[0] = stiffness * cycles * 5.0 * CYCLE_S;
            replay.begin(&Spring::new(stiffness, 0.0, 1e-6, false));
            assert!(
                (replay.approach() / 5.0 - approach).abs() < 1e-9,
                "{cycles}: {}",
                replay.approach()
            );
            let found = replay.head - LEAD;
            assert!((found - onset).abs() < 1e-3, "{cycles}: {found}");
        }
    }
}
