//! The settings of the control cycle.
//!
//! `Settings` holds plain SI values. [`Settings::validate`] returns field, value and allowed range of the first value that does
//! not fit, so that the cycle can be built from validated settings without a further check.

pub use crate::bodies::{BodySettings, FrameSettings};

use crate::delay::DelaySettings;
use crate::jog::JogSettings;
use crate::limits::LimitSettings;
use crate::range::LARGEST_QUATERNION;

crate::described! {
/// Everything that the control cycle needs to know, in SI units.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Settings {
    /// How the robot takes corrections.
    pub robot: RobotSettings,
    /// The sensor's place on the flange, its zero and the tool it carries.
    pub sensor: SensorSettings,
    /// The simulated passive spacecraft K, the one that the robot moves.
    pub body_k: BodySettings,
    /// The simulated active spacecraft Q.
    pub body_q: BodySettings,
    /// Observation frames.
    pub frames: FrameSettings,
    /// Compensation of the robot's delay.
    pub delay: DelaySettings,
    /// Bounds of the correction and of the load.
    pub limits: LimitSettings,
    /// Conditions for arming and the start ramp.
    pub start: StartSettings,
    /// The jog from which the robot's delay is told.
    pub jog: JogSettings,
}
}

/// Whether a correction is added each cycle or is the total offset. Only the link uses it, not the cycle; likewise the decimals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum CorrectionMode {
    /// Each correction is added (RSI: `#RELATIVE`; needs HOLDON=0).
    #[default]
    Relative,
    /// The correction is the total offset (RSI: `#ABSOLUTE`; needs HOLDON=1).
    Absolute,
}

crate::described! {
/// How the robot takes corrections.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct RobotSettings: "robot" {
    /// Time between two telegrams of the robot, s (RSI: 0.004 for IPO_FAST, 0.012 for IPO).
    pub cycle_s: f64 = 0.004 => 0.001..=0.02,
    /// Relative or absolute corrections.
    pub correction_mode: CorrectionMode = CorrectionMode::Relative,
    /// Decimals of the corrections on the wire, which are in mm and degrees (3 to 6).
    pub correction_decimals: u8 = 4 => 3.0..=6.0,
    /// Rise of the robot's counter of late answers within one run that latches a fault.
    pub late_answers_fault: u32 = 25,
    /// Lost telegrams in a row that latch a fault; a gap up to this is only counted.
    pub lost_telegrams_fault: u32 = 10,
}
}

/// How to treat the wrench that the acceleration of the tool causes (section 3.2, last bracket).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum DynamicCompensation {
    /// Ignored, as in the paper (A14).
    #[default]
    Off,
    /// The sensor reads the load's reaction, −m a: the inertial wrench is added back.
    LoadReaction,
    /// The sign as printed (a sensor that reads the drive's action, +m a).
    Printed,
}

crate::described! {
/// Position and orientation of the sensor, its zero and the tool that it carries.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct SensorSettings: "sensor" {
    /// Origin of S in M, m.
    pub position_m: [f64; 3] = [0.0; 3] => -10.0..=10.0,
    /// Orientation of S in M, quaternion w x y z.
    pub orientation_wxyz: [f64; 4] = [1.0, 0.0, 0.0, 0.0] => -LARGEST_QUATERNION..=LARGEST_QUATERNION,
    /// Zero-load reading: three forces (N), three torques (N·m).
    pub bias: [f64; 6] = [0.0; 6] => -1e5..=1e5,
    /// Gravity in C, m/s². A tilted robot base shows here.
    pub gravity_m_s2: [f64; 3] = [0.0, 0.0, -9.81] => -30.0..=30.0,
    /// Mass of everything beyond the sensor, kg.
    pub tool_mass_kg: f64 = 0.0 => 0.0..=2000.0,
    /// Centre of mass of the tool in S, m.
    pub tool_com_m: [f64; 3] = [0.0; 3] => -10.0..=10.0,
    /// Inertia tensor of the tool about its centre of mass, axes of S, kg·m².
    pub tool_inertia_kg_m2: [[f64; 3]; 3] = [[0.0; 3]; 3] => -2000.0..=2000.0,
    /// Constant torque of gravity about S beyond that of the centre of mass, N·m in C (T_G of the
    /// paper; zero when `tool_com_m` is right, A13).
    pub gravity_torque_n_m: [f64; 3] = [0.0; 3] => -1e4..=1e4,
    /// Removal of the tool's inertial wrench.
    pub dynamic_compensation: DynamicCompensation = DynamicCompensation::Off,
    /// Bandwidth of the estimate of the tool's acceleration from the robot's pose, Hz.
    pub acceleration_bandwidth_hz: f64 = 10.0 => 0.1..=60.0,
    /// Cycles without a new sample after which the correction is ramped to zero, which it is at
    /// `fault_after_cycles`.
    pub stale_after_cycles: u32 = 2 => 1.0..=100.0,
    /// Cycles without a new sample that latch a fault (20 ms by default).
    pub fault_after_cycles: u32 = 5,
    /// Cycles over which new samples with six bit-identical raw words latch a fault, fewer where the
    /// largest load could do harm meanwhile; beyond `stale_after_cycles` of them the motion is held.
    /// Real gauges flicker by a count. 0 says that this sensor has no noise, as in some simulations.
    pub frozen_after_cycles: u32 = 5,
    /// Status bits that are reported but do not fault.
    pub ignored_status_bits: u32 = 0,
}
}

crate::described! {
/// Conditions for arming, and the start ramp.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct StartSettings: "start" {
    /// Largest compensated force with which the rig may be armed, started or reset, N.
    pub max_force_n: f64 = 20.0 => 0.0..=1e5,
    /// Largest compensated torque likewise, N·m.
    pub max_torque_n_m: f64 = 5.0 => 0.0..=1e5,
    /// Largest mean force that the `zero` command takes as the sensor's zero, N.
    pub max_zero_force_n: f64 = 100.0 => 0.0..=1e5,
    /// Largest mean torque likewise, N·m.
    pub max_zero_torque_n_m: f64 = 20.0 => 0.0..=1e5,
    /// Cycles of zero correction after the start.
    pub zero_cycles: u32 = 2 => 2.0..=1e4,
    /// Cycles in which the velocity then rises to the initial velocity.
    pub ramp_cycles: u32 = 25 => 1.0..=1e5,
    /// Time in which a stop brings the velocity to zero, at constant deceleration, s; longer where that
    /// would be more than `limits.acceleration_m_s2` or `limits.acceleration_rad_s2`.
    pub stop_time_s: f64 = 0.1,
}
}
