//! Change of the sensor's reading over a log by effects on its load, single ones and several together.

use super::effects::{LEVEL, LoadEffect};
use super::{Column, Scene, filtered, laws};
use crate::effects::{Actuator, Law, Role, Values};
use crate::model::{EffectModel, Model};
use std::collections::BTreeMap;
use std::sync::Arc;

impl LoadEffect {
    /// The columns at some places as they appear in the log, through the filter of its import if it had one; `None` if log or
    /// model have nothing on which they act.
    pub fn columns(&self, scene: &Scene, shapes: &[f64], places: &[usize]) -> Option<Vec<Column>> {
        if !self.acts(scene) {
            return None;
        }
        let column = |k: &usize| match self.coefficients.is_empty() {
            true => self.part(scene, &self.values(shapes, &[])),
            false => self.slope(shapes, *k, |p| self.part(scene, p)),
        };
        let columns: Option<Vec<Column>> = places.iter().map(column).collect();
        columns.filter(|columns| !columns.iter().all(Column::is_zero))
    }

    /// Load of the sensor per unit of its coefficients at some places; `None` if it acts on the whole reading, or is not linear
    /// in its coefficients.
    pub fn unit_loads(
        &self,
        scene: &Scene,
        shapes: &[f64],
        places: &[usize],
    ) -> Option<Vec<Column>> {
        if self.acts_on_reading() || !self.is_linear() || self.coefficients.is_empty() {
            return None;
        }
        let change = |p: &[f64]| Some(self.change_if_any(scene, &scene.reading, p));
        let slopes = places.iter().map(|k| self.slope(shapes, *k, change));
        slopes.collect()
    }

    /// Whether a friction changes its sign over so large a speed that it never reaches its level, or over so long a distance: it
    /// could not be distinguished from a viscous friction, or from a spring.
    pub fn never_reaches_its_level(&self, scene: &Scene, shapes: &[f64]) -> bool {
        if self.needs_stroke(shapes) > scene.usual_stroke() {
            return true;
        }
        let Some((law, speed)) = self.turns_over_speed(shapes) else {
            return false;
        };
        LEVEL * speed > scene.rms_speed() || self.fades_as_it_turns(law, speed, shapes)
    }

    /// The columns at given coefficients: multiplied by these they give the effect exactly, also if it is not linear in its only
    /// coefficient.
    pub fn columns_at(
        &self,
        scene: &Scene,
        shapes: &[f64],
        places: &[usize],
        coefficients: &[f64],
    ) -> Option<Vec<Column>> {
        let alone = self.coefficients.len() == 1 && !self.is_linear();
        match coefficients {
            [one] if *one != 0.0 && alone && self.acts(scene) => {
                let mut part = self.part(scene, &self.values(shapes, coefficients))?;
                part.scale(1.0 / one);
                Some(vec![part])
            }
            _ => self.columns(scene, shapes, places),
        }
    }

    /// Its part of the reading with parameters from a model file; missing ones are 0 or their default.
    pub fn contribution(&self, scene: &Scene, parameters: &BTreeMap<String, f64>) -> Column {
        contribution(scene, &[(self, self.values_or_defaults(parameters))])
    }

    /// Difference quotient of a part with respect to a coefficient, at zero. Its step, a millionth of the plausible range, is a
    /// power of two, so that a linear part has no rounding error.
    fn slope(
        &self,
        shapes: &[f64],
        k: usize,
        part: impl Fn(Values<'_>) -> Option<Column>,
    ) -> Option<Column> {
        let mut linear = self
            .effect
            .parameters
            .iter()
            .filter(|p| p.role == Role::Linear);
        let parameter = linear.nth(k)?;
        let step = (1e-6 * (parameter.high - parameter.low))
            .log2()
            .floor()
            .exp2();
        let mut coefficients = vec![0.0; self.coefficients.len()];
        coefficients[k] = step;
        let mut slope = part(&self.values(shapes, &coefficients))?;
        slope.scale(1.0 / step);
        Some(slope)
    }

    /// Change of the reading by the effect; `None` for forms that exclude each other.
    fn part(&self, scene: &Scene, p: Values<'_>) -> Option<Column> {
        let part = self.change(scene, &scene.reading, p)?;
        Some(match self.acts_on_reading() {
            true => scene.on_measured_axes(part),
            false => as_read(scene, part, &[]),
        })
    }

    /// Its change of a reading that includes the effects before it.
    fn change(&self, scene: &Scene, reading: &Column, p: Values<'_>) -> Option<Column> {
        let part = laws::part(scene, reading, self.effect, p)?;
        Some(match scene.model.sensor.filter {
            Some(filter) if !self.acts_on_reading() => {
                filtered::load(filter, scene, self.effect, p, part)
            }
            _ => part,
        })
    }

    /// The same; zero if the log has nothing on which it acts.
    fn change_if_any(&self, scene: &Scene, reading: &Column, p: Values<'_>) -> Column {
        let change = self
            .acts(scene)
            .then(|| self.change(scene, reading, p))
            .flatten();
        change.unwrap_or_default()
    }
}

/// An effect with its parameters, in the order of the catalogue.
pub type ValuedEffect<'a> = (&'a LoadEffect, Vec<f64>);

