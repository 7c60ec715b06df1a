//! The sections of `model.toml`.

use super::Axis;
use serde::{Deserialize, Serialize};
use softdock_control::settings::BodySettings;
use softdock_mechanism::DockingSettings;
use softdock_statistics::{LowPass, LowPassed};

/// Axes of the rig.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RigModel {
    /// Axes that move. The others are held: no motion is predicted or judged there; the wrench
    /// always is.
    pub active_axes: Vec<Axis>,
}

impl Default for RigModel {
    fn default() -> Self {
        Self {
            active_axes: Axis::ALL.to_vec(),
        }
    }
}

/// From the velocity that was sent to the velocity that is executed: held for a cycle, then a
/// transport delay, then a first-order lag.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ActuatorModel {
    /// Time from the start of the cycle in which a velocity is sent to the instant at which the
    /// robot begins to move with it, s. Zero: during the very cycle that the telegram opens.
    pub transport_delay_s: f64,
    /// Time constant of the lag, s.
    pub lag_s: f64,
}

/// What the docking mechanism touches.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ContactModel {
    /// Elastic half spaces; their forces add.
    pub walls: Vec<WallModel>,
    /// A guide that centres the tip at all times.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guide: Option<GuideModel>,
    /// Docking mechanisms, as `[[rig.mechanism.docking]]` describes them; their forces add.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub docking: Vec<DockingSettings>,
}

/// An elastic, damped wall: `F = n max(0, k p + c min(1, p/d) dp/dt)` with penetration p.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallModel {
    /// A point of the surface in C, m.
    pub point_m: [f64; 3],
    /// Direction out of the wall, in C; any length but zero.
    pub normal: [f64; 3],
    /// Stiffness k, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping c, N·s/m.
    #[serde(default)]
    pub damping_n_s_per_m: f64,
    /// Penetration d at which the damping acts in full, m; 0: at once.
    #[serde(default)]
    pub damping_depth_m: f64,
    /// The point that touches the wall, in M, m.
    #[serde(default)]
    pub tip_m: [f64; 3],
}

/// A spring and damper that act on the tip across an axis, in contact or not:
/// `F = −(k (tip − point) + c v_tip)` without its component along the axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuideModel {
    /// Direction that is free, in C; any length but zero.
    pub axis: [f64; 3],
    /// A point of the axis in C, m.
    #[serde(default)]
    pub point_m: [f64; 3],
    /// The guided point in M, m.
    #[serde(default)]
    pub tip_m: [f64; 3],
    /// Stiffness k across the axis, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping c across the axis, N·s/m.
    #[serde(default)]
    pub damping_n_s_per_m: f64,
}

/// Everything beyond the sensor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ToolModel {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass in S, m.
    pub com_m: [f64; 3],
    /// Inertia tensor about the centre of mass, axes of S, kg·m².
    pub inertia_kg_m2: [[f64; 3]; 3],
    /// The predicted wrench contains what it takes to accelerate the tool.
    pub dynamic_compensation: bool,
}

/// Meaning of the recorded wrench.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WrenchMeaning {
    /// The reading of a force/torque sensor: it can only be later than the motion.
    #[default]
    Measured,
    /// The negative of a force that a motor was commanded to apply: it can only be earlier.
    Commanded,
    /// The same with a scale to newtons that is a guess (amperes, volts, bar): its gain is estimated.
    Unscaled,
    /// No wrench is recorded: a free swing. The amounts of effects are relative to the mass or moment of inertia of the model.
    Free,
}

impl WrenchMeaning {
    /// Whether the wrench drives the motion, and does not react to it.
    pub fn drives(self) -> bool {
        self != Self::Measured
    }

    /// Whether it is a drive's command.
    pub fn is_commanded(self) -> bool {
        matches!(self, Self::Commanded | Self::Unscaled)
    }
}

/// The sensor's place and its zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorModel {
    /// Origin of S in M, m.
    pub position_m: [f64; 3],
    /// Orientation of S in M, quaternion w x y z.
    pub orientation_wxyz: [f64; 4],
    /// Zero-load reading: three forces (N), three torques (N·m).
    pub bias: [f64; 6],
    /// Gravity in C, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Meaning of the recorded wrench.
    pub wrench: WrenchMeaning,
    /// Every cycle is a measurement of its own at rest: poses and wrenches have no motion
    /// between them.
    pub at_rest: bool,
    /// The filter that wrench and motion went through when they were imported; velocities that were sent did not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter: Option<FilterModel>,
}

/// A zero-phase Butterworth low-pass (forward and backward).
///
/// A linear load is filtered through its motion. A friction is not: its sign is taken from the filtered motion, so its force has
/// to be filtered like the recorded one (`load::filtered` treats loads between the two). So has the motion that is computed from
/// commands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterModel {
    /// Order of one pass.
    pub order: u32,
    /// Cut-off frequency of one pass, Hz.
    pub cutoff_hz: f64,
}

