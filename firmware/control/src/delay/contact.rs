//! The direction of a contact, and force and motion along it.
//!
//! The measured wrench itself tells the direction: its force and its lever, averaged over some
//! cycles. Along a contact a law works with numbers instead of vectors, in any pose and for two
//! free spacecraft. A contact opens when the force exceeds a threshold while they approach, and is
//! followed until the force is gone and the law lets it close. A load that is a torque alone is no contact here.

use super::LawInput;
use super::actuator::ActuatorSettings;
use super::status::{LawFlags, LawStatus};
use crate::frames::{Pose, Twist, Wrench};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Of the averaged wrench, per cycle: ten cycles of memory.
const FORGETTING_FACTOR: f64 = 0.9;
/// Largest force along a contact that a law deals with, N.
const LARGEST_N: f64 = 1e5;
/// Largest lever, m.
const LONGEST_M: f64 = 1e2;
/// Cycles below the threshold after which a contact is over: an impact's force may cross zero in between.
const QUIET_CYCLES: u32 = 8;
/// Latencies of the reported pose that are made up for, cycles.
pub(super) const LATENCIES: usize = 9;

/// The line of a contact and what is needed to follow it.
#[derive(Clone, Debug)]
pub(super) struct ContactLine<S: Scalar> {
    threshold: S,
    latency: usize,
    /// Sum of the wrench that forgets.
    average: Wrench<S>,
    /// Force part of length 1, along the push of the surface; axes of M.
    direction: Wrench<S>,
    /// Measured pose of the last cycle.
    last_pose: Option<Pose<S>>,
    /// Loads of the last cycles, newest first.
    loads: [S; LATENCIES],
    open: bool,
    quiet_cycles: u32,
}

/// A cycle of a contact, seen along its direction. Away from the surface is positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Along<S: Scalar> {
    /// The contact opened in this cycle.
    pub(super) opened: bool,
    /// Force, N.
    pub(super) load: S,
    /// Force when the reported pose was true, N.
    pub(super) load_then: S,
    /// Measured motion since the last cycle, m.
    pub(super) moved: S,
    /// Velocity of the model before this cycle's wrench, m/s.
    pub(super) velocity: S,
    /// Change of velocity per impulse: inverse of the mass that the contact feels, 1/kg.
    pub(super) mobility: S,
}

impl<S: Scalar> ContactLine<S> {
    /// `threshold_n` is the force that opens a contact, N.
    pub(super) fn new(threshold_n: f64, actuator: &ActuatorSettings) -> Self {
        Self {
            threshold: S::of(threshold_n),
            latency: usize::from(actuator.feedback_latency_cycles).min(LATENCIES - 1),
            average: Wrench::zero(),
            direction: Wrench::zero(),
            last_pose: None,
            loads: [S::zero(); LATENCIES],
            open: false,
            quiet_cycles: 0,
        }
    }

    /// Takes a cycle in; an open contact's numbers.
    pub(super) fn update(&mut self, input: &LawInput<'_, S>) -> Option<Along<S>> {
        let before = self.last_pose.replace(*input.measured);
        self.average = self.average * S::of(FORGETTING_FACTOR) + *input.wrench;
        let force = length(&input.wrench.force);
        let mut opened = false;
        if force >= self.threshold {
            self.quiet_cycles = 0;
            self.turn();
            opened = !self.open && self.velocity(input) < S::zero();
            self.open |= opened;
            if opened {
                self.loads = [S::zero(); LATENCIES];
            }
        } else {
            self.quiet_cycles = self.quiet_cycles.saturating_add(1);
        }
        if !self.open {
            self.average = Wrench::zero();
            return None;
        }
        Some(self.along(input, before, opened))
    }

    /// Whether a contact is open.
    pub(super) fn is_open(&self) -> bool {
        self.open
    }

    /// What every law along a contact says of itself: whether one is open.
    pub(super) fn status(&self) -> LawStatus {
        let mut status = LawStatus::default();
        if self.open {
            status.flags.set(LawFlags::CONTACT);
        }
        status
    }

