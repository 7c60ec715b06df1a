//! What goes into a cycle and what comes out of it, as plain numbers: this is what a recording
//! holds and what a replay feeds back.

use crate::correction::Counts;
use crate::delay::PARTS;
use crate::delay::status::LawStatus;
use crate::limits::LimitFlags;
use crate::modes::{Command, Fault, Mode, Refusal};

/// Where a telegram stands in the robot's sequence (IPOC).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Sequence {
    /// The first telegram, or the first of a new RSI run (backwards, or a jump).
    #[default]
    NewRun,
    /// One cycle after the last.
    Next,
    /// After a gap of so many lost telegrams.
    Gap(u32),
}

/// The robot's part of a cycle's input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RobotSample {
    /// Time stamp of the telegram, ms; echoed in the answer.
    pub ipoc: u64,
    /// Where it stands in the sequence.
    pub sequence: Sequence,
    /// Measured pose of M in C (RIst): x y z in m, A B C in rad. None if not in the telegram.
    pub pose: Option<[f64; 6]>,
    /// The robot's counter of late or rejected answers (Delay D).
    pub late_answers: u32,
    /// POSCORR status bits: 1-3 lower, 4-6 upper X Y Z, 7 rotation clamped.
    pub poscorr_stat: u32,
}

/// The newest sensor sample that has arrived.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorSample {
    /// Rises by one with each sample; 0 before the first.
    pub counter: u32,
    /// Raw wrench in S: forces in N, torques in N·m.
    pub wrench: [f64; 6],
    /// Raw words (gauge counts) for the log and for the frozen check.
    pub words: [i16; 6],
    /// Status word of the sensor.
    pub status: u16,
    /// A gauge is at its range: all six axes are invalid, because the matrix couples them.
    pub saturated: bool,
}

/// Everything that a cycle may depend on, besides settings and state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inputs {
    /// This cycle's telegram.
    pub robot: RobotSample,
    /// The newest sensor sample.
    pub sensor: SensorSample,
    /// A command of the operator.
    pub command: Option<Command>,
}

/// The answer of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Output {
    /// Correction X Y Z A B C in units of the last digit of mm and degrees.
    pub correction: Counts,
    /// Ask the robot to stop.
    pub stop: bool,
}

/// Motion of one frame in another, for the log: of a simulated craft in C unless said otherwise.
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
    /// The passive craft.
    pub body_k: BodyTrace,
    /// The active craft.
    pub body_q: BodyTrace,
    /// The docking surface J (= N) of K seen from P of Q: its pose in P, and its relative velocity,
    /// linear in axes of P, angular in axes of J.
    pub docking: BodyTrace,
    /// Velocity of the model, in the laboratory.
    pub model_velocity: [f64; 6],
    /// Parts that the delay law added.
    pub law_parts: [[f64; 6]; PARTS],
    /// What the delay law knows and did.
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

/// One cycle as it is recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CycleRecord {
    /// What went in.
    pub inputs: Inputs,
    /// What went out.
    pub output: Output,
    /// What happened in between.
    pub trace: Trace,
}