impl FilterModel {
    /// Filters a series with this sample time; a cutoff beyond half the sampling rate leaves it as it is.
    pub fn zero_phase(&self, sample_time_s: f64, series: &[f64]) -> Vec<f64> {
        let cutoff = self.cutoff_hz * sample_time_s;
        match cutoff < 0.5 {
            true => LowPass::new(self.order, cutoff).zero_phase(series),
            false => series.to_vec(),
        }
    }

    /// Number of samples beside each end that depend on unknown samples beyond it by more than 1 %, exp(−2π·2·0.38) for order 4;
    /// at most an eighth of a short series.
    pub fn settling(&self, sample_time_s: f64, count: usize) -> usize {
        const PERIODS: f64 = 2.0;
        let settled = (PERIODS / (self.cutoff_hz * sample_time_s)).ceil() as usize;
        settled.min(count / 8)
    }

    /// The filter for samples at this distance.
    pub fn on_samples(&self, sample_time_s: f64) -> LowPassed {
        LowPassed {
            order: self.order,
            cutoff: self.cutoff_hz * sample_time_s,
        }
    }
}

impl Default for SensorModel {
    fn default() -> Self {
        Self {
            position_m: [0.0; 3],
            orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
            bias: [0.0; 6],
            gravity_m_s2: [0.0, 0.0, -9.81],
            wrench: WrenchMeaning::Measured,
            at_rest: false,
            filter: None,
        }
    }
}

/// The two simulated spacecraft. What is left out is taken from the settings in the recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TwoBodyModel {
    /// The passive spacecraft, moved by the robot.
    pub k: BodyModel,
    /// The active spacecraft.
    pub q: BodyModel,
}

/// One simulated spacecraft. What is left out is taken from the settings in the recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyModel {
    /// Does not move, whatever acts on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixed: Option<bool>,
    /// Mass, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Inertia tensor about the centre of mass, body axes, kg·m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia_kg_m2: Option<[[f64; 3]; 3]>,
    /// Acceleration by the space manipulator, m/s² in C.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm_acceleration_m_s2: Option<[f64; 3]>,
    /// Angular acceleration by the space manipulator, rad/s² in body axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm_angular_acceleration_rad_s2: Option<[f64; 3]>,
    /// Stiffness of the space manipulator towards the initial position, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm_stiffness_n_per_m: Option<f64>,
    /// Damping of the space manipulator, N·s/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm_damping_n_s_per_m: Option<f64>,
}

impl BodyModel {
    /// Overwrites the settings that are given here; the others stay.
    pub fn apply_to(&self, settings: &mut BodySettings) {
        settings.fixed = self.fixed.unwrap_or(settings.fixed);
        settings.mass_kg = self.mass_kg.unwrap_or(settings.mass_kg);
        settings.inertia_kg_m2 = self.inertia_kg_m2.unwrap_or(settings.inertia_kg_m2);
        settings.arm_acceleration_m_s2 = self
            .arm_acceleration_m_s2
            .unwrap_or(settings.arm_acceleration_m_s2);
        settings.arm_angular_acceleration_rad_s2 = self
            .arm_angular_acceleration_rad_s2
            .unwrap_or(settings.arm_angular_acceleration_rad_s2);
        settings.arm_stiffness_n_per_m = self
            .arm_stiffness_n_per_m
            .unwrap_or(settings.arm_stiffness_n_per_m);
        settings.arm_damping_n_s_per_m = self
            .arm_damping_n_s_per_m
            .unwrap_or(settings.arm_damping_n_s_per_m);
    }
}

/// One standard deviation of each measurement, by data sheet or from a quiet log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseModel {
    /// Force, N.
    pub force_n: f64,
    /// Torque, N·m.
    pub torque_n_m: f64,
    /// Velocity where it is measured, m/s. Where it is the difference of two poses, the noise
    /// of the pose counts.
    pub velocity_m_s: f64,
    /// Angular velocity where it is measured, rad/s.
    pub rate_rad_s: f64,
    /// Position, m.
    pub position_m: f64,
    /// Angle, rad.
    pub angle_rad: f64,
    /// Digits with which the model's velocity is logged, m/s.
    pub model_velocity_m_s: f64,
    /// Digits with which the model's angular velocity is logged, rad/s.
    pub model_rate_rad_s: f64,
}

impl Default for NoiseModel {
    fn default() -> Self {
        Self {
            force_n: 0.5,
            torque_n_m: 0.03,
            velocity_m_s: 5e-5,
            rate_rad_s: 1e-4,
            position_m: 5e-6,
            angle_rad: 1e-5,
            model_velocity_m_s: 2e-7,
            model_rate_rad_s: 2e-7,
        }
    }
}
