//! The control cycle: sensor sample and robot telegram in, motion of the robot out.

use crate::checked::Checked;
use crate::cost::{Phase, Probe};
use crate::dynamics::{BodyState, Observation, ObservationFrames, TwoBody, TwoBodyState};
use crate::frames::{self, Pose, Wrench, pose_components, pose_from_components};
use crate::health::{Health, plausible};
use crate::io::{BodyTrace, Inputs, Motion, Output, RobotSample, Sequence, Trace};
use crate::jog::{Jog, JogRun, has_room};
use crate::limits::{LimitFlags, load_beyond};
use crate::modes::{Command, Fault, FaultCode, Mode, Modes, Readiness, Refusal};
use crate::robot::RobotInterface;
use crate::run::{LoopInput, Plan, Run};
use crate::scalar::Scalar;
use crate::settings::Settings;
use crate::wrench::{Compensated, Compensation, MotionEstimator};
use crate::zero::RestMean;

/// Largest force (N) and torque (N·m) that is taken from the sensor. A larger reading saturates here; that is ten times the
/// largest overload limit, so it is an overload in any case.
const LARGEST_READING: f64 = 1.0e6;

/// The controller: settings ready to run, and state.
#[derive(Clone, Debug)]
pub struct Cycle<S: Scalar> {
    settings: Settings,
    robot: RobotInterface,
    compensation: Compensation<S>,
    observers: ObservationFrames<S>,
    plan: Plan<S>,
    health: Health,
    modes: Modes,
    estimator: MotionEstimator<S>,
    rest_mean: RestMean<S>,
    run: Run<S>,
    jog: Option<JogRun>,
    /// Measured pose of M when the robot began.
    box_center: Option<Pose<S>>,
    /// The robot is asked to stop.
    stop: bool,
    cycle: u64,
}

impl<S: Scalar> Cycle<S> {
    /// Builds the controller in mode Idle.
    #[inline(always)] // or each level would hold a copy of the law on the stack
    pub fn new(Checked { settings, robot }: Checked) -> Self {
        let sensor = &settings.sensor;
        Self {
            compensation: Compensation::new(sensor),
            observers: ObservationFrames::new(&settings.frames),
            plan: Plan::new(&settings, &robot),
            health: Health::new(&settings),
            modes: Modes::default(),
            estimator: MotionEstimator::new(sensor.acceleration_bandwidth_hz, robot.cycle_s),
            rest_mean: RestMean::new(),
            run: Run::new(&settings, &Pose::identity(), &Pose::identity()),
            jog: None,
            box_center: None,
            stop: false,
            cycle: 0,
            robot,
            settings,
        }
    }

    /// One cycle. The caller must answer before the robot's next telegram, as a later answer is rejected.
    pub fn step(&mut self, inputs: &Inputs) -> (Output, Trace) {
        let mut trace = Trace::default();
        let output = self.step_counted(inputs, &mut trace, &mut ());
        (output, trace)
    }

    /// [`Self::step`] that reports finished phases to `probe`. `trace` must be new; it is filled in place, as returning it would
    /// cost a microcontroller more than any other part of the cycle.
    pub fn step_counted(
        &mut self,
        inputs: &Inputs,
        trace: &mut Trace,
        probe: &mut impl Probe,
    ) -> Output {
        trace.cycle = self.cycle;
        trace.time_s = self.cycle as f64 * self.settings.robot.cycle_s;
        self.cycle += 1;

        // Check.
        self.follow_sequence(inputs.robot.sequence);
        let guarded = self.guarded();
        let fault = self.health.check(inputs, self.modes.mode(), guarded);

        // Compensate.
        let pose = self.measured_pose(&inputs.robot);
        let wrench = self.compensated(inputs, &pose, trace);
        probe.finished(Phase::Wrench);

        // Obey and judge.
        let start = self.obey(inputs, &pose, &wrench.at_m, trace);
        if let Some(fault) = fault.or_else(|| self.load_fault(&wrench.at_m)) {
            self.latch(fault);
        }

        // Integrate, compensate the delay, limit.
        let moved = self.moved(&inputs.robot, &pose, &wrench.at_m, trace, probe);
        let output = Output {
            start,
            motion: self.motion(moved),
            stop: self.stop,
        };
        probe.finished(Phase::Limits);

        // Log.
        self.finish(inputs, trace);
        probe.finished(Phase::Trace);
        output
    }

