//! `meta.json` of the log format docking-rig-log/1: the nominal model of the user.
//!
//! The true plant is a second value of the same type: equal in most cases, different within the declared tolerances in some.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// The nominal model of one case. SI units; frames: world C, moving body M, sensor S (parallel
/// to M).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Meta {
    /// `docking-rig-log/1`.
    pub(crate) format: String,
    /// Name of the case.
    pub(crate) case: String,
    /// Nominal controller period, s.
    pub(crate) sample_time_s: f64,
    /// 1 = the axis moves (x y z rx ry rz).
    pub(crate) dof_mask: [u8; 6],
    /// Gravity in C, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Simulated body.
    pub(crate) spacecraft: Spacecraft,
    /// Body between sensor and contact.
    pub(crate) tool: Tool,
    /// Force/torque sensor.
    pub(crate) ft_sensor: FtSensor,
    /// Lever arms in M.
    pub(crate) geometry: Geometry,
    /// The two walls and the transverse guide.
    pub(crate) contact: Contact,
    /// Robot between velocity command and velocity.
    pub(crate) actuator: ActuatorModel,
    /// Data-sheet noise.
    pub(crate) noise_sigma: NoiseSigma,
    /// Standard deviation of nominal parameters, by dotted path; absent = exact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) tolerance: Option<BTreeMap<String, Tolerance>>,
    /// File names of the two logs.
    pub(crate) logs: Logs,
}

/// Simulated spacecraft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spacecraft {
    /// Mass, kg.
    pub(crate) mass_kg: f64,
    /// Inertia about the origin of M, kg m².
    pub inertia_kg_m2: [[f64; 3]; 3],
}

/// Tool behind the sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tool {
    /// Mass, kg.
    pub(crate) mass_kg: f64,
    /// Centre of mass relative to the sensor's origin, m.
    pub(crate) com_m: [f64; 3],
    /// Inertia about the centre of mass, kg m².
    pub inertia_kg_m2: [[f64; 3]; 3],
    /// Whether the nominal wrench model contains the tool's inertial wrench.
    pub(crate) dynamic_compensation: bool,
}

/// Force/torque sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FtSensor {
    /// Zero-load reading, N (3x), Nm (3x).
    pub(crate) bias: [f64; 6],
    /// Range of the forces, N.
    #[serde(rename = "range_force_N")]
    pub(crate) range_force_n: f64,
    /// Range of the torques, Nm.
    #[serde(rename = "range_torque_Nm")]
    pub(crate) range_torque_nm: f64,
}

/// Lever arms in M, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Geometry {
    /// Contact point.
    pub(crate) r_tip_m: [f64; 3],
    /// Sensor origin.
    pub(crate) r_sensor_m: [f64; 3],
    /// Always `identity`.
    #[serde(rename = "sensor_rotation_M_from_S")]
    pub(crate) sensor_rotation: String,
}

/// Contact law: two walls normal to world x and a spring guide across them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Contact {
    /// Always `linear`.
    pub(crate) law: String,
    /// Wall stiffness, N/m.
    #[serde(rename = "k_n_N_m")]
    pub(crate) k_n: f64,
    /// Wall damping, N s/m.
    #[serde(rename = "c_n_Ns_m")]
    pub(crate) c_n: f64,
    /// Guide stiffness along y and z, N/m.
    #[serde(rename = "k_t_N_m")]
    pub(crate) k_t: f64,
    /// Guide damping along y and z, N s/m.
    #[serde(rename = "c_t_Ns_m")]
    pub(crate) c_t: f64,
    /// Penetration at which the wall damping is complete, m.
    pub(crate) delta_c_m: f64,
    /// Front wall, world x of the tip, m.
    pub(crate) x_front_m: f64,
    /// Aft wall, world x of the tip, m.
    pub(crate) x_aft_m: f64,
}

/// Transport delay, then a first-order lag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ActuatorModel {
    /// Transport delay, s.
    pub(crate) transport_delay_s: f64,
    /// Time constant of the lag, s.
    pub(crate) lag_time_constant_s: f64,
}

