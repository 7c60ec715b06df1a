//! `meta.json` of docking-rig-log/1: the nominal model and the names of the logs.

use super::FORMAT;
use anyhow::{Context, bail, ensure};
use serde::Deserialize;
use serde_json::{Map, Value};

/// Fields that this program does not know, kept to be named.
type Unknown = Map<String, Value>;

/// The whole file.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Meta {
    /// Checked before the rest is read.
    #[serde(rename = "format")]
    _format: String,
    #[serde(default)]
    pub(super) case: Option<String>,
    pub(super) sample_time_s: f64,
    /// 1 for each axis that moves: x y z rx ry rz.
    pub(super) dof_mask: [f64; 6],
    pub(super) gravity_m_s2: [f64; 3],
    pub(super) spacecraft: Spacecraft,
    pub(super) tool: Tool,
    pub(super) ft_sensor: Sensor,
    pub(super) geometry: Geometry,
    #[serde(default)]
    pub(super) contact: Option<Contact>,
    pub(super) actuator: Actuator,
    pub(super) noise_sigma: Noise,
    #[serde(default)]
    pub(super) tolerance: Option<Map<String, Value>>,
    #[serde(default)]
    pub(super) logs: Logs,
    #[serde(flatten)]
    unknown: Unknown,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Spacecraft {
    pub(super) mass_kg: f64,
    pub(super) inertia_kg_m2: [[f64; 3]; 3],
    #[serde(flatten)]
    unknown: Unknown,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Tool {
    pub(super) mass_kg: f64,
    /// From the origin of the sensor.
    pub(super) com_m: [f64; 3],
    pub(super) inertia_kg_m2: [[f64; 3]; 3],
    #[serde(default)]
    pub(super) dynamic_compensation: bool,
    #[serde(flatten)]
    unknown: Unknown,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Sensor {
    pub(super) bias: [f64; 6],
    /// Measuring ranges say nothing about the model; they are known, not used.
    #[serde(default, rename = "range_force_N")]
    _range_force: Option<Value>,
    #[serde(default, rename = "range_torque_Nm")]
    _range_torque: Option<Value>,
    #[serde(flatten)]
    unknown: Unknown,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Geometry {
    pub(super) r_tip_m: [f64; 3],
    pub(super) r_sensor_m: [f64; 3],
    #[serde(rename = "sensor_rotation_M_from_S", default)]
    pub(super) m_from_s: Rotation,
    #[serde(flatten)]
    unknown: Unknown,
}

/// Orientation of the sensor in M.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum Rotation {
    /// "identity" is the only word.
    Word(String),
    /// w x y z.
    Quaternion([f64; 4]),
    /// Rows.
    Matrix([[f64; 3]; 3]),
}

/// By hand: serde's untagged enums cannot read the numbers of a serde_json that keeps their digits,
/// as the decoder of the board's log asks it to.
impl TryFrom<Value> for Rotation {
    type Error = &'static str;

    fn try_from(value: Value) -> Result<Self, Self::Error> {
        if let Value::String(word) = value {
            return Ok(Self::Word(word));
        }
        let quaternion = serde_json::from_value(value.clone()).map(Self::Quaternion);
        quaternion
            .or_else(|_| serde_json::from_value(value).map(Self::Matrix))
            .map_err(
                |_| "expected \"identity\", a quaternion [w, x, y, z] or a matrix of three rows",
            )
    }
}

impl Default for Rotation {
    fn default() -> Self {
        Self::Word("identity".to_owned())
    }
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Contact {
    #[serde(default)]
    pub(super) law: Option<String>,
    #[serde(rename = "k_n_N_m")]
    pub(super) normal_stiffness: f64,
    #[serde(rename = "c_n_Ns_m", default)]
    pub(super) normal_damping: f64,
    #[serde(rename = "k_t_N_m", default)]
    pub(super) lateral_stiffness: f64,
    #[serde(rename = "c_t_Ns_m", default)]
    pub(super) lateral_damping: f64,
    #[serde(default)]
    pub(super) delta_c_m: f64,
    #[serde(default)]
    pub(super) x_front_m: Option<f64>,
    #[serde(default)]
    pub(super) x_aft_m: Option<f64>,
    #[serde(flatten)]
    unknown: Unknown,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Actuator {
    pub(super) transport_delay_s: f64,
    pub(super) lag_time_constant_s: f64,
    #[serde(flatten)]
    unknown: Unknown,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Noise {
    #[serde(rename = "force_N")]
    pub(super) force_n: f64,
    #[serde(rename = "torque_Nm")]
    pub(super) torque_n_m: f64,
    pub(super) velocity_m_s: f64,
    pub(super) rate_rad_s: f64,
    pub(super) position_m: f64,
    pub(super) angle_rad: f64,
    #[serde(flatten)]
    unknown: Unknown,
}

/// Names of the logs in the folder.
#[derive(Clone, Debug, Deserialize)]
#[serde(default)]
pub(super) struct Logs {
    pub(super) train: String,
    pub(super) test: String,
    #[serde(flatten)]
    unknown: Unknown,
}

impl Default for Logs {
    fn default() -> Self {
        Self {
            train: "train.csv".to_owned(),
            test: "test.csv".to_owned(),
            unknown: Unknown::new(),
        }
    }
}

impl Meta {
    /// Reads the text of a `meta.json`.
    ///
    /// # Errors
    ///
    /// Text that is not JSON, another format, a missing or wrong field.
    pub(super) fn parse(text: &str) -> anyhow::Result<Self> {
        let value: Value = serde_json::from_str(text).context("meta.json: not valid JSON")?;
        match value.get("format").and_then(Value::as_str) {
            Some(FORMAT) => {}
            Some(other) => bail!("meta.json: expected format `{FORMAT}`, received `{other}`"),
            None => bail!("meta.json: expected the field `format` with the value `{FORMAT}`"),
        }
        let meta: Self = serde_json::from_value(value)
            .context("meta.json: a field is missing or is not what docking-rig-log/1 says it is")?;
        let (received, allowed) = (meta.sample_time_s, 1e-6..=10.0);
        ensure!(
            allowed.contains(&received),
            "meta.json: `sample_time_s` is {received}; allowed is {} to {} s",
            allowed.start(),
            allowed.end()
        );
        Ok(meta)
    }

    /// Names of the fields that were not understood, with their section.
    pub(super) fn unknown_fields(&self) -> Vec<String> {
        let mut sections: Vec<(&str, &Unknown)> = vec![
            ("", &self.unknown),
            ("spacecraft.", &self.spacecraft.unknown),
            ("tool.", &self.tool.unknown),
            ("ft_sensor.", &self.ft_sensor.unknown),
            ("geometry.", &self.geometry.unknown),
            ("actuator.", &self.actuator.unknown),
            ("noise_sigma.", &self.noise_sigma.unknown),
            ("logs.", &self.logs.unknown),
        ];
        sections.extend(self.contact.as_ref().map(|c| ("contact.", &c.unknown)));
        sections
            .into_iter()
            .flat_map(|(section, fields)| fields.keys().map(move |key| format!("{section}{key}")))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_orientation_is_a_word_a_quaternion_or_a_matrix() {
        let read = |text: &str| serde_json::from_str::<Rotation>(text);
        assert!(matches!(read("\"identity\""), Ok(Rotation::Word(_))));
        let quaternion = read("[0.5, 0.5, -0.5, 1]").unwrap();
        assert!(matches!(
            quaternion,
            Rotation::Quaternion([0.5, 0.5, -0.5, 1.0])
        ));
        let matrix = read("[[1, 0, 0], [0, 1, 0], [0, 0, 1.0]]").unwrap();
        assert!(matches!(matrix, Rotation::Matrix([_, _, [0.0, 0.0, 1.0]])));
        let error = read("[1, 2]").unwrap_err().to_string();
        assert!(error.contains("a quaternion [w, x, y, z]"), "{error}");
    }
}
