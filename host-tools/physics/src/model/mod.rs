//! The model of a rig: `model.toml`, the user's own text, and what it predicts.
//!
//! The file holds nominal parameters in SI units; a part that is left out takes the value in
//! [`Model::default`]. [`Model::default_toml`] is a file to start from.

mod board;
pub mod channel;
pub mod clock;
pub mod docking;
pub mod edit;
mod effects;
mod hypothesis;
pub mod load;
pub mod log;
pub mod prediction;
mod sections;
pub mod stage;
#[cfg(test)]
mod tests;
mod tolerance;
mod validation;

pub use channel::{Axis, Channel};
pub use effects::{Allowed, allowed_parameters};
pub use effects::{EffectError, EffectModel, HistoryStep};
pub use hypothesis::{Hypothesis, HypothesisParameter};
pub use sections::{
    ActuatorModel, BodyModel, ContactModel, FilterModel, GuideModel, NoiseModel, RigModel,
    SensorModel, ToolModel, TwoBodyModel, WallModel, WrenchMeaning,
};
pub use tolerance::ToleranceModel;
pub use validation::ModelError;

use crate::effects::{Effect, by_id, hint};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use softdock_control::settings::{DynamicCompensation, SensorSettings};
use softdock_io::input;
use std::path::Path;

/// Nominal model of a rig.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Model {
    /// Axes of the rig that move.
    pub rig: RigModel,
    /// From the velocity that was sent to the velocity that is executed.
    pub actuator: ActuatorModel,
    /// What the docking mechanism touches.
    pub contact: ContactModel,
    /// Everything that the sensor carries.
    pub tool: ToolModel,
    /// The sensor's place and its zero.
    pub sensor: SensorModel,
    /// The two simulated spacecraft.
    pub bodies: TwoBodyModel,
    /// Noise of the measurements by their data sheets.
    pub noise: NoiseModel,
    /// How far the nominal parameters may be off.
    pub tolerance: ToleranceModel,
    /// Effects of the user's own that a diagnosis tries.
    #[serde(rename = "hypothesis", skip_serializing_if = "Vec::is_empty")]
    pub hypotheses: Vec<Hypothesis>,
    /// Physical effects that have been added.
    #[serde(rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectModel>,
    /// The error after each step.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub history: Vec<HistoryStep>,
}

impl Model {
    /// The only active axis, if it is a rotation: the guide is then a bearing.
    pub fn bearing(&self) -> Option<Axis> {
        match self.rig.active_axes.as_slice() {
            [one] if one.is_rotation() => Some(*one),
            _ => None,
        }
    }

    /// Axes of a free swing, under a wrench of zero.
    pub fn free_axes(&self) -> [bool; 6] {
        let is_free = self.sensor.wrench == WrenchMeaning::Free;
        let mut free = [false; 6];
        self.rig
            .active_axes
            .iter()
            .for_each(|axis| free[axis.index()] = is_free);
        free
    }

    /// Nominal moment of inertia about the axis of the bearing, kg·m²; 0 without a bearing.
    pub fn inertia_about_bearing(&self) -> f64 {
        let Some(axis) = self.bearing() else {
            return 0.0;
        };
        let (tool, sensor) = (&self.tool, &self.sensor);
        let [w, x, y, z] = sensor.orientation_wxyz;
        let in_m = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let about = Vector3::ith(axis.index() - 3, 1.0);
        let own = Matrix3::from_fn(|i, k| tool.inertia_kg_m2[i][k]);
        let along = in_m.inverse() * about;
        let com = Vector3::from(sensor.position_m) + in_m * Vector3::from(tool.com_m);
        along.dot(&(own * along)) + tool.mass_kg * about.cross(&com).norm_squared()
    }

    /// The entry of an effect: of the catalogue, or a hypothesis of the user's own.
    ///
    /// # Errors
    ///
    /// There is no effect with this id; the error suggests the nearest one.
    pub fn effect(&self, id: &str) -> Result<&'static Effect, EffectError> {
        let own = self.hypotheses.iter().find(|h| h.id == id);
        match own {
            Some(own) => own.effect(self.bearing().is_some()),
            None => by_id(id).ok_or_else(|| {
                let own = self.hypotheses.iter().map(|h| h.id.as_str());
                EffectError::Unknown {
                    id: id.to_owned(),
                    hint: hint(id, own),
                }
            }),
        }
    }

    /// Turns the sensor about one of its axes.
    pub fn turn_sensor(&mut self, axis: usize, angle_rad: f64) {
        let [w, x, y, z] = self.sensor.orientation_wxyz;
        let turned = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
            * UnitQuaternion::from_scaled_axis(Vector3::ith(axis, angle_rad));
        self.sensor.orientation_wxyz = [turned.w, turned.i, turned.j, turned.k];
    }

    /// Reads and checks a `model.toml`.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, text that is not TOML, an unknown or misspelt key, or a value
    /// out of its range; the error names the place, the value and what is allowed.
    pub fn load(path: &Path) -> anyhow::Result<Self> {
        let model: Self = input::load(path)?;
        model.checked(&path.display().to_string())
    }

    /// Reads and checks the text of a `model.toml`; `name` stands for it in errors.
    ///
    /// # Errors
    ///
    /// Those of [`Model::load`].
    pub fn from_toml(text: &str, name: &str) -> anyhow::Result<Self> {
        let model: Self = input::parse(text, name)?;
        model.checked(name)
    }

    fn checked(self, name: &str) -> anyhow::Result<Self> {
        match self.validate() {
            Ok(()) => Ok(self),
            Err(error) => Err(anyhow::anyhow!("{name}: {error}")),
        }
    }

    /// A commented `model.toml` with every key; it parses to [`Model::default`].
    pub fn default_toml() -> &'static str {
        include_str!("../../../../examples/model.toml")
    }

    /// The model as TOML, every value written out.
    pub fn to_toml(&self) -> String {
        toml_edit::ser::to_string_pretty(self)
            .unwrap_or_else(|error| format!("# the model cannot be written as TOML: {error}\n"))
    }

    /// Sensor and tool in the form that the control crate compensates with.
    pub fn sensor_settings(&self) -> SensorSettings {
        SensorSettings {
            position_m: self.sensor.position_m,
            orientation_wxyz: self.sensor.orientation_wxyz,
            bias: self.sensor.bias,
            gravity_m_s2: self.sensor.gravity_m_s2,
            tool_mass_kg: self.tool.mass_kg,
            tool_com_m: self.tool.com_m,
            tool_inertia_kg_m2: self.tool.inertia_kg_m2,
            dynamic_compensation: if self.tool.dynamic_compensation {
                DynamicCompensation::LoadReaction
            } else {
                DynamicCompensation::Off
            },
            ..SensorSettings::default()
        }
    }
}
