//! The closed loop: from the contact wrench to the velocity that is sent and the commanded pose.
//!
//! A [`Run`] is restarted by each `arm` and each jog. Its phases: zero cycles, a ramp in which both spacecraft glide with their
//! initial velocities, then motion under the felt wrench; after a stop, the last velocity fades out.

use crate::cost::{Phase, Probe};
use crate::delay::guarded::Guarded;
use crate::delay::{LawInput, LawOutput, ModelVelocity, SentHistory};
use crate::dynamics::{BodyState, TwoBody, TwoBodyState, advanced, relative_velocity};
use crate::frames::{self, Pose, Twist, Wrench};
use crate::io::{Motion, Trace};
use crate::limits::{LimitFlags, Limits};
use crate::modes::{Fault, FaultCode};
use crate::robot::{GimbalLock, RobotInterface};
use crate::scalar::Scalar;
use crate::settings::Settings;
use crate::sum::VelocitySum;
use nalgebra::{UnitQuaternion, Vector3};

/// Distance and angle by which the robot may differ from its pose when armed: beyond the noise of
/// any robot, below what would matter for the first cycle.
const MOVED_M: f64 = 1e-3;
const MOVED_RAD: f64 = 2e-3;

/// Fixed parts of the loop, built once from the settings.
#[derive(Clone, Debug)]
pub(crate) struct Plan<S: Scalar> {
    pub(crate) bodies: TwoBody<S>,
    limits: Limits<S>,
    ts: S,
    cycle_s: f64,
    model_velocity: ModelVelocity,
    zero_cycles: u32,
    ramp_cycles: u32,
    stop_cycles: u32,
    clamp_fault_cycles: u32,
    /// The gimbal lock and the largest sine that is allowed.
    gimbal_lock: Option<(GimbalLock, S)>,
    /// Fraction of the rate by which it falls in a frozen cycle, and rises again in others.
    authority_step: S,
}

/// Input of a cycle of the loop.
pub(crate) struct LoopInput<'a, S: Scalar> {
    /// Contact wrench at M, axes of M.
    pub(crate) wrench: &'a Wrench<S>,
    /// Measured pose of M in C.
    pub(crate) measured: &'a Pose<S>,
    /// Reasons not to integrate.
    pub(crate) freeze: LimitFlags,
}

/// State of a closed loop.
#[derive(Clone, Debug)]
pub(crate) struct Run<S: Scalar> {
    pub(crate) state: TwoBodyState<S>,
    /// Velocity sent in the last cycle.
    pub(crate) last_sent: Twist<S>,
    /// Sum of the velocities sent since the start, axes of C: times the cycle it is the commanded translation.
    travelled: VelocitySum<S>,
    /// That translation, m.
    displacement: Vector3<S>,
    /// Commanded orientation of M in C.
    pub(crate) orientation: UnitQuaternion<S>,
    law: Guarded<S>,
    sent: SentHistory<S>,
    /// The law's command in the last cycle in which the model was integrated.
    held: Twist<S>,
    /// Velocity of K seen from Q at the end of the last cycle, in the laboratory.
    last_relative: Twist<S>,
    /// Orientation of Q in the laboratory; Q stands still there.
    c_from_q: UnitQuaternion<S>,
    /// Measured pose of M when armed.
    start: Pose<S>,
    /// Measured pose of M when the robot began: the box is around it, as the robot's own limits are.
    box_center: Pose<S>,
    /// Cycles since the start.
    cycles: u32,
    /// Fraction of the rate that is sent: 1, less while the model is frozen and for some cycles after that.
    authority: S,
    /// Cycles in a row in which a limit acted.
    clamped_cycles: u32,
    /// Velocity taken away per cycle while a stop fades out, and the cycles left.
    fade: (Twist<S>, u32),
}

impl<S: Scalar> Plan<S> {
    /// From validated settings.
    pub(crate) fn new(settings: &Settings, robot: &RobotInterface) -> Self {
        let (cycle_s, start) = (settings.robot.cycle_s, &settings.start);
        let grace = settings.sensor.fault_after_cycles - settings.sensor.stale_after_cycles;
        Self {
            bodies: TwoBody::new(&settings.body_k, &settings.body_q, cycle_s),
            limits: Limits::new(&settings.limits, cycle_s),
            ts: S::of(cycle_s),
            cycle_s,
            model_velocity: settings.delay.model_velocity,
            zero_cycles: start.zero_cycles,
            ramp_cycles: start.ramp_cycles,
            stop_cycles: ((start.stop_time_s / cycle_s + 0.5) as u32).max(1),
            clamp_fault_cycles: settings.limits.clamp_fault_cycles,
            gimbal_lock: robot.gimbal_lock.map(|lock| (lock, lock.largest_sine(0.0))),
            authority_step: S::of(1.0 / f64::from(grace.max(1))),
        }
    }