/// Change of the reading by effects together, in addition to those of the model.
pub fn contribution(scene: &Scene, effects: &[ValuedEffect<'_>]) -> Column {
    Loaded::by(scene, effects).read()
}

/// Load of the sensor by effects, in addition to those of the model, and the effects among them that act on the whole reading.
pub struct Loaded<'a> {
    scene: &'a Scene,
    load: Column,
    whole: Vec<ValuedEffect<'a>>,
}

impl<'a> Loaded<'a> {
    /// The load and the whole-reading effects among these effects.
    pub fn by(scene: &'a Scene, effects: &[ValuedEffect<'a>]) -> Self {
        let mut load = Column::default();
        for (law, p) in effects.iter().filter(|(law, _)| !law.acts_on_reading()) {
            load.add(&law.change_if_any(scene, &scene.reading, p).0);
        }
        let whole = effects.iter().filter(|(law, _)| law.acts_on_reading());
        Self {
            scene,
            load,
            whole: whole.cloned().collect(),
        }
    }

    /// With a further load.
    pub fn and(mut self, load: Column) -> Self {
        self.load.add(&load.0);
        self
    }

    /// Change of the reading by them.
    pub fn read(&self) -> Column {
        as_read(self.scene, self.load.clone(), &self.whole)
    }

    /// Additional change of the reading by a further effect that acts on the whole reading.
    pub fn added(&self, effect: ValuedEffect<'a>) -> Column {
        let with = [&self.whole[..], &[effect]].concat();
        as_read(self.scene, self.load.clone(), &with).minus(&self.read())
    }
}

/// Change of the reading by a further load. Effects that act on the whole reading (a delay, a gain) act on the total load of the
/// sensor: first those of the model, then `whole`.
fn as_read(scene: &Scene, load: Column, whole: &[ValuedEffect<'_>]) -> Column {
    let known = effects_on_reading(&scene.model, &scene.model.effects);
    if whole.is_empty() && known.iter().all(|(law, _)| !law.acts_on_load()) {
        return scene.on_measured_axes(load);
    }
    let mut reading = scene.load.clone();
    reading.add(&load.0);
    for (law, p) in known.iter().chain(whole) {
        let change = law.change_if_any(scene, &reading, p);
        reading.add(&change.0);
    }
    scene.on_measured_axes(reading.minus(&scene.reading))
}

/// Effects of a model file that act on the whole reading.
fn effects_on_reading(model: &Model, effects: &[EffectModel]) -> Vec<ValuedEffect<'static>> {
    let laws = effects.iter().filter_map(|effect| {
        let law = LoadEffect::find(model, &effect.id)?;
        Some((law, law.values_or_defaults(&effect.parameters)))
    });
    laws.filter(|(law, _)| law.acts_on_reading()).collect()
}

/// Number of samples at the end of a stretch without gaps whose motion lies beyond its end: a drive is commanded a delay before
/// it moves, and a clock may be late.
pub fn beyond_the_end(scene: &Scene) -> usize {
    let known = effects_on_reading(&scene.model, &scene.model.effects).into_iter();
    let acting = known.filter(|(effect, _)| effect.acts(scene));
    let ahead = acting.filter_map(|(effect, p)| match effect.effect.law {
        Law::Actuator(Actuator {
            late: Some(law), ..
        }) => Some(law(&p).delay_s),
        Law::ClockOffset(law) => Some(law(&p)),
        _ => None,
    });
    (ahead.sum::<f64>().max(0.0) / scene.cycle_s).ceil() as usize
}

/// Load of the sensor by each effect of a model. It does not depend on other effects, except through the mass on the sensor, so
/// that models that differ in one effect can share those of the others.
#[derive(Default)]
pub struct LoadOfEach {
    hanging_kg: f64,
    known: Vec<(EffectModel, Arc<Column>)>,
}

impl LoadOfEach {
    /// Loads of the effects of a model file over a log; those in `before` are reused.
    pub fn of(scene: &Scene, effects: &[EffectModel], before: &Self) -> Self {
        let hanging_kg = laws::hanging(&scene.model);
        let same = |effect: &EffectModel| {
            let mut known = before.known.iter();
            let known = known.find(|(other, _)| other == effect);
            let known = known.filter(|_| before.hanging_kg == hanging_kg);
            known.map(|(_, load)| Arc::clone(load))
        };
        let of = |effect: &EffectModel| {
            let law = LoadEffect::find(&scene.model, &effect.id)?;
            let p = law.values_or_defaults(&effect.parameters);
            let load = (!law.acts_on_reading()).then(|| {
                let computed = || law.change_if_any(scene, &scene.reading, &p).into();
                same(effect).unwrap_or_else(computed)
            })?;
            Some((effect.clone(), load))
        };
        Self {
            hanging_kg,
            known: effects.iter().filter_map(of).collect(),
        }
    }
}

/// Adds the effects of a model file to the reading of a scene; loads in `before` are reused. Effects on the whole reading act
/// last, wherever they stand in the file.
pub fn add_known(scene: &mut Scene, effects: &[EffectModel], before: &LoadOfEach) {
    for (_, load) in LoadOfEach::of(scene, effects, before).known {
        scene.reading.add(&load.0);
    }
    scene.load = scene.reading.clone();
    for (law, p) in effects_on_reading(&scene.model, effects) {
        let change = law.change_if_any(scene, &scene.reading, &p);
        scene.reading.add(&change.0);
    }
}