    /// The contact is over if the force has long been below the threshold.
    pub(super) fn close_when_quiet(&mut self) {
        self.close_after(QUIET_CYCLES);
    }

    /// The contact is over if the force has been below the threshold for more cycles than that.
    pub(super) fn close_after(&mut self, cycles: u32) {
        if self.quiet_cycles > cycles {
            self.open = false;
            self.average = Wrench::zero();
        }
    }

    /// A force along the contact as a wrench at M, axes of M.
    pub(super) fn wrench(&self, force: S) -> Wrench<S> {
        self.direction * force
    }

    /// The part of a wrench that acts along the contact, N.
    pub(super) fn load(&self, wrench: &Wrench<S>) -> S {
        saturated(self.direction.force.dot(&wrench.force), LARGEST_N)
    }

    /// The part of a motion that goes along the contact; linear in C, angular in M.
    pub(super) fn part(&self, motion: &Twist<S>, input: &LawInput<'_, S>) -> S {
        let linear = input.measured.rotation.inverse() * motion.linear;
        self.direction.force.dot(&linear) + self.direction.torque.dot(&motion.angular)
    }

    /// The motion that a push along the contact gives the spacecraft, per unit along the contact.
    pub(super) fn push(&self, input: &LawInput<'_, S>) -> Twist<S> {
        let answer = input.bodies.mobility(input.state, &self.direction);
        let size = self.dot(&answer);
        if size <= S::zero() {
            return Twist::zero();
        }
        let push = answer * (S::one() / size);
        Twist {
            linear: input.measured.rotation * push.linear,
            angular: push.angular,
        }
    }

    fn velocity(&self, input: &LawInput<'_, S>) -> S {
        self.part(&input.model_end, input)
    }

    /// The direction from the averaged wrench.
    fn turn(&mut self) {
        let force = length(&self.average.force);
        if force < self.threshold * S::of(0.1) {
            return;
        }
        let per_force = S::one() / force;
        let lever = |v: S| saturated(v * per_force, LONGEST_M);
        self.direction = Wrench {
            force: self.average.force * per_force,
            torque: self.average.torque.map(lever),
        };
    }

    fn along(
        &mut self,
        input: &LawInput<'_, S>,
        before: Option<Pose<S>>,
        opened: bool,
    ) -> Along<S> {
        let load = self.load(input.wrench);
        self.loads.rotate_right(1);
        self.loads[0] = load;
        let moved = before.map_or(Twist::zero(), |before| step(&before, input.measured));
        Along {
            opened,
            load,
            load_then: self.loads[self.latency],
            moved: self.part(&moved, input),
            velocity: self.velocity(input),
            mobility: self.dot(&input.bodies.mobility(input.state, &self.direction)),
        }
    }

    fn dot(&self, answer: &Twist<S>) -> S {
        self.direction.force.dot(&answer.linear) + self.direction.torque.dot(&answer.angular)
    }
}

/// Motion from one pose to the next: m in C, rad in the moving axes.
fn step<S: Scalar>(before: &Pose<S>, now: &Pose<S>) -> Twist<S> {
    let turn = before.rotation.inverse() * now.rotation;
    let two = S::of(if turn.w < S::zero() { -2.0 } else { 2.0 });
    Twist {
        linear: now.translation.vector - before.translation.vector,
        angular: Vector3::new(turn.i, turn.j, turn.k) * two,
    }
}

/// Length, scaled by the largest component: squares might leave fixed point.
fn length<S: Scalar>(v: &Vector3<S>) -> S {
    let largest = v.amax();
    if largest <= S::zero() {
        S::zero()
    } else {
        (v / largest).norm() * largest
    }
}

/// A number within ±limit.
pub(super) fn saturated<S: Scalar>(v: S, limit: f64) -> S {
    v.clamp(S::of(-limit), S::of(limit))
}
