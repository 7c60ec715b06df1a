//! Inputs and outputs of a cycle as plain numbers, independent of the type of robot and sensor.

use crate::delay::PARTS;
use crate::delay::status::LawStatus;
use crate::limits::LimitFlags;
use crate::modes::{Command, Fault, Mode, Refusal};

/// Position of a telegram in the robot's sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Sequence {
    /// The first telegram, or the first after a restart of the robot, which has then forgotten all commands.
    #[default]
    NewRun,
    /// One cycle after the last.
    Next,
    /// After a gap of so many lost telegrams.
    Gap(u32),
}

/// The robot's part of a cycle's input, as its link has decoded it from a telegram.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RobotSample {
    /// Position of the telegram in the sequence.
    pub sequence: Sequence,
    /// Measured pose of M in C: position (m) and unit quaternion (w x y z). `None` if the telegram has none; NaN for a number
    /// that it does not hold.
    pub pose: Option<[f64; 7]>,
    /// The pose is too near the gimbal lock of the robot's angles to begin a motion there.
    pub gimbal_locked: bool,
    /// The robot's counter of late or rejected answers.
    pub late_answers: u32,
    /// The robot clamps its motion to limits of its own, and does not follow the commands.
    pub clamped: bool,
}

/// The newest sensor sample that has arrived.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorSample {
    /// Rises by one with each sample; 0 before the first.
    pub counter: u32,
    /// Raw wrench in S: forces in N, torques in N·m.
    pub wrench: [f64; 6],
    /// Raw counts of its gauges or axes, for the log and for the frozen check.
    pub counts: [i32; 6],
    /// Status word of the sensor.
    pub status: u32,
    /// A gauge is at its range: all six axes are invalid, because the matrix couples them.
    pub saturated: bool,
}

/// Everything that a cycle may depend on, besides settings and state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// This cycle's telegram.
    pub robot: RobotSample,
    /// The newest sensor sample.
    pub sensor: SensorSample,
    /// A command of the operator.
    pub command: Option<Command>,
}

/// Motion that is asked of the robot until its next telegram.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Motion {
    /// Stand still where the commands so far have led.
    #[default]
    Rest,
    /// Move. A link sends the form that its robot takes, and carries its rounding error over into the next cycle.
    Move {
        /// Commanded translation of M since the start, m, axes of C.
        displacement_m: [f64; 3],
        /// Commanded orientation of M in C, unit quaternion (w x y z).
        orientation_wxyz: [f64; 4],
        /// Commanded velocity of M that led there: linear in C (m/s), angular in M (rad/s).
        velocity: [f64; 6],
    },
}

/// The output of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Displacements restart from the measured pose of this cycle.
    pub start: bool,
    /// The robot's motion.
    pub motion: Motion,
    /// Ask the robot to stop.
    pub stop: bool,
}

/// Motion of one frame in another, for the log: of a simulated spacecraft in C unless said otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyTrace {
    /// Position (m) and quaternion (w x y z).
    pub pose: [f64; 7],
    /// Velocity (m/s), angular velocity in the moving frame's own axes (rad/s).
    pub velocity: [f64; 6],
}

/// What happened inside a cycle. SI; linear velocities in C of the laboratory, angular ones in M.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Trace {
    /// Number of the cycle since boot.
    pub cycle: u64,
    /// Number of the cycle × the nominal cycle time, s.
    pub time_s: f64,
    /// Mode in which the cycle was answered.
    pub mode: Mode,
    /// The latched fault.
    pub fault: Option<Fault>,
    /// A command that was refused in this cycle.
    pub refusal: Option<Refusal>,
    /// Limits that acted.
    pub limits: LimitFlags,
    /// Cycles since the newest sensor sample.
    pub sensor_age: u32,
    /// Compensated contact wrench at M, axes of M (N, N·m).
    pub wrench_at_m: [f64; 6],
    /// Tool weight and tool inertia that were removed, in S.
    pub removed: [f64; 6],
    /// Measured pose of M in C: position (m), quaternion (w x y z).
    pub pose: [f64; 7],
    /// Measured velocity of M: difference of two measured poses.
    pub executed_velocity: [f64; 6],
    /// The passive spacecraft.
    pub body_k: BodyTrace,
    /// The active spacecraft.
    pub body_q: BodyTrace,
    /// The docking surface J (= N) of K seen from P of Q: its pose in P, and its relative velocity,
    /// linear in axes of P, angular in axes of J.
    pub docking: BodyTrace,
    /// Velocity of the model, in the laboratory.
    pub model_velocity: [f64; 6],
    /// Parts that the delay law added.
    pub law_parts: [[f64; 6]; PARTS],
    /// What the delay law has identified and done.
    pub law_status: LawStatus,
    /// Impulse at M that the model felt in this cycle beyond the measured wrench, axes of M (N·s,
    /// N·m·s): the sum over a contact is momentum that was not measured.
    pub unaccounted_impulse: [f64; 6],
    /// Velocity that the law asks for.
    pub law_velocity: [f64; 6],
    /// Velocity after the limits: what is sent.
    pub sent_velocity: [f64; 6],
    /// Commanded pose of M in C: position (m), quaternion (w x y z).
    pub command_pose: [f64; 7],
}
