//! The operator's jog: which axis, how far, how fast, and whether there is room for it.

pub mod excitation;

use crate::frames::{self, Pose, Twist};
use crate::limits::{LimitSettings, angle};
use crate::range::{FieldName, SettingsError, in_range};
use crate::robot::GimbalLock;
use crate::scalar::Scalar;
use excitation::{Excitation, FASTEST, FORWARD, LARGEST_JUMP};

/// Every jog has the same sequence, so that it can be compared with an earlier one.
const SEED: u32 = 1;
/// Slowest mean speed, m/s and rad/s: below what any allowed limit could require.
const SLOWEST: f64 = 1.0e-7;

/// Axis and direction of a jog. X, Y and Z are the axes of C; A, B and C turn about z, y and x of M.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[allow(missing_docs, reason = "the names say it")]
pub enum Jog {
    X,
    Y,
    Z,
    A,
    B,
    C,
    MinusX,
    MinusY,
    MinusZ,
    MinusA,
    MinusB,
    MinusC,
}

impl Jog {
    /// Index of the axis in a twist (linear x y z, angular x y z), and the sign of the direction.
    pub fn component(self) -> (usize, f64) {
        match self {
            Self::X => (0, 1.0),
            Self::Y => (1, 1.0),
            Self::Z => (2, 1.0),
            Self::A => (5, 1.0),
            Self::B => (4, 1.0),
            Self::C => (3, 1.0),
            Self::MinusX => (0, -1.0),
            Self::MinusY => (1, -1.0),
            Self::MinusZ => (2, -1.0),
            Self::MinusA => (5, -1.0),
            Self::MinusB => (4, -1.0),
            Self::MinusC => (3, -1.0),
        }
    }

    /// Whether it turns.
    pub fn is_rotation(self) -> bool {
        self.component().0 >= 3
    }
}

crate::described! {
/// The jog from which the robot's delay is told.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct JogSettings {
    /// Mean speed along an axis, m/s. It goes 1.6 times as fast, and changes by 1.8 times as much
    /// from one cycle to the next: `limits` must allow both.
    pub speed_m_s: f64 = 0.02,
    /// Distance to one side beyond which it never goes, m: at least half a second of the way
    /// forward at 4 ms, at most the smallest of `limits.box_m`.
    pub reach_m: f64 = 0.05,
    /// Mean angular speed, rad/s, likewise.
    pub speed_rad_s: f64 = 0.03,
    /// Angle likewise, rad: at most `limits.box_rad`.
    pub reach_rad: f64 = 0.075,
}
}

/// Bounds for translation or rotation.
struct Bounds {
    speed: FieldName,
    reach: FieldName,
    /// Largest speed, change of it per cycle, and distance from the start.
    limits: [f64; 3],
}

impl JogSettings {
    /// Checks every field, and that the jog keeps within the limits.
    pub(crate) fn validate(
        &self,
        limits: &LimitSettings,
        cycle_s: f64,
    ) -> Result<(), SettingsError> {
        let speed = limits.speed_m_s.min(limits.step_m / cycle_s);
        let smallest = limits.box_m.iter().copied().fold(f64::MAX, f64::min);
        let linear = Bounds {
            speed: "jog.speed_m_s",
            reach: "jog.reach_m",
            limits: [speed, limits.acceleration_m_s2 * cycle_s, smallest],
        };
        linear.check(self.speed_m_s, self.reach_m, cycle_s)?;
        let speed = limits.speed_rad_s.min(limits.step_rad / cycle_s);
        let angular = Bounds {
            speed: "jog.speed_rad_s",
            reach: "jog.reach_rad",
            limits: [speed, limits.acceleration_rad_s2 * cycle_s, limits.box_rad],
        };
        angular.check(self.speed_rad_s, self.reach_rad, cycle_s)
    }

    /// Mean speed (m/s or rad/s) and reach (m or rad) along the axis of a jog.
    pub fn motion(&self, jog: Jog) -> (f64, f64) {
        match jog.is_rotation() {
            false => (self.speed_m_s, self.reach_m),
            true => (self.speed_rad_s, self.reach_rad),
        }
    }

    /// The velocities of a jog.
    pub fn excitation(&self, jog: Jog, cycle_s: f64) -> Excitation {
        self.seeded(jog, cycle_s, SEED)
    }

    /// The velocities of a jog with another seed.
    pub fn seeded(&self, jog: Jog, cycle_s: f64, seed: u32) -> Excitation {
        let (speed, reach) = self.motion(jog);
        let (_, sign) = jog.component();
        let forward = reach / Excitation::reach(speed, 1, cycle_s);
        Excitation::new(sign * speed, forward as u32, seed)
    }
}

/// A jog in progress.
#[derive(Clone, Debug)]
pub(crate) struct JogRun {
    jog: Jog,
    excitation: Excitation,
}

impl JogRun {
    /// From validated settings.
    pub(crate) fn new(settings: &JogSettings, jog: Jog, cycle_s: f64) -> Self {
        let excitation = settings.excitation(jog, cycle_s);
        Self { jog, excitation }
    }

    /// The velocity of the next cycle; `None` when the jog is over.
    pub(crate) fn next_velocity<S: Scalar>(&mut self) -> Option<Twist<S>> {
        let (axis, _) = self.jog.component();
        let velocity = self.excitation.next_velocity()?;
        let mut twist = [0.0; 6];
        twist.get_mut(axis).map(|component| *component = velocity)?;
        Some(Twist::of(&twist))
    }
}

impl Bounds {
    fn check(&self, speed: f64, reach: f64, cycle_s: f64) -> Result<(), SettingsError> {
        let [fastest, change, farthest] = self.limits;
        let [fewest, most] = FORWARD;
        let shortest = Excitation::reach(1.0, fewest, cycle_s);
        let largest = (fastest / FASTEST)
            .min(change / LARGEST_JUMP)
            .min(farthest / shortest);
        in_range(self.speed, speed, SLOWEST, largest)?;
        let low = Excitation::reach(speed, fewest, cycle_s).min(farthest);
        let high = Excitation::reach(speed, most, cycle_s).min(farthest);
        in_range(self.reach, reach, low, high)
    }
}

/// Whether a jog from a measured pose keeps within the box around `center`, and off the gimbal lock
/// of the robot's angles.
pub(crate) fn has_room<S: Scalar>(
    (settings, limits): (&JogSettings, &LimitSettings),
    gimbal_lock: Option<&GimbalLock>,
    jog: Jog,
    pose: &Pose<S>,
    center: &Pose<S>,
) -> bool {
    let ((axis, sign), (_, reach)) = (jog.component(), settings.motion(jog));
    if jog.is_rotation() {
        let turned = angle(&(center.rotation.inverse() * pose.rotation)).get();
        let clear =
            gimbal_lock.is_none_or(|lock| lock.sine(&pose.rotation) <= lock.largest_sine(reach));
        return clear && turned + reach <= limits.box_rad;
    }
    let [from, to] = [center, pose].map(|p| frames::components(&p.translation.vector));
    let (from, to) = (from.get(axis), to.get(axis));
    let away = to.zip(from).map_or(0.0, |(to, from)| to - from) * sign;
    let edge = limits.box_m.get(axis).copied().unwrap_or_default();
    away >= -edge && away + reach <= edge
}

#[cfg(test)]
mod tests;