/// Data-sheet noise, standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct NoiseSigma {
    /// Of forces, N.
    #[serde(rename = "force_N")]
    pub(crate) force_n: f64,
    /// Of torques, Nm.
    #[serde(rename = "torque_Nm")]
    pub(crate) torque_nm: f64,
    /// Of linear velocities, m/s.
    pub(crate) velocity_m_s: f64,
    /// Of angular velocities, rad/s.
    pub(crate) rate_rad_s: f64,
    /// Of positions, m.
    pub(crate) position_m: f64,
    /// Of angles, rad.
    pub(crate) angle_rad: f64,
}

impl NoiseSigma {
    /// The values of every log of this format so far.
    pub(crate) const DATA_SHEET: Self = Self {
        force_n: 0.5,
        torque_nm: 0.03,
        velocity_m_s: 5e-5,
        rate_rad_s: 1e-4,
        position_m: 5e-6,
        angle_rad: 1e-5,
    };
}

/// Standard deviation of a scalar or of a six-vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "serde_json::Value")]
pub(crate) enum Tolerance {
    /// The same for every component.
    One(f64),
    /// Per component.
    Six([f64; 6]),
}

/// Written by hand: serde's untagged enums cannot read numbers if serde_json keeps all of their digits.
impl TryFrom<serde_json::Value> for Tolerance {
    type Error = &'static str;

    fn try_from(value: serde_json::Value) -> Result<Self, Self::Error> {
        match value.as_f64() {
            Some(one) => Ok(Self::One(one)),
            None => serde_json::from_value(value)
                .map(Self::Six)
                .map_err(|_| "expected a number or six numbers"),
        }
    }
}

/// File names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Logs {
    /// Log to fit on.
    pub(crate) train: String,
    /// Log to judge on.
    pub(crate) test: String,
}

impl Meta {
    /// Whether the axis moves.
    pub(crate) fn moves(&self, axis: usize) -> bool {
        self.dof_mask[axis] != 0
    }

    /// `v` with the locked axes set to zero.
    pub(crate) fn masked(&self, v: Vector6<f64>) -> Vector6<f64> {
        Vector6::from_fn(|i, _| if self.moves(i) { v[i] } else { 0.0 })
    }

    pub(crate) fn gravity(&self) -> Vector3<f64> {
        self.gravity_m_s2.into()
    }

    pub(crate) fn tip(&self) -> Vector3<f64> {
        self.geometry.r_tip_m.into()
    }

    pub(crate) fn sensor(&self) -> Vector3<f64> {
        self.geometry.r_sensor_m.into()
    }

    pub(crate) fn bias(&self) -> Vector6<f64> {
        self.ft_sensor.bias.into()
    }
}

impl Tool {
    /// Weight in S: `[m g; com x m g]`, with `gravity` in axes of the body.
    pub(crate) fn weight(&self, gravity: &Vector3<f64>) -> Vector6<f64> {
        let force = gravity * self.mass_kg;
        stack(&force, &Vector3::from(self.com_m).cross(&force))
    }

    /// Inertial wrench in S of the body that moves with the sensor (Newton-Euler):
    /// `a_com = a + alpha x r + w x (w x r)`, `r = r_sensor + com`,
    /// force `-m a_com`, torque `-(I alpha + w x I w) - com x m a_com`.
    pub(crate) fn inertial_wrench(
        &self,
        sensor: &Vector3<f64>,
        acceleration: &Vector3<f64>,
        alpha: &Vector3<f64>,
        omega: &Vector3<f64>,
    ) -> Vector6<f64> {
        let com = Vector3::from(self.com_m);
        let inertia = matrix(&self.inertia_kg_m2);
        let arm = sensor + com;
        let at_com = acceleration + alpha.cross(&arm) + omega.cross(&omega.cross(&arm));
        let force = at_com * -self.mass_kg;
        let torque = -(inertia * alpha + omega.cross(&(inertia * omega))) + com.cross(&force);
        stack(&force, &torque)
    }
}

/// `[force; torque]`.
pub(crate) fn stack(force: &Vector3<f64>, torque: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
}

/// First three components.
pub(crate) fn linear(v: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(v[0], v[1], v[2])
}

/// Last three components.
pub(crate) fn angular(v: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(v[3], v[4], v[5])
}

/// Rows to matrix.
pub(crate) fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}
