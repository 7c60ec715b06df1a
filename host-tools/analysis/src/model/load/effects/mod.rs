//! Effects on the sensor's reading, in the form that prediction and fit share.
//!
//! An effect is a sum of coefficients times columns; the columns depend on a few shape parameters
//! that do not enter linearly. With the parameters given, the sum is the effect's part of the
//! reading; with the parameters unknown, the columns are the regressors of a fit.

mod contact;
mod guide;
mod known;
mod parameters;
mod reading;

pub(crate) use known::add_known;
pub(crate) use parameters::turn;

use super::{Column, Scene};
use crate::import::filter::LowPass;
use crate::model::Model;
use std::collections::BTreeMap;

/// What a coefficient may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Any sign.
    Free,
    /// Not negative: physics forbids it.
    Positive,
    /// The column is the whole effect: its coefficient is 1.
    One,
}

/// A parameter that multiplies a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficient {
    /// Name with unit, as in the catalogue.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// What it may be.
    pub sign: Sign,
}

/// A parameter that shapes the columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Name with unit.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Values that a search tries.
    pub tried: &'static [f64],
    /// Value where a model file does not give one.
    pub default: f64,
    /// It is a choice of form, not a physical size that matters: it has no interval.
    pub choice: bool,
    /// It takes any value between those that are tried.
    pub continuous: bool,
}

/// An effect on the reading.
#[derive(Clone, Copy)]
pub struct LoadEffect {
    /// Id in the catalogue.
    pub id: &'static str,
    /// Parameters that multiply the columns, in their order.
    pub coefficients: &'static [Coefficient],
    /// Parameters that shape the columns.
    pub shapes: &'static [Shape],
    /// Columns may be left out: each is a part of its own.
    pub separable: bool,
    /// The columns; None if the log or the model has nothing for the effect to act on.
    pub build: fn(&Scene, &[f64]) -> Option<Vec<Column>>,
}

impl LoadEffect {
    /// All of them; where two explain a log equally well, the earlier one is named.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        guide::EFFECTS
            .iter()
            .chain(contact::EFFECTS)
            .chain(parameters::EFFECTS)
            .chain(reading::EFFECTS)
    }

    /// By its id.
    pub fn find(id: &str) -> Option<&'static Self> {
        Self::all().find(|effect| effect.id == id)
    }

    /// Whether it changes the reading as a whole, whatever loads the sensor.
    pub fn acts_on_reading(&self) -> bool {
        reading::EFFECTS.iter().any(|effect| effect.id == self.id)
    }

    /// The columns as they stand in the log, through the filter of its import if it had one. The
    /// reading itself has been through the filter already.
    pub fn columns(&self, scene: &Scene, shapes: &[f64]) -> Option<Vec<Column>> {
        Some(self.filtered(scene, (self.build)(scene, shapes)?))
    }

    /// The columns around given coefficients: times these they are the effect exactly, also where
    /// it is not linear in them.
    pub fn columns_at(
        &self,
        scene: &Scene,
        shapes: &[f64],
        coefficients: &[f64],
    ) -> Option<Vec<Column>> {
        let first = coefficients.first().copied().unwrap_or(0.0);
        match contact::exact(self.id, scene, shapes, first) {
            Some(column) => Some(self.filtered(scene, vec![column])),
            None => self.columns(scene, shapes),
        }
    }

    /// Whether its columns depend on its coefficients.
    pub fn is_linear(&self) -> bool {
        !contact::EFFECTS.iter().any(|effect| effect.id == self.id)
    }

    /// Whether a coefficient is out of what the rig can be: beyond the plausible range of the
    /// catalogue, or a part of a tool that weighs more.
    pub fn is_implausible(&self, model: &Model, name: &str, value: f64) -> bool {
        /// Least share of the weighed tool that can be what is accelerated.
        const OF_THE_TOOL: f64 = 0.5;
        let known = softdock_control::effects::by_id(self.id);
        let known = known.and_then(|e| e.parameters.iter().find(|p| p.name == name));
        let part = self.id == "tool_inertia" && value < OF_THE_TOOL * model.tool.mass_kg;
        part || known.is_some_and(|p| !p.is_plausible(value))
    }

    fn filtered(&self, scene: &Scene, mut columns: Vec<Column>) -> Vec<Column> {
        let filter = scene.model.sensor.filter;
        if let Some(filter) = filter.filter(|_| !self.acts_on_reading()) {
            let filter = LowPass::new(filter.order, filter.cutoff_hz * scene.cycle_s);
            let all = columns.iter_mut().flat_map(|column| &mut column.0);
            for series in all.filter(|series| !series.is_empty()) {
                *series = filter.zero_phase(series);
            }
        }
        columns
    }

    /// Part of the reading, with parameters from a model file; what is left out is 0 or default.
    pub fn contribution(&self, scene: &Scene, parameters: &BTreeMap<String, f64>) -> [Vec<f64>; 6] {
        let shapes: Vec<f64> = self
            .shapes
            .iter()
            .map(|shape| parameters.get(shape.name).copied().unwrap_or(shape.default))
            .collect();
        let factors: Vec<f64> = self
            .coefficients
            .iter()
            .map(|coefficient| match coefficient.sign {
                Sign::One => 1.0,
                _ => parameters.get(coefficient.name).copied().unwrap_or(0.0),
            })
            .collect();
        let mut sum = std::array::from_fn(|_| vec![0.0; scene.len()]);
        let columns = self.columns_at(scene, &shapes, &factors);
        for (k, column) in columns.unwrap_or_default().iter().enumerate() {
            // A column without a coefficient is the whole effect.
            column.add_to(factors.get(k).copied().unwrap_or(1.0), &mut sum);
        }
        sum
    }
}

const fn positive(name: &'static str, unit: &'static str) -> Coefficient {
    Coefficient {
        name,
        unit,
        sign: Sign::Positive,
    }
}

const fn free(name: &'static str, unit: &'static str) -> Coefficient {
    Coefficient {
        name,
        unit,
        sign: Sign::Free,
    }
}

const fn shape(
    name: &'static str,
    unit: &'static str,
    tried: &'static [f64],
    default: f64,
) -> Shape {
    Shape {
        name,
        unit,
        tried,
        default,
        choice: false,
        continuous: true,
    }
}

const fn choice(
    name: &'static str,
    unit: &'static str,
    tried: &'static [f64],
    default: f64,
) -> Shape {
    Shape {
        name,
        unit,
        tried,
        default,
        choice: true,
        continuous: false,
    }
}

/// A choice of form that has a size.
const fn form_size(
    name: &'static str,
    unit: &'static str,
    tried: &'static [f64],
    default: f64,
) -> Shape {
    Shape {
        continuous: true,
        ..choice(name, unit, tried, default)
    }
}