    /// A fault if the load is beyond its limit.
    pub(crate) fn overload(&self, at_m: &Wrench<S>) -> Option<Fault> {
        let (limit, load) = self.limits.overload(at_m)?;
        Some(Fault::new(FaultCode::Overload, limit, load))
    }
}

impl<S: Scalar> Run<S> {
    /// A run with the operator's initial conditions, at a measured pose of the robot, with the box around another one.
    #[inline(always)] // or each level would hold a copy of the law on the stack
    pub(crate) fn new(settings: &Settings, start: &Pose<S>, box_center: &Pose<S>) -> Self {
        let state = TwoBodyState {
            k: BodyState::initial(&settings.body_k),
            q: BodyState::initial(&settings.body_q),
        };
        let mut run = Self {
            state,
            last_sent: Twist::zero(),
            travelled: VelocitySum::zero(),
            displacement: Vector3::zeros(),
            orientation: start.rotation,
            law: Guarded::new(&settings.delay, settings.robot.cycle_s),
            sent: SentHistory::new(),
            held: Twist::zero(),
            last_relative: Twist::zero(),
            c_from_q: start.rotation * state.q_from_k().rotation.inverse(),
            start: *start,
            box_center: *box_center,
            cycles: 0,
            authority: S::one(),
            clamped_cycles: 0,
            fade: (Twist::zero(), 0),
        };
        run.last_relative = run.relative();
        run
    }

    /// Resets to the state of [`Self::new`] in place: a second state of the law would be too large for the stack of a
    /// microcontroller.
    #[inline(never)]
    pub(crate) fn restart(&mut self, settings: &Settings, start: &Pose<S>, center: &Pose<S>) {
        // All fields by name, so that a new one cannot be forgotten.
        let Self {
            state,
            last_sent,
            travelled,
            displacement,
            orientation,
            law,
            sent,
            held,
            last_relative: _,
            c_from_q,
            start: started,
            box_center,
            cycles,
            authority,
            clamped_cycles,
            fade,
        } = self;
        *state = TwoBodyState {
            k: BodyState::initial(&settings.body_k),
            q: BodyState::initial(&settings.body_q),
        };
        *last_sent = Twist::zero();
        *travelled = VelocitySum::zero();
        *displacement = Vector3::zeros();
        *orientation = start.rotation;
        law.restart(&settings.delay, settings.robot.cycle_s);
        sent.clear();
        *held = Twist::zero();
        *c_from_q = start.rotation * state.q_from_k().rotation.inverse();
        *started = *start;
        *box_center = *center;
        *cycles = 0;
        *authority = S::one();
        *clamped_cycles = 0;
        *fade = (Twist::zero(), 0);
        self.last_relative = self.relative();
    }

    /// Whether the start ramp still runs: no contact is allowed in it.
    pub(crate) fn starting(&self, plan: &Plan<S>) -> bool {
        self.cycles < plan.zero_cycles + plan.ramp_cycles
    }

    /// Commanded pose of M in C: position (m, without the rounding of the scalar), quaternion.
    pub(crate) fn command_pose(&self, plan: &Plan<S>) -> [f64; 7] {
        let [x, y, z] = frames::components(&self.start.translation.vector);
        let ([dx, dy, dz], q) = (self.displacement_m(plan), &self.orientation);
        let [w, i, j, k] = [q.w, q.i, q.j, q.k].map(S::get);
        [x + dx, y + dy, z + dz, w, i, j, k]
    }

    /// What the robot shall do now.
    pub(crate) fn motion(&self, plan: &Plan<S>) -> Motion {
        let q = &self.orientation;
        Motion::Move {
            displacement_m: self.displacement_m(plan),
            orientation_wxyz: [q.w, q.i, q.j, q.k].map(S::get),
            velocity: self.last_sent.get(),
        }
    }

    /// Commanded translation since the start, m, axes of C, without the rounding of the scalar.
    fn displacement_m(&self, plan: &Plan<S>) -> [f64; 3] {
        self.travelled.translation_m(plan.cycle_s)
    }

