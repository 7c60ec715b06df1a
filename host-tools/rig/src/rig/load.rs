//! What hangs on the sensor: contact, weight and inertia of the tool, as they are, which may differ
//! from what anybody believes.

use super::checks::{check_all, prefixed};
use super::hidden;
use super::settings::RigSettings;
use anyhow::Result;
use nalgebra::Vector3;
use softdock_control::effects::sensor::base_tilt::BaseTilt;
use softdock_control::effects::sensor::tool_com_error::ToolComError;
use softdock_control::effects::sensor::tool_gravity::ToolGravity;
use softdock_control::effects::sensor::tool_inertia::{LoadMotion, ToolInertia};
use softdock_control::effects::sensor::tool_mass_error::ToolMassError;
use softdock_control::frames::{Pose, Twist, Wrench, orientation_from_abc, vector};

/// What the load does at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    pub(super) c_from_m: Pose<f64>,
    /// Of walls, guide and cables at M, in M axes.
    pub(super) contact: Wrench<f64>,
    pub(super) twist: Twist<f64>,
    /// Linear in C, angular in M; per second.
    pub(super) acceleration: Twist<f64>,
}

/// The tool on the sensor.
#[derive(Clone, Debug)]
pub(super) struct ToolLoad {
    s_from_m: Pose<f64>,
    /// Origin of S in M, m.
    position: Vector3<f64>,
    /// As it is: with the hidden tilt of the base, m/s².
    gravity: Vector3<f64>,
    weight: ToolGravity<f64>,
    mass_error: Option<ToolMassError<f64>>,
    com_error: Option<ToolComError<f64>>,
    /// Of the settings, and hidden.
    inertias: Vec<ToolInertia<f64>>,
}

impl ToolLoad {
    pub(super) fn new(settings: &RigSettings) -> Result<Self> {
        let s = &settings.sensor;
        check_all("rig.gravity_m_s2", &settings.gravity_m_s2, -100.0, 100.0)?;
        let rotation = orientation_from_abc(&s.orientation_abc_rad);
        let m_from_s = Pose::from_parts(vector::<f64>(&s.position_m).into(), rotation);
        let weight = ToolGravity::new(s.tool_mass_kg, &s.tool_com_m);
        let inertia = ToolInertia::new(s.tool_mass_kg, &s.tool_com_m, &s.tool_inertia_kg_m2);
        let inertia = prefixed("rig.sensor.tool_", inertia)?;
        let mut inertias: Vec<_> = s.inertial_load.then_some(inertia).into_iter().collect();
        let mut load = Self {
            s_from_m: m_from_s.inverse(),
            position: vector(&s.position_m),
            gravity: vector(&settings.gravity_m_s2),
            weight: prefixed("rig.sensor.tool_", weight)?,
            mass_error: None,
            com_error: None,
            inertias: Vec::new(),
        };
        load.hide(settings, &mut inertias)?;
        load.inertias = inertias;
        Ok(load)
    }

    /// Adds the hidden effects.
    fn hide(&mut self, settings: &RigSettings, inertias: &mut Vec<ToolInertia<f64>>) -> Result<()> {
        let s = &settings.sensor;
        if let Some(tilt) = hidden::find(&settings.hidden, "base_tilt") {
            let [rx_rad, ry_rad] = tilt.values(["rx_rad", "ry_rad"]);
            let tilt = prefixed("rig.hidden base_tilt.", BaseTilt::new(rx_rad, ry_rad))?;
            self.gravity = tilt.gravity(&self.gravity);
        }
        if let Some(error) = hidden::find(&settings.hidden, "tool_mass_error") {
            let built = ToolMassError::new(error.value("mass_error_kg"), &s.tool_com_m);
            self.mass_error = Some(prefixed("rig.hidden tool_mass_error.", built)?);
        }
        if let Some(error) = hidden::find(&settings.hidden, "tool_com_error") {
            let error_m = error.values(["com_x_m", "com_y_m", "com_z_m"]);
            let built = ToolComError::new(&error_m, s.tool_mass_kg);
            self.com_error = Some(prefixed("rig.hidden tool_com_error.", built)?);
        }
        if let Some(inertia) = hidden::find(&settings.hidden, "tool_inertia") {
            let mass_kg = inertia.value("mass_kg");
            // The tensor grows with the mass, as that of a tool of the same shape does.
            let share = if s.tool_mass_kg > 0.0 {
                mass_kg / s.tool_mass_kg
            } else {
                1.0
            };
            let tensor = s
                .tool_inertia_kg_m2
                .map(|row| row.map(|moment| moment * share));
            let built = ToolInertia::new(mass_kg, &s.tool_com_m, &tensor);
            inertias.push(prefixed("rig.hidden tool_inertia.", built)?);
        }
        Ok(())
    }

    /// Whether acceleration loads the sensor.
    pub(super) fn has_inertia(&self) -> bool {
        !self.inertias.is_empty()
    }

    /// Contact, weight and inertia at S: the load's reaction.
    pub(super) fn wrench(&self, load: &Load) -> Wrench<f64> {
        let s_from_c = self.s_from_m.rotation * load.c_from_m.rotation.inverse();
        let gravity_in_s = s_from_c * self.gravity;
        let mut wrench =
            load.contact.transferred(&self.s_from_m) + self.weight.wrench(&gravity_in_s);
        if let Some(error) = &self.mass_error {
            wrench = wrench + error.wrench(&gravity_in_s);
        }
        if let Some(error) = &self.com_error {
            wrench = wrench + error.wrench(&gravity_in_s);
        }
        if self.has_inertia() {
            let motion = self.motion_in_s(load);
            for tool in &self.inertias {
                wrench = wrench + tool.wrench(&motion);
            }
        }
        wrench
    }

    fn motion_in_s(&self, load: &Load) -> LoadMotion<f64> {
        let at_m = LoadMotion {
            acceleration: load.c_from_m.rotation.inverse() * load.acceleration.linear,
            angular_velocity: load.twist.angular,
            angular_acceleration: load.acceleration.angular,
        };
        let into_s = |v: Vector3<f64>| self.s_from_m.rotation * v;
        LoadMotion {
            acceleration: into_s(at_m.acceleration_at(&self.position)),
            angular_velocity: into_s(at_m.angular_velocity),
            angular_acceleration: into_s(at_m.angular_acceleration),
        }
    }
}
