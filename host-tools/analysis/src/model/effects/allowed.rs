//! Which parameters an effect of a model file may have.

use crate::model::actuator::Stage;
use crate::model::load::effects::{LoadEffect, Sign};
use softdock_control::effects::Effect;

/// A parameter that an effect may have in a model file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Allowed {
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
    /// It says which form of the effect it is; there is nothing to fit.
    pub choice: bool,
}

/// Parameters that an effect may have: those of the catalogue, and the choices of its form.
pub(crate) fn known(effect: &Effect) -> Vec<Allowed> {
    let mut all: Vec<Allowed> = effect
        .parameters
        .iter()
        .map(|p| Allowed {
            name: p.name,
            unit: p.unit,
            low: p.low,
            high: p.high,
            default: 0.0,
            choice: false,
        })
        .collect();
    let forms = Stage::ALL.into_iter().filter(|s| s.id() == effect.id);
    for name in forms.flat_map(|stage| stage.form()) {
        add(&mut all, Allowed::chosen(name, "-", 0.0, 1.0, 0.0));
    }
    add_rotations(&mut all, effect);
    if effect.id == "manipulator_resistance" {
        add(&mut all, Allowed::chosen("about_start", "-", 0.0, 1.0, 0.0));
    }
    if effect.id == "ft_quantisation" {
        add(&mut all, Allowed::chosen("rounds_down", "-", 0.0, 1.0, 0.0));
    }
    let Some(load) = LoadEffect::find(effect.id) else {
        return all;
    };
    for c in load.coefficients {
        let low = if c.sign == Sign::Free { f64::MIN } else { 0.0 };
        let of = Allowed::chosen(c.name, c.unit, low, f64::MAX, 0.0);
        add(
            &mut all,
            Allowed {
                choice: false,
                ..of
            },
        );
    }
    for shape in load.shapes {
        let least = shape.tried.iter().copied().fold(shape.default, f64::min);
        let most = shape.tried.iter().copied().fold(shape.default, f64::max);
        // What takes any value is not bounded by what a search begins with.
        let most = if shape.continuous { 10.0 * most } else { most };
        let of = Allowed::chosen(shape.name, shape.unit, least, most, shape.default);
        let of = add(&mut all, of);
        of.default = shape.default;
        of.choice = shape.choice;
    }
    all
}

/// Adds the parameters of rotations where a stage has others than for translations, with the same
/// range in their unit.
fn add_rotations(all: &mut Vec<Allowed>, effect: &Effect) {
    let stages = Stage::ALL.into_iter().filter(|s| s.id() == effect.id);
    for stage in stages.filter(|s| s.has_units_of_its_axes()) {
        let pairs = stage.parameters(true).iter().zip(stage.parameters(false));
        for ((name, unit), (linear, _)) in pairs {
            if let Some(of) = all.iter().find(|p| p.name == *linear).copied() {
                add(all, Allowed { name, unit, ..of });
            }
        }
    }
}

/// Adds a parameter; one of the same name keeps the catalogue's range.
fn add(all: &mut Vec<Allowed>, one: Allowed) -> &mut Allowed {
    let place = all.iter().position(|a| a.name == one.name);
    let place = place.unwrap_or_else(|| {
        all.push(one);
        all.len() - 1
    });
    &mut all[place]
}

impl Allowed {
    fn chosen(name: &'static str, unit: &'static str, low: f64, high: f64, default: f64) -> Self {
        Self {
            name,
            unit,
            low,
            high,
            default,
            choice: true,
        }
    }

    /// Whether it may have a value.
    pub(crate) fn holds(&self, value: f64) -> bool {
        value >= self.low && value <= self.high
    }
}