    /// One cycle: integrate, ask the delay law, limit, move the commanded pose.
    pub(crate) fn step(
        &mut self,
        plan: &Plan<S>,
        input: &LoopInput<'_, S>,
        trace: &mut Trace,
        probe: &mut impl Probe,
    ) -> Result<(), Fault> {
        let frozen = input.freeze != LimitFlags::default();
        let share = self.start_share(plan);
        let mut flags = input.freeze;
        if !frozen {
            self.integrate(plan, input, share, trace);
            if self.state.at_its_limits() {
                flags.set(LimitFlags::MODEL);
            }
        }
        let model = self.model_velocity(plan);
        probe.finished(Phase::Dynamics);
        let law = self.ask(plan, input, model, |law, seen| law.step(seen));
        probe.finished(Phase::Law);
        let authority = self.next_authority(plan, frozen);
        self.cycles = self.cycles.saturating_add(1);
        write_trace(trace, &model, &law);
        if let Some(fault) = law.fault {
            return Err(fault);
        }
        // A frozen model has a kink in its velocity, from which a law that extrapolates would make a jump.
        if !frozen {
            self.held = law.command;
        }
        self.send(plan, self.held * (share * authority), flags, trace)
    }

    /// After the loop was opened: the last velocity fades out at constant deceleration, over more than the stop time if the
    /// limits do not allow that deceleration. Returns `false` at rest.
    pub(crate) fn fade_out(&mut self, plan: &Plan<S>, trace: &mut Trace) -> Result<bool, Fault> {
        let (step, left) = match self.fade {
            (_, 0) if self.last_sent == Twist::zero() => return Ok(false),
            (_, 0) => {
                let least = plan.limits.cycles_to_rest(&self.last_sent);
                let cycles = plan.stop_cycles.max(least);
                (self.last_sent * S::of(1.0 / f64::from(cycles)), cycles)
            }
            fade => fade,
        };
        self.fade = (step, left - 1);
        let command = if left == 1 {
            Twist::zero()
        } else {
            self.last_sent - step
        };
        // A fault by a sustained clamp would end the stop at once, with the jump that the fade avoids.
        self.clamped_cycles = 0;
        self.send(plan, command, LimitFlags::default(), trace)?;
        if trace.limits != LimitFlags::default() && left > 1 {
            // The limits have taken away velocity: with the steps as planned the motion would reverse.
            self.fade.0 = self.last_sent * S::of(1.0 / f64::from(left - 1));
        }
        Ok(true)
    }

    /// Whether something other than the loop has moved the robot since it was armed.
    pub(crate) fn moved_since_armed(&self, measured: &Pose<S>) -> bool {
        let distance = (measured.translation.vector - self.start.translation.vector).amax();
        let turn = (self.start.rotation.inverse() * measured.rotation)
            .imag()
            .amax();
        distance > S::of(MOVED_M) || turn * S::of(2.0) > S::of(MOVED_RAD)
    }

    /// Stops at once.
    pub(crate) fn halt(&mut self) {
        self.last_sent = Twist::zero();
        self.fade.1 = 0;
    }

    /// Share of the initial velocity in this cycle: zero, then a ramp, then 1.
    fn start_share(&self, plan: &Plan<S>) -> S {
        let since = self.cycles.saturating_sub(plan.zero_cycles);
        S::of((f64::from(since) / f64::from(plan.ramp_cycles)).min(1.0))
    }

    /// Moves both spacecraft: in the ramp they glide, then they move under the wrench that the law lets them feel.
    fn integrate(&mut self, plan: &Plan<S>, input: &LoopInput<'_, S>, share: S, trace: &mut Trace) {
        if share < S::one() {
            for body in [&mut self.state.k, &mut self.state.q] {
                body.c_from_body = advanced(&body.c_from_body, &(body.velocity * share), plan.ts);
            }
            return;
        }
        let model = self.last_relative;
        let felt = self.ask(plan, input, model, |law, seen| law.condition(seen));
        trace.unaccounted_impulse = (felt - *input.wrench).get().map(|part| part * plan.cycle_s);
        self.state = plan.bodies.step(&self.state, &felt).0;
    }

