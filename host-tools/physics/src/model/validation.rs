//! Ranges of the values in `model.toml`.

use super::{BodyModel, EffectError, GuideModel, Model, NoiseModel, ToleranceModel, WallModel};
use softdock_control::range::SettingsError;
use softdock_control::settings::Settings;

/// A value in `model.toml` that does not fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A value outside of its range.
    #[error("`{field}` is {received}; allowed is {low} to {high}")]
    OutOfRange {
        /// Dotted name of the field.
        field: String,
        /// The value that was given.
        received: f64,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
    },
    /// A direction without length.
    #[error("`{field}` is [0, 0, 0]; it has to point somewhere, as [1, 0, 0] does")]
    NoDirection {
        /// Dotted name of the field.
        field: String,
    },
    /// An unknown effect, or one with invalid parameters.
    #[error(transparent)]
    Effect(#[from] EffectError),
}

/// A value that the controller would refuse as well, under its name in the model file. `body` is the section of the spacecraft.
fn by_model_name(error: SettingsError, body: &str) -> ModelError {
    let field = error
        .field
        .replacen("sensor.tool_", "tool.", 1)
        .replacen("body_k", body, 1);
    ModelError::OutOfRange {
        field,
        received: error.received,
        low: error.low,
        high: error.high,
    }
}

/// Longest delay, s: more than any robot has.
const LONGEST_S: f64 = 1.0;
/// Largest distance, m.
const FARTHEST_M: f64 = 1e3;
/// Largest stiffness, N/m, and damping, N·s/m.
const STIFFEST: f64 = 1e9;

impl Model {
    /// Checks every value.
    ///
    /// # Errors
    ///
    /// The first value that does not fit, with its name and what is allowed.
    pub fn validate(&self) -> Result<(), ModelError> {
        let actuator = &self.actuator;
        within(
            "actuator.transport_delay_s",
            actuator.transport_delay_s,
            0.0,
            LONGEST_S,
        )?;
        within("actuator.lag_s", actuator.lag_s, 0.0, LONGEST_S)?;
        for (i, wall) in self.contact.walls.iter().enumerate() {
            wall.validate(&format!("contact.walls[{i}]"))?;
        }
        if let Some(guide) = &self.contact.guide {
            guide.validate()?;
        }
        for (i, docking) in self.contact.docking.iter().enumerate() {
            let named = |e: SettingsError| ModelError::OutOfRange {
                field: format!("contact.docking[{i}].{}", e.field),
                received: e.received,
                low: e.low,
                high: e.high,
            };
            docking.validate().map_err(named)?;
        }
        self.noise.validate()?;
        self.tolerance.validate()?;
        if let Some(filter) = &self.sensor.filter {
            within("sensor.filter.order", f64::from(filter.order), 1.0, 8.0)?;
            within("sensor.filter.cutoff_hz", filter.cutoff_hz, 1e-3, 1e4)?;
        }
        for (k, own) in self.hypotheses.iter().enumerate() {
            own.effect(self.bearing().is_some())?;
            if self.hypotheses[..k].iter().any(|other| other.id == own.id) {
                return Err(EffectError::Twice { id: own.id.clone() }.into());
            }
        }
        super::EffectModel::validate_all(self)?;
        self.bodies.k.validate("bodies.k")?;
        self.bodies.q.validate("bodies.q")?;
        // The controller checks sensor and tool with the same ranges.
        let settings = Settings {
            sensor: self.sensor_settings(),
            ..Settings::default()
        };
        settings.validate().map_err(|e| by_model_name(e, "bodies"))
    }
}

impl WallModel {
    fn validate(&self, name: &str) -> Result<(), ModelError> {
        vector(&format!("{name}.point_m"), &self.point_m)?;
        direction(&format!("{name}.normal"), &self.normal)?;
        vector(&format!("{name}.tip_m"), &self.tip_m)?;
        let stiffness = self.stiffness_n_per_m;
        within(
            &format!("{name}.stiffness_n_per_m"),
            stiffness,
            0.0,
            STIFFEST,
        )?;
        let damping = self.damping_n_s_per_m;
        within(&format!("{name}.damping_n_s_per_m"), damping, 0.0, STIFFEST)?;
        let depth = self.damping_depth_m;
        within(&format!("{name}.damping_depth_m"), depth, 0.0, 1.0)
    }
}

