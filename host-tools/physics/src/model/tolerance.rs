//! How far nominal parameters may be off: one standard deviation each.
//!
//! A diagnosis lets every nominal parameter move within its tolerance, as a Gaussian prior, before it names a missing effect: 10
//! g of tool mass that nobody weighed are not a finding.

use super::WallModel;
use serde::{Deserialize, Serialize};

/// Default relative tolerance of a stiffness: what a force-displacement measurement reaches.
const STIFFNESS: f64 = 3e-3;
/// Default relative tolerance of a damping, which is known worse than a stiffness.
const DAMPING: f64 = 1e-2;
/// Default relative tolerance of an inertia tensor taken from a CAD model.
const INERTIA: f64 = 1e-2;

/// One standard deviation of each nominal parameter, in the parameter's own unit. What is left
/// out has a default; 0 says that the value is exact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ToleranceModel {
    /// Of `actuator.transport_delay_s`, s.
    pub transport_delay_s: f64,
    /// Of `actuator.lag_s`, s.
    pub lag_s: f64,
    /// Of every wall's stiffness, N/m; left out: 0.3 % of each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_stiffness_n_per_m: Option<f64>,
    /// Of every wall's damping, N·s/m; left out: 1 % of each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_damping_n_s_per_m: Option<f64>,
    /// Of every wall's position along its normal, m.
    pub wall_position_m: f64,
    /// Of the guide's stiffness, N/m; left out: 0.3 % of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guide_stiffness_n_per_m: Option<f64>,
    /// Of the guide's damping, N·s/m; left out: 1 % of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guide_damping_n_s_per_m: Option<f64>,
    /// Of the guide's centre line, m.
    pub guide_position_m: f64,
    /// Of stiffnesses, dampings, forces and friction of docking mechanisms: a share of each.
    pub docking_share: f64,
    /// Of the place of each docking mechanism, m.
    pub docking_position_m: f64,
    /// Of `tool.mass_kg`, kg.
    pub tool_mass_kg: f64,
    /// Of each component of `tool.com_m`, m.
    pub tool_com_m: f64,
    /// Of each diagonal element of `tool.inertia_kg_m2`, kg·m²; left out: 1 % of each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool_inertia_kg_m2: Option<f64>,
    /// Of the sensor's zero: three forces (N), three torques (N·m).
    pub bias: [f64; 6],
    /// Of the sensor's position along each axis of M, m.
    pub sensor_position_m: f64,
    /// Of the sensor's orientation about each axis, rad.
    pub sensor_orientation_rad: f64,
    /// Of the masses of the simulated spacecraft, kg. They are numbers in a program: exact.
    pub body_mass_kg: f64,
    /// Of the diagonal elements of their inertia tensors, kg·m².
    pub body_inertia_kg_m2: f64,
}

impl Default for ToleranceModel {
    fn default() -> Self {
        Self {
            transport_delay_s: 5e-5,
            lag_s: 5e-5,
            wall_stiffness_n_per_m: None,
            wall_damping_n_s_per_m: None,
            wall_position_m: 1e-5,
            guide_stiffness_n_per_m: None,
            guide_damping_n_s_per_m: None,
            guide_position_m: 1e-5,
            docking_share: 1e-2,
            docking_position_m: 1e-5,
            tool_mass_kg: 0.005,
            tool_com_m: 5e-5,
            tool_inertia_kg_m2: None,
            bias: [0.05, 0.05, 0.05, 0.005, 0.005, 0.005],
            sensor_position_m: 0.0,
            sensor_orientation_rad: 0.0,
            body_mass_kg: 0.0,
            body_inertia_kg_m2: 0.0,
        }
    }
}

impl ToleranceModel {
    /// Tolerance of the stiffness of a wall, N/m.
    pub fn wall_stiffness(&self, wall: &WallModel) -> f64 {
        self.wall_stiffness_n_per_m
            .unwrap_or(STIFFNESS * wall.stiffness_n_per_m)
    }

    /// Tolerance of the damping of a wall, N·s/m.
    pub fn wall_damping(&self, wall: &WallModel) -> f64 {
        self.wall_damping_n_s_per_m
            .unwrap_or(DAMPING * wall.damping_n_s_per_m)
    }

    /// Tolerance of the stiffness of the guide, N/m.
    pub fn guide_stiffness(&self, stiffness_n_per_m: f64) -> f64 {
        self.guide_stiffness_n_per_m
            .unwrap_or(STIFFNESS * stiffness_n_per_m)
    }

    /// Tolerance of the damping of the guide, N·s/m.
    pub fn guide_damping(&self, damping_n_s_per_m: f64) -> f64 {
        self.guide_damping_n_s_per_m
            .unwrap_or(DAMPING * damping_n_s_per_m)
    }

    /// Tolerance of a diagonal element of the tool's inertia, kg·m².
    pub fn tool_inertia(&self, moment_kg_m2: f64) -> f64 {
        self.tool_inertia_kg_m2.unwrap_or(INERTIA * moment_kg_m2)
    }
}
