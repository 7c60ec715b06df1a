//! Settings of a simulated rig, as a person writes them. SI units, named in the keys.
//!
//! The defaults are scenario S: a robot that is 32 ms late and stands still for 16 ms when an axis
//! reverses, a sensor with a light tool that flickers by a gauge count, as real ones do. There is nothing
//! to touch until a wall is given. Other noise, latency and faults are off until somebody asks for them,
//! so that what differs is what was asked for.

use super::hidden::effect::Hidden;
use serde::{Deserialize, Serialize};
use softdock_link::can::ati::AtiCalibration;
use softdock_mechanism::DockingSettings;
use softdock_physics::model::GuideModel;

/// A simulated rig: robot, mechanism and sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RigSettings {
    /// Interpolation cycle of the robot controller, µs (`#IPO_FAST`: 4000).
    pub cycle_us: u32,
    /// Integration step of the plant, µs; divides the cycle, at most 64 per cycle.
    pub substep_us: u32,
    /// Gravity in C, m/s².
    pub gravity_m_s2: [f64; 3],
    /// The robot and its controller.
    pub robot: RobotSettings,
    /// The docking mechanism.
    pub mechanism: MechanismSettings,
    /// The force/torque sensor and the tool on it.
    pub sensor: SensorSettings,
    /// Effects of the catalogue that come on top of all of the above.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hidden: Vec<Hidden>,
}

impl Default for RigSettings {
    fn default() -> Self {
        Self {
            cycle_us: 4000,
            substep_us: 500,
            gravity_m_s2: [0.0, 0.0, -9.81],
            robot: RobotSettings::default(),
            mechanism: MechanismSettings::default(),
            sensor: SensorSettings::default(),
            hidden: Vec::new(),
        }
    }
}

impl RigSettings {
    /// Builds a rig from these settings and drops it: every value outside its range is an error
    /// that names the field, the value and the allowed range.
    pub fn validate(&self) -> anyhow::Result<()> {
        super::Rig::new(self, [0.0; 6], 0).map(drop)
    }

    /// Cycle time, s.
    pub fn cycle_s(&self) -> f64 {
        f64::from(self.cycle_us) * 1e-6
    }

    /// Integration step, s.
    pub fn substep_s(&self) -> f64 {
        f64::from(self.substep_us) * 1e-6
    }
}

/// How the controller takes a correction (`RSI_ON(#RELATIVE)` or `RSI_ON(#ABSOLUTE)`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CorrectionMode {
    /// The value is added in each cycle.
    Relative,
    /// The value is the total offset from the start pose.
    Absolute,
}

/// What the timeout of the ETHERNET object counts. Public sources do not settle it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeoutCounting {
    /// All late answers since the start: a budget, the stricter reading.
    Total,
    /// Late answers in a row; a good answer starts anew.
    Consecutive,
}

/// The robot controller's side of RSI, and the motion of the arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RobotSettings {
    /// Relative or absolute correction.
    pub correction: CorrectionMode,
    /// HOLDON of the correction inputs: a missing answer keeps the last value instead of 0. Right
    /// for absolute correction; in relative correction the kept value is added again.
    pub hold_on: bool,
    /// More late answers than this stop the robot.
    pub timeout_cycles: u32,
    /// What `timeout_cycles` counts.
    pub timeout_counting: TimeoutCounting,
    /// Age of the reported actual pose, cycles (0 to 31).
    pub feedback_latency_cycles: u8,
    /// White noise of the reported position, one sigma, m.
    pub position_noise_m: f64,
    /// White noise of the reported A, B, C, one sigma, rad.
    pub rotation_noise_rad: f64,
    /// Resolution of the reported position, m; 0: not rounded.
    pub position_resolution_m: f64,
    /// Resolution of the reported A, B, C, rad; 0: not rounded.
    pub rotation_resolution_rad: f64,
    /// By how many cycles the delay of a cycle deviates when it deviates (0 to 8).
    pub delay_jitter_cycles: u8,
    /// Probability that a cycle is later by that much, and the same that it is earlier (0 to 0.5).
    pub delay_jitter_probability: f64,
    /// From the commanded to the executed velocity.
    pub actuator: ActuatorSettings,
    /// POSCORR: silent clamp of the total correction.
    pub correction_limit: CorrectionLimit,
    /// POSCORRMON: the total correction at which the robot stops.
    pub correction_monitor: CorrectionMonitor,
}

