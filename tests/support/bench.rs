//! A cycle and an ideal robot that executes every correction. Every cycle is checked: all numbers are finite and within their
//! declared ranges, no correction exceeds its limits, and the robot moves only while the loop is closed or fading out.

use crate::driver::{CycleDriver, idle};
use nalgebra::Vector3;
use softdock_app::record::{CycleRecord, Inputs};
use softdock_control::frames::orientation_from_abc;
use softdock_control::io::{Sequence, Trace};
use softdock_control::limits::LimitFlags;
use softdock_control::modes::{Command, Mode};
use softdock_control::scalar::Scalar;
use softdock_control::settings::{CorrectionMode, Settings};

/// Largest velocity of a spacecraft's model, m/s and rad/s, including the rounding of f32.
const FASTEST: (f64, f64) = (100.001, 20.001);

/// Cycle, robot and checks.
pub struct Bench<S: Scalar> {
    /// The cycle under test.
    pub driver: CycleDriver<S>,
    settings: Settings,
    /// Counts by which the robot is away from its start.
    offset: [i64; 6],
    start: [f64; 6],
    /// Metres and radians per count.
    digit: [f64; 2],
    was_moving: bool,
}

/// The record of a cycle, or what is wrong with it.
pub type Verdict = Result<CycleRecord, String>;

impl<S: Scalar> Bench<S> {
    /// In Idle, with a robot at `start` (m, rad).
    pub fn new(settings: &Settings, start: [f64; 6]) -> Self {
        let decimals = settings.robot.correction_decimals;
        let digit = 0.1_f64.powi(decimals.into());
        Self {
            driver: idle(settings),
            settings: settings.clone(),
            offset: [0; 6],
            start,
            digit: [digit * 1e-3, digit.to_radians()],
            was_moving: false,
        }
    }

    /// Pose of the robot, m and rad.
    pub fn pose(&self) -> [f64; 6] {
        core::array::from_fn(|i| self.start[i] + self.offset[i] as f64 * self.digit[i / 3])
    }

    /// One cycle whose inputs are changed by `change`.
    ///
    /// # Errors
    /// The first failed check.
    pub fn cycle(&mut self, change: impl FnOnce(&mut Inputs)) -> Verdict {
        self.checked(|driver| driver.step_with(change))
    }

    /// One cycle without a new sensor sample.
    ///
    /// # Errors
    /// The first failed check.
    pub fn stale(&mut self) -> Verdict {
        self.checked(|driver| driver.step_stale(|_| {}))
    }

    /// Reset, hold, arm and start in four cycles.
    ///
    /// # Errors
    /// The first failed check.
    pub fn restart(&mut self) -> Result<(), String> {
        [Command::Reset, Command::Hold, Command::Arm, Command::Start]
            .into_iter()
            .try_for_each(|word| self.cycle(|inputs| inputs.command = Some(word)).map(|_| ()))
    }

    fn checked(&mut self, step: impl FnOnce(&mut CycleDriver<S>) -> CycleRecord) -> Verdict {
        let before = self.pose();
        self.driver.inputs.robot.pose = Some(before);
        let record = step(&mut self.driver);
        let new_run = record.inputs.robot.sequence == Sequence::NewRun;
        let step: [i64; 6] = match self.settings.robot.correction_mode {
            CorrectionMode::Relative => record.output.correction,
            CorrectionMode::Absolute => {
                if new_run {
                    self.start = before;
                    self.offset = [0; 6];
                }
                core::array::from_fn(|i| record.output.correction[i] - self.offset[i])
            }
        };
        (0..6).for_each(|i| self.offset[i] += step[i]);
        self.within_limits(&step, &before)?;
        self.moves_only_when_it_may(&record, &step)?;
        sane(&record.trace)?;
        Ok(record)
    }

    /// Checks the limits, with half a digit of rounding before and after, in each of three components; A and C take up to six
    /// times the digits of a rotation at B = 80°.
    fn within_limits(&self, step: &[i64; 6], before: &[f64; 6]) -> Result<(), String> {
        let limits = &self.settings.limits;
        let [x, y, z, ..] = step.map(|counts| counts as f64 * self.digit[0]);
        let moved = Vector3::new(x, y, z).norm();
        if moved > limits.step_m * 1.001 + 2.0 * self.digit[0] {
            return Err(format!("{moved} m: {step:?}"));
        }
        let turn = |[_, _, _, a, b, c]: [f64; 6]| orientation_from_abc::<f64>(&[a, b, c]);
        let angle = turn(*before).angle_to(&turn(self.pose()));
        if angle > limits.step_rad * 1.001 + 6.0 * self.digit[1] + 1e-5 {
            return Err(format!("{angle} rad: {step:?}"));
        }
        Ok(())
    }

    fn moves_only_when_it_may(
        &mut self,
        record: &CycleRecord,
        step: &[i64; 6],
    ) -> Result<(), String> {
        let may = match record.trace.mode {
            Mode::Running | Mode::Jogging => true,
            Mode::Fault => false,
            Mode::Idle | Mode::Hold | Mode::Armed => self.was_moving,
        };
        self.was_moving = record.trace.sent_velocity != [0.0; 6];
        if may || *step == [0; 6] {
            Ok(())
        } else {
            Err(format!("{:?}: {step:?}", record.trace.mode))
        }
    }
}

/// All numbers of a trace.
fn numbers(t: &Trace) -> impl Iterator<Item = &[f64]> {
    let poses = [
        &t.pose,
        &t.body_k.pose,
        &t.body_q.pose,
        &t.docking.pose,
        &t.command_pose,
    ];
    let twists = [
        &t.wrench_at_m,
        &t.removed,
        &t.executed_velocity,
        &t.body_k.velocity,
        &t.body_q.velocity,
        &t.docking.velocity,
        &t.model_velocity,
        &t.law_velocity,
        &t.sent_velocity,
    ];
    let poses = poses.into_iter().map(|pose| &pose[..]);
    let twists = twists.into_iter().map(|twist| &twist[..]);
    poses
        .chain(twists)
        .chain(t.law_parts.iter().map(|part| &part[..]))
}

/// Checks that every number is finite and that the models stay within their ranges; at the limit of a range a flag must be
/// set.
///
/// # Errors
/// The first failed check.
pub fn sane(trace: &Trace) -> Result<(), String> {
    for (n, group) in numbers(trace).enumerate() {
        if !group.iter().all(|v| v.is_finite()) {
            return Err(format!("group {n}: {trace:?}"));
        }
    }
    saturates_and_says_so(trace)
}

fn saturates_and_says_so(trace: &Trace) -> Result<(), String> {
    for body in [&trace.body_k, &trace.body_q] {
        let [x, y, z, a, b, c] = body.velocity.map(f64::abs);
        let (speed, spin) = (x.max(y).max(z), a.max(b).max(c));
        if speed > FASTEST.0 || spin > FASTEST.1 {
            return Err(format!("beyond its range: {:?}", body.velocity));
        }
        let length: f64 = body.pose[3..].iter().map(|q| q * q).sum();
        if (length - 1.0).abs() > 1e-3 {
            return Err(format!("not a rotation: {:?}", body.pose));
        }
        let at_edge = speed >= 100.0 || spin >= 20.0;
        let judged = trace.mode == Mode::Running
            && !trace.limits.has(LimitFlags::SENSOR_STALE)
            && !trace.limits.has(LimitFlags::ROBOT_CLAMP);
        if at_edge && judged && !trace.limits.has(LimitFlags::MODEL) {
            return Err(format!("no flag: {:?}, {:?}", body.velocity, trace.limits));
        }
    }
    Ok(())
}
