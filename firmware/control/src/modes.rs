//! Modes of the controller, the operator's commands, and faults.
//!
//! ```text
//!            hold           arm*           start*
//!    Idle ---------> Hold ---------> Armed ---------> Running
//!                    ^ ^ ^             | stop, hold     | stop, hold
//!                    | | +-------------+<---------------+
//!                    | |    jog*
//!                    | +---------> Jogging --+
//!                    | ^                     | its end, stop, hold
//!                    | +---------------------+
//!                    | reset*
//!                  Fault  <-- from Armed, Running, Jogging and while a stop fades out; latched
//! ```
//!
//! `*` needs fresh, healthy sensor data, a robot that reports its pose and was last commanded to rest, and a small contact force;
//! whether the robot has come to rest is not measured. In every mode each telegram is answered. Only Running and Jogging move the
//! robot, and in Hold the last velocity fades out.

mod words;

pub use crate::fault::{Fault, FaultCode};

use crate::jog::Jog;

/// Mode of the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// Answers zeros; waits for the operator.
    #[default]
    Idle,
    /// Lets the last velocity fade out, then answers zeros and may be armed.
    Hold,
    /// Ready: initial conditions are loaded, the start pose is taken.
    Armed,
    /// Closes the loop.
    Running,
    /// Latched; answers zeros.
    Fault,
    /// Moves one axis as [`crate::jog::excitation`] says, whatever the sensor feels, and holds at its end.
    Jogging,
}

impl Mode {
    /// Whether the robot is moved in this mode, apart from the fading velocity in Hold.
    pub fn moves(self) -> bool {
        matches!(self, Self::Running | Self::Jogging)
    }
}

/// A command of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Command {
    /// Answer zeros and wait for `arm`.
    Hold,
    /// Load the initial conditions and take the start pose.
    Arm,
    /// Close the loop.
    Start,
    /// Bring the velocity to zero and hold.
    Stop,
    /// Leave a fault.
    Reset,
    /// In hold: take the present mean reading as the sensor's zero.
    Zero,
    /// In hold: jog one axis, to see how the robot follows.
    Jog(Jog),
}

impl Command {
    /// All commands with the word that an operator types.
    pub const WORDS: [(&'static str, Self); 18] = [
        ("hold", Self::Hold),
        ("arm", Self::Arm),
        ("start", Self::Start),
        ("stop", Self::Stop),
        ("reset", Self::Reset),
        ("zero", Self::Zero),
        ("jog x", Self::Jog(Jog::X)),
        ("jog y", Self::Jog(Jog::Y)),
        ("jog z", Self::Jog(Jog::Z)),
        ("jog a", Self::Jog(Jog::A)),
        ("jog b", Self::Jog(Jog::B)),
        ("jog c", Self::Jog(Jog::C)),
        ("jog -x", Self::Jog(Jog::MinusX)),
        ("jog -y", Self::Jog(Jog::MinusY)),
        ("jog -z", Self::Jog(Jog::MinusZ)),
        ("jog -a", Self::Jog(Jog::MinusA)),
        ("jog -b", Self::Jog(Jog::MinusB)),
        ("jog -c", Self::Jog(Jog::MinusC)),
    ];

    /// The command of a word.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::WORDS
            .iter()
            .find(|(w, _)| *w == word)
            .map(|(_, command)| *command)
    }

    /// The word of this command.
    pub fn word(self) -> &'static str {
        let known = Self::WORDS.iter().find(|(_, command)| *command == self);
        known.map_or("", |(word, _)| word)
    }
}

/// Why a command was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Refusal {
    /// The command does not apply in this mode.
    WrongMode,
    /// No fresh sensor sample.
    SensorStale,
    /// The sensor reports an error or is saturated.
    SensorUnhealthy,
    /// The telegrams carry no pose.
    NoPose,
    /// The contact force or torque is too large.
    ForceTooLarge,
    /// The last run has not faded out yet.
    StillMoving,
    /// The robot was moved after it was armed; arm again.
    MovedSinceArmed,
    /// Too few good samples for a mean since the run began or the robot moved.
    TooFewSamples,
    /// The robot's angles are near their gimbal lock, where two of them cannot be told apart.
    OrientationSingular,
    /// The jog could leave the box around the pose in which the robot began, or come near the gimbal
    /// lock of its angles.
    NoRoom,
}

/// Whether a cycle's data allow a command.
pub type Readiness = Result<(), Refusal>;

/// The mode and the latched fault.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Modes {
    mode: Mode,
    fault: Option<Fault>,
}

impl Modes {
    /// The present mode.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The latched fault.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Latches a fault; the first one stays.
    pub fn latch(&mut self, fault: Fault) {
        if self.fault.is_none() {
            self.fault = Some(fault);
        }
        self.mode = Mode::Fault;
    }

    /// Carries out a command, or returns why not. `ready` tells whether the present data allow this command; `hold` and `stop` do
    /// not depend on it.
    pub fn command(&mut self, command: Command, ready: Readiness) -> Result<(), Refusal> {
        let next = match (self.mode, command) {
            (Mode::Fault, Command::Hold) => return Err(Refusal::WrongMode),
            (_, Command::Hold) => Mode::Hold,
            (Mode::Armed | Mode::Running | Mode::Jogging | Mode::Hold, Command::Stop) => Mode::Hold,
            (Mode::Hold, Command::Arm) => ready.map(|()| Mode::Armed)?,
            (Mode::Armed, Command::Start) => ready.map(|()| Mode::Running)?,
            (Mode::Fault, Command::Reset) => ready.map(|()| Mode::Hold)?,
            (Mode::Hold, Command::Zero) => ready.map(|()| Mode::Hold)?,
            (Mode::Hold, Command::Jog(_)) => ready.map(|()| Mode::Jogging)?,
            _ => return Err(Refusal::WrongMode),
        };
        self.mode = next;
        if command == Command::Reset {
            self.fault = None;
        }
        Ok(())
    }

    /// The jog is over.
    pub(crate) fn end_jog(&mut self) {
        if self.mode == Mode::Jogging {
            self.mode = Mode::Hold;
        }
    }
}

#[cfg(test)]
mod tests;
