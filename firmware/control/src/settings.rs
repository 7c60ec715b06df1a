//! What a person writes.
//!
//! `Settings` is plain SI text; [`Settings::validate`] names the field, the value and the allowed
//! range of whatever does not fit, so that the cycle can build its ready-to-run form without a
//! further check.

use crate::delay::DelaySettings;
use crate::jog::JogSettings;
use crate::limits::LimitSettings;

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

/// Whether a correction is added each cycle or is the total offset. The cycle does not look at it: it
/// is the link's, as are the decimals.
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
pub struct RobotSettings {
    /// Time between two telegrams of the robot, s (RSI: 0.004 for IPO_FAST, 0.012 for IPO).
    pub cycle_s: f64,
    /// Relative or absolute corrections.
    pub correction_mode: CorrectionMode,
    /// Decimals of the corrections on the wire, which are in mm and degrees (3 to 6).
    pub correction_decimals: u8,
    /// Rise of the robot's counter of late answers within one run that latches a fault.
    pub late_answers_fault: u32,
    /// Lost telegrams in a row that latch a fault; a gap up to this is only counted.
    pub lost_telegrams_fault: u32,
}
}

impl Default for RobotSettings {
    fn default() -> Self {
        Self {
            cycle_s: 0.004,
            correction_mode: CorrectionMode::Relative,
            correction_decimals: 4,
            late_answers_fault: 25,
            lost_telegrams_fault: 10,
        }
    }
}

/// What to do about the wrench that accelerating the tool takes (section 3.2, last bracket).
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
pub struct SensorSettings {
    /// Origin of S in M, m.
    pub position_m: [f64; 3],
    /// Orientation of S in M, quaternion w x y z.
    pub orientation_wxyz: [f64; 4],
    /// Zero-load reading: three forces (N), three torques (N·m).
    pub bias: [f64; 6],
    /// Gravity in C, m/s². A tilted robot base shows here.
    pub gravity_m_s2: [f64; 3],
    /// Mass of everything beyond the sensor, kg.
    pub tool_mass_kg: f64,
    /// Centre of mass of the tool in S, m.
    pub tool_com_m: [f64; 3],
    /// Inertia tensor of the tool about its centre of mass, axes of S, kg·m².
    pub tool_inertia_kg_m2: [[f64; 3]; 3],
    /// Constant torque of gravity about S beyond that of the centre of mass, N·m in C (T_G of the
    /// paper; zero when `tool_com_m` is right, A13).
    pub gravity_torque_n_m: [f64; 3],
    /// Removal of the tool's inertial wrench.
    pub dynamic_compensation: DynamicCompensation,
    /// Bandwidth of the estimate of the tool's acceleration from the robot's pose, Hz.
    pub acceleration_bandwidth_hz: f64,
    /// Cycles without a new sample after which the correction is ramped to zero.
    pub stale_after_cycles: u32,
    /// Cycles without a new sample that latch a fault (20 ms by default).
    pub fault_after_cycles: u32,
    /// Cycles over which new samples with six bit-identical raw words latch a fault, fewer where the
    /// largest load could do harm meanwhile; beyond `stale_after_cycles` of them the motion is held.
    /// Real gauges flicker by a count. 0 says that this sensor has no noise, as in some simulations.
    pub frozen_after_cycles: u32,
    /// Status bits that are reported but do not fault.
    pub ignored_status_bits: u32,
}
}

impl Default for SensorSettings {
    fn default() -> Self {
        Self {
            position_m: [0.0; 3],
            orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
            bias: [0.0; 6],
            gravity_m_s2: [0.0, 0.0, -9.81],
            tool_mass_kg: 0.0,
            tool_com_m: [0.0; 3],
            tool_inertia_kg_m2: [[0.0; 3]; 3],
            gravity_torque_n_m: [0.0; 3],
            dynamic_compensation: DynamicCompensation::Off,
            acceleration_bandwidth_hz: 10.0,
            stale_after_cycles: 2,
            fault_after_cycles: 5,
            frozen_after_cycles: 5,
            ignored_status_bits: 0,
        }
    }
}