impl GuideModel {
    fn validate(&self) -> Result<(), ModelError> {
        direction("contact.guide.axis", &self.axis)?;
        vector("contact.guide.point_m", &self.point_m)?;
        vector("contact.guide.tip_m", &self.tip_m)?;
        let (k, c) = (self.stiffness_n_per_m, self.damping_n_s_per_m);
        within("contact.guide.stiffness_n_per_m", k, 0.0, STIFFEST)?;
        within("contact.guide.damping_n_s_per_m", c, 0.0, STIFFEST)
    }
}

impl BodyModel {
    fn validate(&self, name: &str) -> Result<(), ModelError> {
        // The controller checks masses, tensors and accelerations with the same ranges.
        let mut settings = Settings::default();
        self.apply_to(&mut settings.body_k);
        settings.validate().map_err(|e| by_model_name(e, name))
    }
}

impl NoiseModel {
    fn validate(&self) -> Result<(), ModelError> {
        let sigmas = [
            ("force_n", self.force_n),
            ("torque_n_m", self.torque_n_m),
            ("velocity_m_s", self.velocity_m_s),
            ("rate_rad_s", self.rate_rad_s),
            ("position_m", self.position_m),
            ("angle_rad", self.angle_rad),
            ("model_velocity_m_s", self.model_velocity_m_s),
            ("model_rate_rad_s", self.model_rate_rad_s),
        ];
        sigmas
            .iter()
            .try_for_each(|(key, sigma)| within(&format!("noise.{key}"), *sigma, 1e-12, 1e4))
    }
}

impl ToleranceModel {
    /// None is negative: 0 says that a value is exact.
    fn validate(&self) -> Result<(), ModelError> {
        let sigmas = [
            ("transport_delay_s", Some(self.transport_delay_s)),
            ("lag_s", Some(self.lag_s)),
            ("wall_stiffness_n_per_m", self.wall_stiffness_n_per_m),
            ("wall_damping_n_s_per_m", self.wall_damping_n_s_per_m),
            ("wall_position_m", Some(self.wall_position_m)),
            ("guide_stiffness_n_per_m", self.guide_stiffness_n_per_m),
            ("guide_damping_n_s_per_m", self.guide_damping_n_s_per_m),
            ("guide_position_m", Some(self.guide_position_m)),
            ("docking_share", Some(self.docking_share)),
            ("docking_position_m", Some(self.docking_position_m)),
            ("tool_mass_kg", Some(self.tool_mass_kg)),
            ("tool_com_m", Some(self.tool_com_m)),
            ("tool_inertia_kg_m2", self.tool_inertia_kg_m2),
            ("sensor_position_m", Some(self.sensor_position_m)),
            ("sensor_orientation_rad", Some(self.sensor_orientation_rad)),
            ("body_mass_kg", Some(self.body_mass_kg)),
            ("body_inertia_kg_m2", Some(self.body_inertia_kg_m2)),
        ];
        let bias = self.bias.map(|sigma| ("bias", Some(sigma)));
        sigmas.iter().chain(&bias).try_for_each(|(key, sigma)| {
            let sigma = sigma.unwrap_or_default();
            within(&format!("tolerance.{key}"), sigma, 0.0, STIFFEST)
        })
    }
}

fn within(field: &str, received: f64, low: f64, high: f64) -> Result<(), ModelError> {
    if received >= low && received <= high {
        return Ok(());
    }
    Err(ModelError::OutOfRange {
        field: field.to_owned(),
        received,
        low,
        high,
    })
}

fn vector(field: &str, values: &[f64; 3]) -> Result<(), ModelError> {
    values
        .iter()
        .try_for_each(|v| within(field, *v, -FARTHEST_M, FARTHEST_M))
}

fn direction(field: &str, values: &[f64; 3]) -> Result<(), ModelError> {
    vector(field, values)?;
    if values.iter().all(|v| v.abs() < 1e-9) {
        return Err(ModelError::NoDirection {
            field: field.to_owned(),
        });
    }
    Ok(())
}