impl Default for RobotSettings {
    fn default() -> Self {
        Self {
            correction: CorrectionMode::Relative,
            hold_on: false,
            timeout_cycles: 100,
            timeout_counting: TimeoutCounting::Total,
            feedback_latency_cycles: 0,
            position_noise_m: 0.0,
            rotation_noise_rad: 0.0,
            position_resolution_m: 0.0,
            rotation_resolution_rad: 0.0,
            delay_jitter_cycles: 1,
            delay_jitter_probability: 0.0,
            actuator: ActuatorSettings::default(),
            correction_limit: CorrectionLimit::default(),
            correction_monitor: CorrectionMonitor::default(),
        }
    }
}

/// From the commanded to the executed velocity, the same for all six axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ActuatorSettings {
    /// Transport delay from the telegram that is answered to the start of motion, s. Below one
    /// cycle it is exact only if the answer comes at the instant of the telegram.
    pub delay_s: f64,
    /// Time constant of a first-order lag behind the delay, s.
    pub lag_s: f64,
    /// Standstill of an axis that reverses, s.
    pub pause_s: f64,
    /// Second-order servo or structural mode behind the lag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo: Option<ServoSettings>,
    /// Acceleration limit of X, Y, Z, m/s²; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_acceleration_m_s2: Option<f64>,
    /// Acceleration limit of A, B, C, rad/s²; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_acceleration_rad_s2: Option<f64>,
    /// Velocity limit of X, Y, Z, m/s; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_velocity_m_s: Option<f64>,
    /// Velocity limit of A, B, C, rad/s; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_velocity_rad_s: Option<f64>,
}

impl Default for ActuatorSettings {
    fn default() -> Self {
        Self {
            delay_s: 0.032,
            lag_s: 0.0,
            pause_s: 0.016,
            servo: None,
            max_acceleration_m_s2: None,
            max_acceleration_rad_s2: None,
            max_velocity_m_s: None,
            max_velocity_rad_s: None,
        }
    }
}

/// An under-damped second-order response.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoSettings {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio, below 1.
    pub damping_ratio: f64,
}

/// POSCORR: limits of the total correction; the defaults are the controller's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CorrectionLimit {
    /// Lower limits of X, Y, Z, m, not above 0.
    pub lower_m: [f64; 3],
    /// Upper limits of X, Y, Z, m, not below 0.
    pub upper_m: [f64; 3],
    /// Limit of the norm of the A, B, C corrections, rad.
    pub max_rotation_rad: f64,
}

impl Default for CorrectionLimit {
    fn default() -> Self {
        Self {
            lower_m: [-0.005; 3],
            upper_m: [0.005; 3],
            max_rotation_rad: 5.0_f64.to_radians(),
        }
    }
}

/// POSCORRMON: the controller's defaults hold even where the object is absent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CorrectionMonitor {
    /// Euclidean norm of the X, Y, Z correction, m.
    pub max_translation_m: f64,
    /// Norm of the A, B, C correction, rad.
    pub max_rotation_rad: f64,
}

impl Default for CorrectionMonitor {
    fn default() -> Self {
        Self {
            max_translation_m: 0.006,
            max_rotation_rad: 6.0_f64.to_radians(),
        }
    }
}

/// The docking mechanism: planes that stop tips of the moving spacecraft, a guide, and others beside
/// them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MechanismSettings {
    /// Up to eight planes. A spring rod between two stops is two planes that face each other; an
    /// oblique stop has an oblique normal; an off-centre one has its tip off the axis.
    pub walls: Vec<WallSettings>,
    /// A spring and damper that centre a tip across an axis, in contact or not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guide: Option<GuideModel>,
    /// Up to four mechanisms of `softdock_mechanism`; their forces add.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub docking: Vec<DockingSettings>,
    /// The loop stays closed when latches have caught the spacecraft. Otherwise the capture switch
    /// stops the board, as the operator's `stop` does.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub runs_on_after_capture: bool,
}