    /// Moves as the mode requires. Returns whether the robot moves; `false`: it is to rest.
    fn moved(
        &mut self,
        robot: &RobotSample,
        measured: &Pose<S>,
        wrench: &Wrench<S>,
        trace: &mut Trace,
        probe: &mut impl Probe,
    ) -> Result<bool, Fault> {
        match self.modes.mode() {
            Mode::Running => {
                let input = LoopInput {
                    wrench,
                    measured,
                    freeze: self.freeze(robot),
                };
                let sent = self.run.step(&self.plan, &input, trace, probe);
                sent.map(|()| true)
            }
            Mode::Jogging => self.jog_on(robot, trace),
            Mode::Idle | Mode::Hold | Mode::Armed => self.run.fade_out(&self.plan, trace),
            Mode::Fault => Ok(false),
        }
    }

    /// The present mode.
    pub fn mode(&self) -> Mode {
        self.modes.mode()
    }

    /// The latched fault.
    pub fn fault(&self) -> Option<Fault> {
        self.modes.fault()
    }

    /// Poses and relative velocity of the docking surfaces J (= N) and P, at any time.
    pub fn observe(&self) -> Observation<S> {
        self.observers.observe(&self.run.state)
    }

    /// The two simulated spacecraft and their motion.
    pub fn bodies(&self) -> (&TwoBody<S>, &TwoBodyState<S>) {
        (&self.plan.bodies, &self.run.state)
    }

    /// A restarted robot has forgotten all commands, so that a start pose taken before is invalid.
    fn follow_sequence(&mut self, sequence: Sequence) {
        if sequence != Sequence::NewRun {
            return;
        }
        self.estimator.reset();
        self.rest_mean = RestMean::new();
        self.box_center = None;
        // The stop has been carried out; this run must be able to begin.
        self.stop = false;
        if !self.modes.mode().moves() {
            self.run.halt();
        }
        if self.modes.mode() == Mode::Armed {
            // Stop is always allowed in Armed, so the result is ignored.
            let _ = self.modes.command(Command::Stop, Ok(()));
        }
    }

    /// The robot is moved by this controller, or may be in the next cycle.
    fn guarded(&self) -> bool {
        self.modes.mode() == Mode::Armed || self.in_motion()
    }

    /// The robot is moved by this controller.
    fn in_motion(&self) -> bool {
        self.modes.mode().moves() || self.run.last_sent != frames::Twist::zero()
    }

    /// The telegram's pose, or the last good one if it has none. Also updates the estimator and the centre of the box.
    fn measured_pose(&mut self, robot: &RobotSample) -> Pose<S> {
        let cycles = match robot.sequence {
            Sequence::Gap(lost) => lost.saturating_add(1),
            Sequence::Next | Sequence::NewRun => 1,
        };
        let pose = robot.pose.filter(plausible);
        let pose = pose.map(|pose| pose_from_components(&pose));
        self.estimator.update(pose.as_ref(), cycles);
        let pose = self.estimator.last_pose();
        // The first telegrams of a run may have no pose.
        if self.estimator.has_pose() {
            self.box_center.get_or_insert(pose);
        }
        pose
    }

