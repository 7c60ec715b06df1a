//! Names of the predicted quantities: four channels of six axes.

use serde::{Deserialize, Serialize};

/// An axis of the rig: translation along, or rotation about, x y z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Translation along x.
    X,
    /// Translation along y.
    Y,
    /// Translation along z.
    Z,
    /// Rotation about x.
    Rx,
    /// Rotation about y.
    Ry,
    /// Rotation about z.
    Rz,
}

impl Axis {
    /// All axes in the order of every six-vector.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::Rx, Self::Ry, Self::Rz];

    /// Index in a six-vector.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Whether it turns.
    pub fn is_rotation(self) -> bool {
        self >= Self::Rx
    }
}

/// What is measured and predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Velocity of M: linear in C, angular in M.
    ExecutedVelocity,
    /// Raw wrench of the sensor, in S.
    Wrench,
    /// Velocity that the rig's model of the two spacecraft asks for.
    ModelVelocity,
    /// Measured pose of M in C.
    Pose,
}

impl Channel {
    /// All channels, in the order in which a signal goes round the loop.
    pub const ALL: [Self; 4] = [
        Self::ExecutedVelocity,
        Self::Wrench,
        Self::ModelVelocity,
        Self::Pose,
    ];

    /// Name in JSON, tables and sentences.
    pub fn name(self) -> &'static str {
        match self {
            Self::ExecutedVelocity => "executed_velocity",
            Self::Wrench => "wrench",
            Self::ModelVelocity => "model_velocity",
            Self::Pose => "pose",
        }
    }

    /// SI unit of an axis.
    pub fn unit(self, axis: Axis) -> &'static str {
        match (self, axis.is_rotation()) {
            (Self::ExecutedVelocity | Self::ModelVelocity, false) => "m/s",
            (Self::ExecutedVelocity | Self::ModelVelocity, true) => "rad/s",
            (Self::Wrench, false) => "N",
            (Self::Wrench, true) => "N·m",
            (Self::Pose, false) => "m",
            (Self::Pose, true) => "rad",
        }
    }
}

macro_rules! display_by_serde_name {
    ($($type:ty => $name:expr),*) => {$(
        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let name: fn(&Self) -> &'static str = $name;
                f.write_str(name(self))
            }
        }
    )*};
}
display_by_serde_name! {
    Channel => |channel| channel.name(),
    Axis => |axis| ["x", "y", "z", "rx", "ry", "rz"][axis.index()]
}