/// An elastic plane, fixed in C, and the point of M that it stops.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallSettings {
    /// A point of the plane in C, m.
    pub point_m: [f64; 3],
    /// Normal in C, towards the free side; any length.
    pub normal: [f64; 3],
    /// Contact point on the moving spacecraft, in M, m.
    #[serde(default)]
    pub tip_m: [f64; 3],
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping, N·s/m.
    #[serde(default)]
    pub damping_n_s_per_m: f64,
    /// Penetration over which damping sets in, m; 0: at once.
    #[serde(default)]
    pub damping_onset_m: f64,
    /// Play behind the plane before its spring is met, m.
    #[serde(default)]
    pub gap_m: f64,
    /// Coulomb friction coefficient.
    #[serde(default)]
    pub friction_coefficient: f64,
    /// Sliding speed at which friction is fully developed, m/s.
    #[serde(default = "default_smoothing_speed_m_s")]
    pub smoothing_speed_m_s: f64,
}

fn default_smoothing_speed_m_s() -> f64 {
    1e-3
}

/// The force/torque sensor and the tool on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSettings {
    /// Origin of S in M, m.
    pub position_m: [f64; 3],
    /// Orientation of S in M as A, B, C, rad.
    pub orientation_abc_rad: [f64; 3],
    /// Mass that hangs on the sensor, kg.
    pub tool_mass_kg: f64,
    /// Its centre of mass from the sensor's origin, axes of S, m.
    pub tool_com_m: [f64; 3],
    /// Its inertia about the centre of mass, axes of S, kg·m².
    pub tool_inertia_kg_m2: [[f64; 3]; 3],
    /// Whether the sensor feels the tool's inertia. It does on a real rig; the paper neglects it.
    pub inertial_load: bool,
    /// Offset of the force at time 0, N.
    pub bias_n: [f64; 3],
    /// Offset of the torque at time 0, N·m.
    pub bias_nm: [f64; 3],
    /// Drift of the force offset, N/s.
    pub drift_n_per_s: [f64; 3],
    /// Drift of the torque offset, N·m/s.
    pub drift_nm_per_s: [f64; 3],
    /// White noise of each force, one sigma, N; about a gauge count by default.
    pub noise_force_n: f64,
    /// White noise of each torque, one sigma, N·m.
    pub noise_torque_nm: f64,
    /// Cut-off of the sensor's first-order low-pass, Hz; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low_pass_hz: Option<f64>,
    /// Calibration matrix: rows Fx Fy Fz Tx Ty Tz, columns gauges 0 to 5, calibrated counts per
    /// gauge count.
    pub calibration: [[f64; 6]; 6],
    /// Calibrated counts per newton.
    pub counts_per_newton: f64,
    /// Calibrated counts per newton metre.
    pub counts_per_newton_metre: f64,
}

/// Three beams, 120° apart, each with a gauge for bending in the plane (0, 2, 4) and one for
/// bending out of it (1, 3, 5), with the cross-talk of a few percent that real sensors have.
/// One gauge count is about 0.03 N or 0.001 N·m: a range of about 900 N and 40 N·m.
const CALIBRATION: [[f64; 6]; 6] = [
    [0.75, -0.42, -22.31, 1.12, 24.09, -0.87],
    [-26.48, 1.31, 13.77, -0.64, 12.95, 1.05],
    [0.75, -27.35, 1.94, -25.62, 1.25, -27.65],
    [0.021, -0.035, -0.044, 0.917, 0.031, -0.958],
    [-0.048, 1.083, 0.026, -0.524, 0.017, -0.561],
    [-0.662, 0.019, -0.641, 0.033, -0.687, -0.028],
];

impl SensorSettings {
    /// The calibration that the sensor reports about itself.
    pub fn calibration(&self) -> AtiCalibration {
        AtiCalibration {
            matrix: self.calibration,
            counts_per_force: self.counts_per_newton,
            counts_per_torque: self.counts_per_newton_metre,
        }
    }
}

impl Default for SensorSettings {
    fn default() -> Self {
        Self {
            position_m: [0.0; 3],
            orientation_abc_rad: [0.0; 3],
            tool_mass_kg: 1.8,
            tool_com_m: [0.002, -0.001, 0.06],
            tool_inertia_kg_m2: [[0.004, 0.0, 0.0], [0.0, 0.004, 0.0], [0.0, 0.0, 0.002]],
            inertial_load: false,
            bias_n: [0.0; 3],
            bias_nm: [0.0; 3],
            drift_n_per_s: [0.0; 3],
            drift_nm_per_s: [0.0; 3],
            noise_force_n: 0.03,
            noise_torque_nm: 0.001,
            low_pass_hz: None,
            calibration: CALIBRATION,
            counts_per_newton: 1000.0,
            counts_per_newton_metre: 1000.0,
        }
    }
}
