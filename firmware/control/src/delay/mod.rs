//! Compensation of the robot's delay: one law per file, chosen by a setting.
//!
//! A law turns the velocity that the model wants into the velocity that the robot is told. It
//! sees what it may need and nothing else ([`LawInput`]): the model's velocity, the contact
//! wrench, the measured pose and the commands that were sent and may not have been executed yet.

pub mod seed;

use crate::frames::{Pose, Twist, Wrench};
use crate::range::SettingsError;
use crate::scalar::Scalar;
use seed::{Seed, SeedSettings};

/// Commands kept for laws that look into the pipeline: 64 cycles are 256 ms, several times the
/// delay of an industrial robot (about 32 ms).
pub const SENT_HISTORY: usize = 64;

/// The velocities sent in the last cycles, oldest first.
pub type SentHistory<S> = heapless::HistoryBuf<Twist<S>, SENT_HISTORY>;

/// Which law runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum LawName {
    /// The model's velocity goes to the robot as it is.
    #[default]
    None,
    /// The paper's law, section 4.2.
    Seed,
}

/// Which velocity of the model stands for a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum ModelVelocity {
    /// 0.5 (v(n−1) + v(n)), as printed; half a cycle late (A11).
    #[default]
    Mean,
    /// v(n): no added energy on a rig without delay.
    End,
}

/// Settings of the delay compensation.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct DelaySettings {
    /// The law.
    pub law: LawName,
    /// The model's velocity that the law gets.
    pub model_velocity: ModelVelocity,
    /// Settings of the paper's law.
    pub seed: SeedSettings,
}

impl DelaySettings {
    /// Checks every field.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.seed.validate()
    }
}

/// What a law gets to see in a cycle.
#[derive(Debug)]
pub struct LawInput<'a, S: Scalar> {
    /// Velocity that the model wants: linear in C, angular in M.
    pub model: Twist<S>,
    /// Contact wrench at M, axes of M.
    pub wrench: &'a Wrench<S>,
    /// Measured pose of M in C.
    pub measured: &'a Pose<S>,
    /// Velocities sent in earlier cycles.
    pub sent: &'a SentHistory<S>,
}

/// Number of visible parts of a law (Fig. 9 has seven).
pub const PARTS: usize = 7;

/// What a law answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawOutput<S: Scalar> {
    /// Velocity for the robot: linear in C, angular in M.
    pub command: Twist<S>,
    /// The parts that were added to the model's velocity, for the trace.
    pub parts: [Twist<S>; PARTS],
}

/// A law and its state.
#[derive(Clone, Debug)]
pub enum Law<S: Scalar> {
    /// No compensation.
    None,
    /// The paper's law.
    Seed(Seed<S>),
}

impl<S: Scalar> Law<S> {
    /// The chosen law in its initial state; `cycle_s` in s.
    pub fn new(settings: &DelaySettings, cycle_s: f64) -> Self {
        match settings.law {
            LawName::None => Self::None,
            LawName::Seed => Self::Seed(Seed::new(&settings.seed, cycle_s)),
        }
    }

    /// One cycle.
    pub fn step(&mut self, input: &LawInput<'_, S>) -> LawOutput<S> {
        match self {
            Self::None => LawOutput {
                command: input.model,
                parts: [Twist::zero(); PARTS],
            },
            Self::Seed(law) => law.step(&input.model),
        }
    }
}