crate::described! {
/// One simulated spacecraft: mass properties, space-manipulator terms and initial conditions.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct BodySettings {
    /// Does not move, whatever acts on it (a spacecraft of unlimited mass).
    pub fixed: bool,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Inertia tensor about the centre of mass, body axes, kg·m².
    pub inertia_kg_m2: [[f64; 3]; 3],
    /// a_ARM: acceleration by the space manipulator, m/s² in C. It stands for −F_arm/m and is
    /// entered once, here (A12).
    pub arm_acceleration_m_s2: [f64; 3],
    /// α_ARM: angular acceleration by the space manipulator, rad/s² in body axes.
    pub arm_angular_acceleration_rad_s2: [f64; 3],
    /// Stiffness of the space manipulator, N/m: it pulls the spacecraft back to its initial position.
    pub arm_stiffness_n_per_m: f64,
    /// Damping of the space manipulator, N·s/m: it brakes the spacecraft.
    pub arm_damping_n_s_per_m: f64,
    /// Initial position of the centre of mass in C, m.
    pub position_m: [f64; 3],
    /// Initial orientation in C, quaternion w x y z.
    pub orientation_wxyz: [f64; 4],
    /// Initial velocity in C, m/s.
    pub velocity_m_s: [f64; 3],
    /// Initial angular velocity in body axes, rad/s.
    pub angular_velocity_rad_s: [f64; 3],
}
}

impl Default for BodySettings {
    fn default() -> Self {
        Self {
            fixed: false,
            mass_kg: 500.0,
            inertia_kg_m2: [[100.0, 0.0, 0.0], [0.0, 100.0, 0.0], [0.0, 0.0, 100.0]],
            arm_acceleration_m_s2: [0.0; 3],
            arm_angular_acceleration_rad_s2: [0.0; 3],
            arm_stiffness_n_per_m: 0.0,
            arm_damping_n_s_per_m: 0.0,
            position_m: [0.0; 3],
            orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
            velocity_m_s: [0.0; 3],
            angular_velocity_rad_s: [0.0; 3],
        }
    }
}

impl BodySettings {
    /// Stiffness (1/s²) and damping (1/s) of the space manipulator, over the mass of the spacecraft.
    pub fn arm_resistance_per_kg(&self) -> (f64, f64) {
        (
            self.arm_stiffness_n_per_m / self.mass_kg,
            self.arm_damping_n_s_per_m / self.mass_kg,
        )
    }
}

crate::described! {
/// Observation frames: docking surfaces on the two spacecraft.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct FrameSettings {
    /// Origin of J (= N) in K, m.
    pub j_position_m: [f64; 3],
    /// Orientation of J in K, quaternion w x y z.
    pub j_orientation_wxyz: [f64; 4],
    /// Origin of P in Q, m.
    pub p_position_m: [f64; 3],
    /// Orientation of P in Q, quaternion w x y z.
    pub p_orientation_wxyz: [f64; 4],
}
}

impl Default for FrameSettings {
    fn default() -> Self {
        let identity = [1.0, 0.0, 0.0, 0.0];
        Self {
            j_position_m: [0.0; 3],
            j_orientation_wxyz: identity,
            p_position_m: [0.0; 3],
            p_orientation_wxyz: identity,
        }
    }
}

crate::described! {
/// Conditions for arming, and the start ramp.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct StartSettings {
    /// Largest compensated force with which the rig may be armed, started or reset, N.
    pub max_force_n: f64,
    /// Largest compensated torque likewise, N·m.
    pub max_torque_n_m: f64,
    /// Largest mean force that the `zero` command takes as the sensor's zero, N.
    pub max_zero_force_n: f64,
    /// Largest mean torque likewise, N·m.
    pub max_zero_torque_n_m: f64,
    /// Cycles of zero correction after the start.
    pub zero_cycles: u32,
    /// Cycles in which the velocity then rises to the initial velocity.
    pub ramp_cycles: u32,
    /// Time in which a stop or a stale sensor brings the velocity to zero, s.
    pub stop_time_s: f64,
}
}

impl Default for StartSettings {
    fn default() -> Self {
        Self {
            max_force_n: 20.0,
            max_torque_n_m: 5.0,
            max_zero_force_n: 100.0,
            max_zero_torque_n_m: 20.0,
            zero_cycles: 2,
            ramp_cycles: 25,
            stop_time_s: 0.1,
        }
    }
}
