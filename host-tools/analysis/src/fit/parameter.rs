//! Parameters that a fit may move: those of added effects, and nominal parameters within their tolerances.

use super::nominal::nominal;
use super::parameter_id::{ParameterId, Spacecraft};
use nalgebra::Vector3;
use softdock_physics::effects::{Clock, Law, by_id};
use softdock_physics::model::docking;
use softdock_physics::model::edit::rounded;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::{
    Allowed, BodyModel, EffectModel, GuideModel, Model, allowed_parameters,
};

/// Bound of a nominal parameter, and of the range of an effect's, in its SI unit (s, m, N/m ...): far beyond any rig.
const HUGE: f64 = 1e9;
/// Step of a numerical derivative, relative to the value of an effect's parameter.
const RELATIVE_STEP: f64 = 1e-3;
/// The same relative to its range, for a parameter that is zero.
const RANGE_STEP: f64 = 1e-6;
/// Step of a numerical derivative, relative to a tolerance.
const TOLERANCE_STEP: f64 = 0.1;
/// Step of a numerical derivative of the length of a pause, s: the prediction changes in parts of a cycle only.
const PAUSE_STEP_S: f64 = 5e-4;

/// Whether the parameters of an effect are read from the recording directly. Residuals then say nothing about them.
fn is_read_directly(id: &str) -> bool {
    let of_samples = |law: Law| matches!(law, Law::Clock(Clock::Scatter(_)) | Law::Sample(_));
    by_id(id).is_some_and(|effect| of_samples(effect.law))
}

/// A parameter that may move.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its place in the model.
    pub id: ParameterId,
    /// Its name in tables: section and key, or effect and parameter.
    pub name: String,
    /// SI unit, `-` if it has none.
    pub unit: &'static str,
    /// Value in the model file.
    pub value: f64,
    /// Standard deviation of the Gaussian prior, in `unit`; None for a parameter of an effect.
    pub tolerance: Option<f64>,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Step for a numerical derivative.
    pub step: f64,
    /// Changes smaller than this do not change the prediction; 0 for most parameters.
    pub resolution: f64,
    /// Predictions are linear in it: a one-sided difference is the exact slope.
    pub linear: bool,
}

/// Everything in a model that a fit may move.
pub(super) fn all(model: &Model) -> Vec<Parameter> {
    let mut all = Vec::new();
    nominal(model, &mut |id, name, unit, value, tolerance| {
        if tolerance > 0.0 {
            let positive = is_positive(&id);
            all.push(Parameter {
                low: if positive { 0.0 } else { -HUGE },
                high: HUGE,
                step: TOLERANCE_STEP * tolerance,
                resolution: 0.0,
                tolerance: Some(tolerance),
                linear: id.is_linear(),
                id,
                name,
                unit,
                value,
            });
        }
    });
    for (k, effect) in model.effects.iter().enumerate() {
        of_effect(model, k, effect, &mut all);
    }
    all
}

fn of_effect(model: &Model, k: usize, effect: &EffectModel, all: &mut Vec<Parameter>) {
    let Ok(entry) = model.effect(&effect.id) else {
        return;
    };
    if is_read_directly(&effect.id) {
        return;
    }
    for allowed in allowed_parameters(model, entry)
        .into_iter()
        .filter(|p| !p.choice)
    {
        let Some(value) = effect.parameters.get(allowed.name).copied() else {
            continue;
        };
        all.push(Parameter {
            id: ParameterId::Effect(k, allowed.name),
            name: format!("{}.{}", effect.id, allowed.name),
            unit: allowed.unit,
            value,
            tolerance: None,
            low: allowed.low,
            high: allowed.high,
            step: step(&allowed, value),
            linear: allowed.linear,
            resolution: if is_pause(&allowed) {
                PAUSE_STEP_S
            } else {
                0.0
            },
        });
    }
}

fn step(allowed: &Allowed, value: f64) -> f64 {
    if is_pause(allowed) {
        return PAUSE_STEP_S;
    }
    let range = (allowed.high - allowed.low).min(HUGE);
    (RELATIVE_STEP * value.abs()).max(RANGE_STEP * range)
}

fn is_pause(allowed: &Allowed) -> bool {
    allowed.name == "pause_s"
}

/// Whether physics forbids a negative value.
fn is_positive(id: &ParameterId) -> bool {
    !matches!(
        id,
        ParameterId::WallPosition(_)
            | ParameterId::GuidePosition(_)
            | ParameterId::DockingPosition(..)
            | ParameterId::ToolCom(_)
            | ParameterId::Bias(_)
            | ParameterId::SensorPosition(_)
            | ParameterId::SensorOrientation(_)
            | ParameterId::Effect(..)
    )
}