    fn compensated(
        &mut self,
        inputs: &Inputs,
        pose: &Pose<S>,
        trace: &mut Trace,
    ) -> Compensated<S> {
        let motion = self.estimator.motion();
        // Readings that are not finite have caused a fault already; they must not reach the running mean.
        let finite = inputs.sensor.wrench.iter().all(|v| v.is_finite());
        let limit = LARGEST_READING;
        let raw = inputs.sensor.wrench.map(|v| match finite {
            true => v.clamp(-limit, limit),
            false => 0.0,
        });
        let wrench = self
            .compensation
            .compensate(&Wrench::of(&raw), &pose.rotation, &motion);
        if self.in_motion() || self.plan.overload(&wrench.at_m).is_some() {
            // A contact is not a reading at rest; and one sample of an overload would shift the mean by a 64th of it.
            self.rest_mean = RestMean::new();
        } else if self.health.good_sample(inputs) {
            self.rest_mean.push(&wrench.contact_in_s);
        }

        trace.pose = pose_components(pose);
        trace.executed_velocity = self.estimator.raw_velocity().get();
        trace.sensor_age = self.health.sensor_age();
        trace.wrench_at_m = wrench.at_m.get();
        trace.removed = (wrench.gravity + wrench.inertial).get();
        wrench
    }

    /// Carries out the operator's command, or records the refusal. Returns whether displacements restart from the present pose.
    fn obey(
        &mut self,
        inputs: &Inputs,
        pose: &Pose<S>,
        at_m: &Wrench<S>,
        trace: &mut Trace,
    ) -> bool {
        let Some(command) = inputs.command else {
            return false;
        };
        let ready = self.ready(command, inputs, pose, at_m);
        if let Err(refusal) = self.modes.command(command, ready) {
            trace.refusal = Some(refusal);
            return false;
        }
        match command {
            Command::Arm => self.take_start_pose(pose),
            Command::Jog(jog) => self.begin_jog(jog, pose),
            Command::Zero => {
                let mean = self.rest_mean.get().unwrap_or_else(Wrench::zero);
                self.compensation.shift_bias(&mean);
                self.rest_mean = RestMean::new();
            }
            Command::Reset => self.stop = false,
            Command::Hold | Command::Start | Command::Stop => {}
        }
        matches!(command, Command::Arm | Command::Jog(_))
    }

    /// Takes this pose as the start from which displacements count.
    fn take_start_pose(&mut self, pose: &Pose<S>) {
        let center = self.box_center.unwrap_or(*pose);
        self.run.restart(&self.settings, pose, &center);
    }

    /// Whether the present data allow a command.
    fn ready(
        &self,
        command: Command,
        inputs: &Inputs,
        pose: &Pose<S>,
        at_m: &Wrench<S>,
    ) -> Readiness {
        self.health.ready(inputs)?;
        if self.run.last_sent != frames::Twist::zero() {
            return Err(Refusal::StillMoving);
        }
        if command == Command::Zero {
            return self.zero_allowed();
        }
        if self.too_large_for_start(at_m).is_some() {
            return Err(Refusal::ForceTooLarge);
        }
        match command {
            Command::Start if self.run.moved_since_armed(pose) => Err(Refusal::MovedSinceArmed),
            Command::Jog(jog) => self.jog_allowed(jog, pose),
            _ => Ok(()),
        }
    }

    /// A zero needs a mean of enough samples, and must not hide a contact.
    fn zero_allowed(&self) -> Readiness {
        let start = &self.settings.start;
        let (force, torque) = (
            S::of(start.max_zero_force_n),
            S::of(start.max_zero_torque_n_m),
        );
        match self.rest_mean.get() {
            None => Err(Refusal::TooFewSamples),
            Some(mean) if load_beyond(&mean, force, torque).is_some() => {
                Err(Refusal::ForceTooLarge)
            }
            Some(_) => Ok(()),
        }
    }

    /// Whether a jog may begin at this pose.
    fn jog_allowed(&self, jog: Jog, pose: &Pose<S>) -> Readiness {
        let center = self.box_center.unwrap_or(*pose);
        let gimbal_lock = self.robot.gimbal_lock.as_ref();
        match has_room(
            (&self.settings.jog, &self.settings.limits),
            gimbal_lock,
            jog,
            pose,
            &center,
        ) {
            true => Ok(()),
            false => Err(Refusal::NoRoom),
        }
    }

