//! The record of one cycle: the robot's own numbers as in its telegram and in the answer, and the trace of the cycle. A replay
//! begins with the same numbers.

use softdock_control::io::{SensorSample, Sequence, Trace};
use softdock_control::modes::Command;

/// Six integers of an answer, in the link's own units. With RSI: X Y Z A B C of the correction, in
/// units of the last digit of mm and degrees.
pub type Correction = [i64; 6];

/// Content of a telegram, in the conventions of the robot's link but in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RobotReport {
    /// Counter or time stamp, echoed in the answer. With RSI: IPOC, ms.
    pub counter: u64,
    /// Position of the telegram in the robot's sequence.
    pub sequence: Sequence,
    /// Measured pose of M in C: x y z (m) and three angles (rad). With RSI: A B C of RIst. None if
    /// not in the telegram.
    pub pose: Option<[f64; 6]>,
    /// The robot's counter of late or rejected answers. With RSI: Delay D.
    pub late_answers: u32,
    /// Status bits. With RSI: POSCORR's; 1-3 lower, 4-6 upper X Y Z, 7 rotation clamped.
    pub status: u32,
}

/// Everything that a cycle depended on, besides settings and state.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Inputs {
    /// This cycle's telegram.
    pub robot: RobotReport,
    /// The newest sensor sample.
    pub sensor: SensorSample,
    /// A command of the operator.
    pub command: Option<Command>,
}

/// The answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Output {
    /// The correction as sent.
    pub correction: Correction,
    /// The robot is asked to stop.
    pub stop: bool,
}

/// One cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CycleRecord {
    /// What went in.
    pub inputs: Inputs,
    /// What went out.
    pub output: Output,
    /// What happened in between.
    pub trace: Trace,
}