impl Parameter {
    /// Writes the parameter's value into `model`, clamped to its range. A place or an orientation is a shift from the value that
    /// `model` has, which must still be the old one.
    pub fn set(&self, model: &mut Model, value: f64) {
        let value = value.clamp(self.low, self.high);
        let (tool, sensor) = (&mut model.tool, &mut model.sensor);
        match &self.id {
            ParameterId::TransportDelay => model.actuator.transport_delay_s = value,
            ParameterId::Lag => model.actuator.lag_s = value,
            ParameterId::WallStiffness(i) => model.contact.walls[*i].stiffness_n_per_m = value,
            ParameterId::WallDamping(i) => model.contact.walls[*i].damping_n_s_per_m = value,
            ParameterId::WallPosition(i) => {
                let wall = &mut model.contact.walls[*i];
                let shift = Vector3::from(wall.normal).normalize() * value;
                wall.point_m = (Vector3::from(wall.point_m) + shift).into();
            }
            ParameterId::GuideStiffness => with_guide(model, |g| g.stiffness_n_per_m = value),
            ParameterId::GuideDamping => with_guide(model, |g| g.damping_n_s_per_m = value),
            ParameterId::GuidePosition(i) => with_guide(model, |g| g.point_m[*i] = value),
            ParameterId::Docking(i, pointer) => {
                docking::set(&mut model.contact.docking[*i], pointer, value);
            }
            ParameterId::DockingPosition(i, axis) => {
                model.contact.docking[*i].position_m[*axis] = value;
            }
            ParameterId::ToolMass => tool.mass_kg = value,
            ParameterId::ToolCom(i) => tool.com_m[*i] = value,
            ParameterId::ToolInertia(i) => tool.inertia_kg_m2[*i][*i] = value,
            ParameterId::Bias(i) => sensor.bias[*i] = value,
            ParameterId::SensorPosition(i) => sensor.position_m[*i] = value,
            ParameterId::SensorOrientation(i) => model.turn_sensor(*i, value),
            ParameterId::BodyMass(spacecraft) => body_of(model, *spacecraft).mass_kg = Some(value),
            ParameterId::BodyInertia(spacecraft, i) => {
                if let Some(inertia) = &mut body_of(model, *spacecraft).inertia_kg_m2 {
                    inertia[*i][*i] = value;
                }
            }
            ParameterId::Effect(k, name) => {
                let effect = &mut model.effects[*k];
                effect.parameters.insert((*name).to_owned(), value);
            }
        }
    }

    /// The same for a model that is written to a file: shifted places and orientations are rounded to significant digits.
    pub(super) fn write(&self, model: &mut Model, value: f64) {
        self.set(model, value);
        match self.id {
            ParameterId::WallPosition(i) => {
                let point_m = &mut model.contact.walls[i].point_m;
                *point_m = point_m.map(rounded);
            }
            ParameterId::SensorOrientation(_) => {
                let turned = &mut model.sensor.orientation_wxyz;
                *turned = turned.map(rounded);
            }
            _ => {}
        }
    }

    /// Whether the parameter is one of tool or sensor. The rig's controller has its own copy of these, from which it computes the
    /// model velocity.
    pub(super) fn is_of_the_reading(&self) -> bool {
        matches!(
            self.id,
            ParameterId::ToolMass
                | ParameterId::ToolCom(_)
                | ParameterId::ToolInertia(_)
                | ParameterId::Bias(_)
                | ParameterId::SensorPosition(_)
                | ParameterId::SensorOrientation(_)
        )
    }

    /// Bounds a delay of a commanded load to `latest_s`, or to its own value if that is larger. With a longer delay too few rows
    /// of a log are predicted.
    pub(super) fn no_later_than(&mut self, latest_s: f64, model: &Model) {
        let ParameterId::Effect(k, _) = self.id else {
            return;
        };
        let effect = model.effects.get(k);
        let effect = effect.and_then(|effect| LoadEffect::find(model, &effect.id));
        if model.sensor.wrench.is_commanded() && effect.is_some_and(LoadEffect::is_a_delay) {
            self.high = self.high.min(latest_s.max(self.value));
        }
    }

    /// Stores the 95 % interval of an effect's parameter in the model; no other parameter has one there.
    pub(super) fn set_interval(&self, model: &mut Model, interval: [f64; 2]) {
        if let ParameterId::Effect(k, name) = &self.id {
            let effect = &mut model.effects[*k];
            effect.interval_95.insert((*name).to_owned(), interval);
        }
    }
}

fn with_guide(model: &mut Model, change: impl FnOnce(&mut GuideModel)) {
    if let Some(guide) = &mut model.contact.guide {
        change(guide);
    }
}

fn body_of(model: &mut Model, spacecraft: Spacecraft) -> &mut BodyModel {
    match spacecraft {
        Spacecraft::K => &mut model.bodies.k,
        Spacecraft::Q => &mut model.bodies.q,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lag of 0.5 s and a delay of 20 ms with `latest_s` = 0.3 s: upper bounds of both, s, with a measured and a commanded
    /// wrench.
    #[test]
    fn a_delay_leaves_most_of_a_log_and_a_lag_all_of_it() {
        for (wrench, lag_s, delay_s) in [("measured", 10.0, 10.0), ("commanded", 10.0, 0.3)] {
            let text = format!(
                "sensor = {{ wrench = \"{wrench}\" }}\n\
                 [[effect]]\nid = \"actuation_lag\"\nparameters = {{ extra_lag_s = 0.5 }}\n\
                 [[effect]]\nid = \"actuation_delay\"\nparameters = {{ extra_delay_s = 0.02 }}\n"
            );
            let model = Model::from_toml(&text, "model.toml").unwrap();
            let mut parameters = all(&model);
            parameters
                .iter_mut()
                .for_each(|one| one.no_later_than(0.3, &model));
            let high = |name: &str| parameters.iter().find(|one| one.name == name).unwrap().high;
            let found = (
                high("actuation_lag.extra_lag_s"),
                high("actuation_delay.extra_delay_s"),
            );
            assert_eq!(found, (lag_s, delay_s), "{wrench}");
        }
    }
}