    /// Displacements count from this pose, and the jog begins with the present cycle.
    fn begin_jog(&mut self, jog: Jog, pose: &Pose<S>) {
        self.take_start_pose(pose);
        self.jog = Some(JogRun::new(
            &self.settings.jog,
            jog,
            self.settings.robot.cycle_s,
        ));
    }

    /// The next cycle of a jog; after its end the robot holds.
    fn jog_on(&mut self, robot: &RobotSample, trace: &mut Trace) -> Result<bool, Fault> {
        let freeze = self.freeze(robot);
        if let Some(velocity) = self.jog.as_mut().and_then(JogRun::next_velocity) {
            let sent = self.run.jog(&self.plan, &velocity, freeze, trace);
            return sent.map(|()| true);
        }
        self.modes.end_jog();
        self.run.fade_out(&self.plan, trace)
    }

    /// The load if it is too large for a start: (limit, value).
    fn too_large_for_start(&self, at_m: &Wrench<S>) -> Option<(f64, f64)> {
        let start = &self.settings.start;
        load_beyond(at_m, S::of(start.max_force_n), S::of(start.max_torque_n_m))
    }

    /// Faults of the load: contact while the start ramp runs, or overload.
    fn load_fault(&self, at_m: &Wrench<S>) -> Option<Fault> {
        if self.modes.mode() == Mode::Running
            && self.run.starting(&self.plan)
            && let Some((limit, load)) = self.too_large_for_start(at_m)
        {
            return Some(Fault::new(FaultCode::ContactAtStart, limit, load));
        }
        if self.guarded() {
            self.plan.overload(at_m)
        } else {
            None
        }
    }

    /// Latches a fault; an overload may also ask the robot to stop, until its next run.
    fn latch(&mut self, fault: Fault) {
        let overload = fault.code == FaultCode::Overload && self.modes.fault().is_none();
        self.stop |= overload && self.settings.limits.stop_on_overload;
        self.modes.latch(fault);
    }

    /// Reasons not to integrate in this cycle.
    fn freeze(&self, robot: &RobotSample) -> LimitFlags {
        let mut flags = LimitFlags::default();
        if self.health.stale() {
            flags.set(LimitFlags::SENSOR_STALE);
        }
        if robot.clamped {
            flags.set(LimitFlags::ROBOT_CLAMP);
        }
        flags
    }

    /// The commanded pose if the robot moves; else it is halted. An error is latched as a fault.
    fn motion(&mut self, moved: Result<bool, Fault>) -> Motion {
        let moved = moved.unwrap_or_else(|fault| {
            self.latch(fault);
            false
        });
        if moved {
            return self.run.motion(&self.plan);
        }
        self.run.halt();
        Motion::Rest
    }

    fn finish(&self, inputs: &Inputs, trace: &mut Trace) {
        let taken_at_edge = |v: &f64| v.is_nan() || v.abs() > LARGEST_READING;
        if self.estimator.saturates() || inputs.sensor.wrench.iter().any(taken_at_edge) {
            trace.limits.set(LimitFlags::MEASURED);
        }
        let body = |state: &BodyState<S>| BodyTrace {
            pose: pose_components(&state.c_from_body),
            velocity: state.velocity.get(),
        };
        trace.mode = self.modes.mode();
        trace.fault = self.modes.fault();
        trace.body_k = body(&self.run.state.k);
        trace.body_q = body(&self.run.state.q);
        let seen = self.observe();
        trace.docking = BodyTrace {
            pose: pose_components(&seen.p_from_j),
            velocity: seen.relative_velocity.get(),
        };
        trace.sent_velocity = self.run.last_sent.get();
        trace.command_pose = self.run.command_pose(&self.plan);
    }
}

#[cfg(test)]
mod tests;