    /// Calls the law with its input as it is at present.
    fn ask<T>(
        &mut self,
        plan: &Plan<S>,
        input: &LoopInput<'_, S>,
        model: Twist<S>,
        question: impl FnOnce(&mut Guarded<S>, &LawInput<'_, S>) -> T,
    ) -> T {
        let commanded = Pose::from_parts(
            (self.start.translation.vector + self.displacement).into(),
            self.orientation,
        );
        let seen = LawInput {
            model,
            model_end: self.last_relative,
            wrench: input.wrench,
            measured: input.measured,
            commanded: &commanded,
            sent: &self.sent,
            bodies: &plan.bodies,
            state: &self.state,
            c_from_q: self.c_from_q,
            released: self.start_share(plan) >= S::one(),
            frozen: input.freeze != LimitFlags::default(),
        };
        question(&mut self.law, &seen)
    }

    fn model_velocity(&mut self, plan: &Plan<S>) -> Twist<S> {
        let relative = self.relative();
        let before = core::mem::replace(&mut self.last_relative, relative);
        match plan.model_velocity {
            ModelVelocity::Mean => (before + relative) * S::of(0.5),
            ModelVelocity::End => relative,
        }
    }

    /// Velocity of K seen from Q, with the linear part turned into C of the laboratory.
    fn relative(&self) -> Twist<S> {
        let relative = relative_velocity(&self.state.k, &self.state.q);
        Twist {
            linear: self.c_from_q * relative.linear,
            angular: relative.angular,
        }
    }

    /// The commanded orientation of the next cycle. A rotation towards the gimbal lock of the robot's angles is suppressed, as at
    /// the edge of the box.
    fn next_orientation(
        &self,
        plan: &Plan<S>,
        sent: &mut Twist<S>,
        flags: &mut LimitFlags,
    ) -> UnitQuaternion<S> {
        let turned = |angular: Vector3<S>| {
            frames::rotated(&self.orientation, &frames::scaled(&angular, plan.ts))
        };
        let next = turned(sent.angular);
        let Some((lock, largest)) = &plan.gimbal_lock else {
            return next;
        };
        let sine = lock.sine(&next);
        if sine > *largest && sine > lock.sine(&self.orientation) {
            sent.angular = Vector3::zeros();
            flags.set(LimitFlags::BOX);
            return turned(sent.angular);
        }
        next
    }

    fn send(
        &mut self,
        plan: &Plan<S>,
        command: Twist<S>,
        reasons: LimitFlags,
        trace: &mut Trace,
    ) -> Result<(), Fault> {
        let turn = self.box_center.rotation.inverse() * self.orientation;
        let offset = self.start.translation.vector - self.box_center.translation.vector;
        let displacement = offset + self.displacement;
        let (mut sent, mut flags) =
            plan.limits
                .apply(&command, &self.last_sent, &displacement, &turn);
        let orientation = self.next_orientation(plan, &mut sent, &mut flags);
        flags.set(reasons);
        trace.limits = flags;
        if !sent.get().iter().all(|v| v.is_finite()) {
            return Err(Fault::new(FaultCode::Numeric, 0.0, 0.0));
        }
        // A stale sensor has a fault of its own.
        let clamped = flags.without(LimitFlags::SENSOR_STALE) != LimitFlags::default();
        self.clamped_cycles = if clamped {
            self.clamped_cycles.saturating_add(1)
        } else {
            0
        };
        if self.clamped_cycles > plan.clamp_fault_cycles {
            let (most, count) = (plan.clamp_fault_cycles, self.clamped_cycles);
            return Err(Fault::new(
                FaultCode::SustainedClamp,
                most.into(),
                count.into(),
            ));
        }
        self.travelled.add(&sent.linear);
        self.displacement = self.travelled.translation(plan.ts);
        self.orientation = orientation;
        self.last_sent = sent;
        self.sent.write(sent);
        Ok(())
    }

    /// Sends this velocity, without model and delay law. With a reason in `freeze` the last velocity is sent instead, at a
    /// falling rate as in a closed loop, as a jog may jump from one velocity to the next.
    pub(crate) fn jog(
        &mut self,
        plan: &Plan<S>,
        velocity: &Twist<S>,
        freeze: LimitFlags,
        trace: &mut Trace,
    ) -> Result<(), Fault> {
        let frozen = freeze != LimitFlags::default();
        if !frozen {
            self.held = *velocity;
        }
        let authority = self.next_authority(plan, frozen);
        self.send(plan, self.held * authority, freeze, trace)
    }

    /// The fraction of the rate that is sent in this cycle: it falls while there is a reason not to integrate, and rises again
    /// otherwise.
    fn next_authority(&mut self, plan: &Plan<S>, frozen: bool) -> S {
        let change = if frozen {
            -plan.authority_step
        } else {
            plan.authority_step
        };
        self.authority = (self.authority + change).clamp(S::zero(), S::one());
        self.authority
    }
}

fn write_trace<S: Scalar>(trace: &mut Trace, model: &Twist<S>, law: &LawOutput<S>) {
    trace.model_velocity = model.get();
    trace.law_velocity = law.command.get();
    trace.law_parts = law.parts.map(|part| part.get());
    trace.law_status = law.status;
}
