//! Which parameters an effect of a model file may have.

use crate::effects::{Effect, Role};
use crate::model::Model;
use crate::model::load::effects::LoadEffect;
use crate::model::stage::Stage;

/// A parameter that an effect may have in a model file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowed {
    /// Name with unit.
    pub name: &'static str,
    /// SI unit, `-` if it has none.
    pub unit: &'static str,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Value where the file gives none.
    pub default: f64,
    /// It selects a form of the effect; there is nothing to fit.
    pub choice: bool,
    /// The reading is linear in it.
    pub linear: bool,
}

/// Parameters that an effect may have: those of the catalogue, and the forms of its stages.
pub fn allowed_parameters(model: &Model, effect: &Effect) -> Vec<Allowed> {
    let on_the_reading = LoadEffect::find(model, effect.id);
    let parameters = on_the_reading.map_or(effect.parameters, |load| load.parameters.as_slice());
    let mut all: Vec<Allowed> = parameters
        .iter()
        .map(|p| Allowed {
            name: p.name,
            unit: p.unit,
            low: p.low,
            high: p.high,
            default: p.default(),
            choice: p.is_form(),
            linear: p.role == Role::Linear && on_the_reading.is_some_and(LoadEffect::is_linear),
        })
        .collect();
    let forms = Stage::ALL.into_iter().filter(|s| s.id() == effect.id);
    for name in forms.flat_map(|stage| stage.form()) {
        let (low, high, default) = (0.0, 1.0, 0.0);
        let form = Allowed {
            name,
            unit: "-",
            low,
            high,
            default,
            choice: true,
            linear: false,
        };
        add(&mut all, form);
    }
    add_rotations(&mut all, effect);
    all
}

/// Adds the parameters for rotations where a stage has other ones than for translations, with their own range or the same numbers
/// in their unit.
fn add_rotations(all: &mut Vec<Allowed>, effect: &Effect) {
    let stages = Stage::ALL.into_iter().filter(|s| s.id() == effect.id);
    for stage in stages.filter(|s| s.has_units_of_its_axes()) {
        let pairs = stage.parameters(true).iter().zip(stage.parameters(false));
        for ((name, unit), (linear, _)) in pairs {
            let Some(of) = all.iter().find(|p| p.name == *linear).copied() else {
                continue;
            };
            let catalogued = effect.parameters.iter().find(|p| p.name == *linear);
            let [low, high] = catalogued.map_or([of.low, of.high], |p| p.range(true));
            add(
                all,
                Allowed {
                    name,
                    unit,
                    low,
                    high,
                    ..of
                },
            );
        }
    }
}

/// Adds a parameter, unless there is one of the same name.
fn add(all: &mut Vec<Allowed>, one: Allowed) {
    if all.iter().all(|a| a.name != one.name) {
        all.push(one);
    }
}

impl Allowed {
    /// Whether it may have a value.
    pub fn holds(&self, value: f64) -> bool {
        value >= self.low && value <= self.high
    }
}
