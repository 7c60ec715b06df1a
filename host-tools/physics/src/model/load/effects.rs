//! What the catalogue's laws do to the sensor's reading over a log, for prediction and fit.
//!
//! With all parameters given, an effect is a part of the reading. For a fit, the parts of its linear
//! parameters are columns of a regression; the others shape the columns. Columns are difference
//! quotients of the part itself, so that they cannot disagree with it.

use super::{Column, Scene, laws};
use crate::effects::{
    Actuator, CATALOGUE, Effect, Guide, Kind, Law, Parameter, Reversal, Role, Slide, Values,
};
use crate::model::{EffectModel, FilterModel, Model};
use softdock_statistics::LowPass;
use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Latest that a reading is looked for in logs of 100 Hz and more.
const LATEST_S: f64 = 0.1;
/// The same in cycles, in slower logs.
const LATEST_CYCLES: f64 = 10.0;
/// The same as a share of the shortest log: of what is later too little is left to compare. Set by hand.
const LATEST_SHARE: f64 = 0.25;
/// Share of the usual speed (rms) of the logs at which the fall of a friction has ended: one that still falls beyond it is told
/// neither from one that falls all the way nor from less friction with a higher peak.
const FALLEN: f64 = 0.5;
/// Times the largest speed that is tried up to which a search refines that over which a friction turns round: in the likelihood a
/// slower turn competes with other errors of form, and least squares choose it in the end.
const SHARP: f64 = 10.0;

/// Ratio of a speed to the one over which a friction turns round from which the friction has its level to 3 % (tanh), to which
/// laws are right. One that does not have it at the usual speed is not looked for.
pub const LEVEL: f64 = 2.1;
/// Share of its level that a part of a friction reaches at the least: of less it is not the level that a log tells. Set by hand: an
/// excess that turns round over two thirds of the speed over which it fades has half.
const REACHED: f64 = 0.5;

/// How slow and how fast logs are.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Length of a cycle, where that is longest, s.
    pub cycle_s: f64,
    /// Root mean square of the velocity along the guide, in the log where that is largest, m/s or rad/s.
    pub speed: f64,
    /// Duration of the shortest log, s.
    pub shortest_s: f64,
}

impl Pace {
    /// By how much later than in fast logs a reading is looked for.
    fn slower(self) -> f64 {
        (self.cycle_s * LATEST_CYCLES / LATEST_S).max(1.0)
    }
}

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
#[derive(Clone, Copy, Debug)]
pub struct Coefficient {
    /// Name with unit, as in the catalogue.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// What it may be.
    pub sign: Sign,
    /// It stands for all others at once.
    pub common: bool,
}

/// A parameter that shapes the columns.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Name with unit.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Values that a search tries.
    pub tried: &'static [f64],
    /// It is a choice of form, not a physical size that matters: it has no interval.
    pub choice: bool,
    /// It takes any value between those that are tried.
    pub continuous: bool,
}

/// An effect on the reading.
pub struct LoadEffect {
    /// Its entry.
    pub effect: &'static Effect,
    /// Id in the catalogue.
    pub id: &'static str,
    /// Its parameters, as those of a bearing where it acts on one.
    pub parameters: Vec<Parameter>,
    /// Parameters that multiply the columns, in their order.
    pub coefficients: Vec<Coefficient>,
    /// Parameters that shape the columns.
    pub shapes: Vec<Shape>,
}

/// Those of the catalogue; where two explain a log equally well, the earlier one is named.
static CATALOGUED: LazyLock<Vec<LoadEffect>> = LazyLock::new(|| catalogued(false));
/// The same where the guide is a bearing.
static OF_BEARINGS: LazyLock<Vec<LoadEffect>> = LazyLock::new(|| catalogued(true));
/// Those of hypotheses, by their entries.
static OWN: Mutex<Vec<&'static LoadEffect>> = Mutex::new(Vec::new());

fn catalogued(bearing: bool) -> Vec<LoadEffect> {
    let all = CATALOGUE.iter();
    all.filter_map(|e| LoadEffect::of(e, bearing)).collect()
}

impl LoadEffect {
    /// All of them, in the order of the catalogue, then the model's own hypotheses.
    pub fn all(model: &Model) -> impl Iterator<Item = &'static Self> + '_ {
        let turns = model.bearing().is_some();
        let own = model.hypotheses.iter();
        let own = own.filter_map(move |hypothesis| Self::own(hypothesis.effect(turns).ok()?));
        let catalogued: &'static [Self] = match model.bearing() {
            Some(_) => &OF_BEARINGS,
            None => &CATALOGUED,
        };
        catalogued.iter().chain(own)
    }

    /// By its id.
    pub fn find(model: &Model, id: &str) -> Option<&'static Self> {
        Self::all(model).find(|effect| effect.id == id)
    }

    fn own(entry: &'static Effect) -> Option<&'static Self> {
        let mut own = OWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = own.iter().find(|known| std::ptr::eq(known.effect, entry)) {
            return Some(known);
        }
        let new: &'static Self = Box::leak(Box::new(Self::of(entry, false)?));
        own.push(new);
        Some(new)
    }

    /// None for an effect that does not change the reading, or only its samples.
    fn of(effect: &'static Effect, bearing: bool) -> Option<Self> {
        if matches!(
            effect.law,
            Law::Sample(_)
                | Law::Actuator(Actuator { late: None, .. })
                | Law::Spacecraft(_)
                | Law::Clock(_)
        ) || (effect.is_of_a_bearing() && !bearing)
        {
            return None;
        }
        let parameters: Vec<Parameter> = match bearing {
            true => effect.on_a_bearing(),
            false => effect.parameters.to_vec(),
        };
        let linear = parameters.iter().filter(|p| p.role == Role::Linear);
        let shaping = parameters.iter().filter_map(|p| Some((p, p.tried()?)));
        Some(Self {
            effect,
            id: effect.id,
            coefficients: linear
                .map(|p| Coefficient {
                    name: p.name,
                    unit: p.unit,
                    sign: if p.is_signed() {
                        Sign::Free
                    } else {
                        Sign::Positive
                    },
                    common: p.common,
                })
                .collect(),
            shapes: shaping
                .map(|(p, tried)| Shape {
                    name: p.name,
                    unit: p.unit,
                    tried: tried.values,
                    choice: p.is_form(),
                    continuous: tried.continuous,
                })
                .collect(),
            parameters,
        })
    }

    /// Whether it changes the reading of the sensor and nothing else: neither how a rig moves nor its clocks.
    pub fn is_of_the_reading_alone(&self) -> bool {
        !matches!(self.effect.law, Law::Actuator(_) | Law::Apart(_))
    }

    /// Whether it changes the reading as a whole, whatever loads the sensor.
    pub fn acts_on_reading(&self) -> bool {
        matches!(
            self.effect.law,
            Law::Load(_)
                | Law::Drive(_)
                | Law::Zero(_)
                | Law::Late(_)
                | Law::Apart(_)
                | Law::Range(_)
                | Law::Actuator(_)
        )
    }

    /// Whether what it does depends on what else there is: it acts on what loads the sensor.
    pub fn acts_on_load(&self) -> bool {
        self.acts_on_reading() && !self.is_of_a_zero()
    }

    /// Whether it moves all that loads the sensor in time.
    pub fn is_late(&self) -> bool {
        matches!(
            self.effect.law,
            Law::Late(_) | Law::Apart(_) | Law::Actuator(Actuator { late: Some(_), .. })
        )
    }

    /// Range of a parameter in which a search looks. What is late is late by some cycles of a sensor, a bus or a clock; what is
    /// slower than that is something else.
    pub fn searched(&self, parameter: &Parameter, logs: Pace) -> [f64; 2] {
        let Parameter { low, high, .. } = *parameter;
        let Some(tried) = parameter.tried() else {
            return [low, high];
        };
        let high = high.min(tried.most);
        if self.is_late_reading() {
            let latest = (LATEST_S * logs.slower()).min(LATEST_SHARE * logs.shortest_s);
            return [low, high].map(|end| end.clamp(-latest, latest));
        }
        let is_speed = matches!(parameter.unit, "m/s" | "rad/s");
        match matches!(self.effect.law, Law::Guide(_)) && is_speed {
            true if parameter.is_form() => {
                let largest = tried.values.iter().copied().fold(0.0, f64::max);
                [low, high.min(SHARP * largest)]
            }
            true => [low, high.min(FALLEN * logs.speed).max(low)],
            false => [low, high],
        }
    }

    /// Values of a shape that are tried.
    pub fn tried(&self, shape: &Shape, logs: Pace) -> Vec<f64> {
        let known = self.parameters.iter().find(|p| p.name == shape.name);
        let [low, high] = known.map_or([f64::NEG_INFINITY, f64::INFINITY], |p| {
            self.searched(p, logs)
        });
        let factor = match self.is_late_reading() {
            true => logs.slower(),
            false => 1.0,
        };
        let values = shape.tried.iter().map(|value| factor * value);
        let mut values: Vec<f64> = values.map(|value| value.clamp(low, high)).collect();
        values.dedup();
        values
    }

    /// Whether readings and motion are of different times.
    fn is_late_reading(&self) -> bool {
        self.effect.kind == Some(Kind::LateReading)
    }

    /// Whether it follows the time and nothing else: a zero with a shape, which is how it changes.
    pub fn is_a_drift(&self) -> bool {
        self.is_of_a_zero() && !self.shapes.is_empty()
    }

    /// Whether it is the zero of a sensor.
    pub fn is_of_a_zero(&self) -> bool {
        matches!(self.effect.law, Law::Zero(_))
    }

    /// Whether the log has what it acts on.
    pub fn acts(&self, scene: &Scene) -> bool {
        laws::acts(scene, self.effect)
    }

    /// Whether its columns depend on its coefficients: a wall does not pull, so that where it lifts
    /// off depends on all that pushes.
    pub fn is_linear(&self) -> bool {
        !self.effect.is_of_a_contact() && !matches!(self.effect.law, Law::Docking(_))
    }

    /// Whether coefficients that are known not to be 0 make it what it is: a Stribeck friction of which the excess may be
    /// 0 is a dry one. `is_sure`: of the coefficient of a name.
    pub fn is_determined(&self, is_sure: impl Fn(&str) -> bool) -> bool {
        let names = self.coefficients.iter().enumerate();
        let sure = names.filter(|(_, c)| is_sure(c.name)).map(|(k, _)| k);
        let sure: Vec<usize> = sure.collect();
        self.coefficients.is_empty()
            || (!sure.is_empty() && (self.effect.is_whole)(&sure, &|_| true))
    }

    /// Whether intervals say more of it than that it may not be there: that of any of its amounts leaves out 0, or, where it has
    /// none, that of its time. An effect with amounts and a shape to which they are tied has other judges: of a slow drift only
    /// the slope is known.
    pub fn is_told(&self, is_sure: impl Fn(&str) -> bool) -> bool {
        let mut shapes = self.shapes.iter().filter(|shape| !shape.choice);
        match self.is_late() && self.coefficients.is_empty() {
            true => shapes.any(|shape| is_sure(shape.name)),
            false => shapes.next().is_some() || self.is_determined(is_sure),
        }
    }

    /// Whether it is another, simpler effect without some of its coefficients.
    pub fn may_be_simpler(&self) -> bool {
        let alone = |k: usize| (self.effect.is_whole)(&[k], &|_| true);
        !(0..self.coefficients.len()).all(alone)
    }

    /// Places of all its columns: one of each coefficient, or of the effect as a whole.
    pub fn places(&self) -> Vec<usize> {
        (0..self.coefficients.len().max(1)).collect()
    }

    /// The columns at some places as they stand in the log, through the filter of its import if it had
    /// one; None if the log or the model has nothing for them to act on.
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

    /// What it loads the sensor with by its coefficients at some places if each is 1; None if it acts on the reading as a whole, or if
    /// that is not linear in its coefficients.
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

    /// Whether a friction would change its sign over a speed so large that it never reaches its level: it would be a viscous
    /// one by another name.
    pub fn never_reaches_its_level(&self, scene: &Scene, shapes: &[f64]) -> bool {
        let Some((law, speed)) = self.turns_over_speed(shapes) else {
            return false;
        };
        LEVEL * speed > scene.rms_speed() || self.fades_as_it_turns(law, speed, shapes)
    }

    /// Its law, and the speed over which it turns round, if it does so over a speed.
    fn turns_over_speed(&self, shapes: &[f64]) -> Option<(&Guide, f64)> {
        let (Law::Guide(law) | Law::Bearing(law)) = &self.effect.law else {
            return None;
        };
        match (law.reversal)(&self.values(shapes, &[]))? {
            Reversal::OverSpeed(speed) => Some((law, speed)),
            _ => None,
        }
    }

    /// Whether a part of it (an excess at low speed) is gone before it has [`REACHED`] its level.
    fn fades_as_it_turns(&self, law: &Guide, speed: f64, shapes: &[f64]) -> bool {
        let is_gone = |k: usize| {
            let mut unit = vec![0.0; self.coefficients.len()];
            unit[k] = 1.0;
            let values = self.values(shapes, &unit);
            let largest = |direction: fn(f64) -> f64| {
                let at = |n: u32| {
                    let ratio = 0.1 * f64::from(n);
                    let slide = Slide {
                        direction: direction(ratio),
                        ..Slide::at_velocity(ratio * speed)
                    };
                    (law.force)(&values, &slide).abs()
                };
                (1..=30).map(at).fold(0.0, f64::max)
            };
            largest(f64::tanh) < REACHED * largest(|_| 1.0)
        };
        (0..self.coefficients.len()).any(is_gone)
    }

    /// The columns around given coefficients: times these they are the effect exactly, also where
    /// it is not linear in its only one.
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

    /// Part of the reading, with parameters from a model file; what is left out is 0 or default.
    pub fn contribution(&self, scene: &Scene, parameters: &BTreeMap<String, f64>) -> Column {
        contribution(scene, &[(self, self.given(parameters))])
    }

    /// Whether a coefficient is out of what the rig can be: beyond the plausible range of the
    /// catalogue, a part of a tool that weighs more, or an error that leaves nothing of what it is an error of.
    pub fn is_implausible(&self, model: &Model, name: &str, value: f64) -> bool {
        let known = self.parameters.iter().find(|p| p.name == name);
        known.is_some_and(|p| {
            let nominal = match p.unit {
                "kg" => model.tool.mass_kg,
                _ => model.inertia_about_bearing(),
            };
            !p.is_plausible(value) || (p.of_the_tool != 0.0 && value < p.of_the_tool * nominal)
        })
    }

    /// Values of a model file in the order of the parameters; what is left out has its default.
    pub fn given(&self, values: &BTreeMap<String, f64>) -> Vec<f64> {
        let value = |p: &Parameter| values.get(p.name).copied().unwrap_or(p.default());
        self.parameters.iter().map(value).collect()
    }

    /// Values in the order of the catalogue's parameters.
    pub fn values(&self, shapes: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let (mut shapes, mut coefficients) = (shapes.iter(), coefficients.iter());
        let value = |p: &Parameter| match p.role {
            Role::Linear => coefficients.next(),
            Role::Shape(_) | Role::Form(_) => shapes.next(),
        };
        let given = self.effect.parameters.iter().map(value);
        given.map(|v| v.copied().unwrap_or(0.0)).collect()
    }

    /// Difference quotient of a part by a coefficient, at zero. Its step, a millionth of the plausible
    /// range, is a power of two, so that what is linear has no error of rounding.
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

    /// What the effect does to the reading; None for forms that exclude each other.
    fn part(&self, scene: &Scene, p: Values<'_>) -> Option<Column> {
        let part = self.change(scene, &scene.reading, p)?;
        Some(match self.acts_on_reading() {
            true => scene.shown(part),
            false => as_read(scene, part, &[]),
        })
    }

    /// By how much it changes a reading that has the effects before it.
    fn change(&self, scene: &Scene, reading: &Column, p: Values<'_>) -> Option<Column> {
        let part = laws::part(scene, reading, self.effect, p)?;
        let filtered_already = self.acts_on_reading() || laws::is_proportional(self.effect, p);
        Some(match scene.model.sensor.filter {
            Some(filter) if !filtered_already => through(filter, scene.cycle_s, part),
            _ => part,
        })
    }

    /// The same; nothing where the log has nothing for it to act on.
    fn change_if_any(&self, scene: &Scene, reading: &Column, p: Values<'_>) -> Column {
        let change = self
            .acts(scene)
            .then(|| self.change(scene, reading, p))
            .flatten();
        change.unwrap_or_default()
    }
}

/// An effect with its parameters, in the order of the catalogue.
pub type Valued<'a> = (&'a LoadEffect, Vec<f64>);

/// What effects together do to the reading, beside those that the model knows.
pub fn contribution(scene: &Scene, effects: &[Valued<'_>]) -> Column {
    Loaded::by(scene, effects).read()
}

/// What effects load the sensor with beside those that the model knows, and those of them that act on the reading as a whole.
pub struct Loaded<'a> {
    scene: &'a Scene,
    load: Column,
    whole: Vec<Valued<'a>>,
}

impl<'a> Loaded<'a> {
    /// Of some effects.
    pub fn by(scene: &'a Scene, effects: &[Valued<'a>]) -> Self {
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

    /// What they do to the reading.
    pub fn read(&self) -> Column {
        as_read(self.scene, self.load.clone(), &self.whole)
    }

    /// What a further effect on the reading as a whole does that these do not do without it.
    pub fn added(&self, effect: Valued<'a>) -> Column {
        let with = [&self.whole[..], &[effect]].concat();
        as_read(self.scene, self.load.clone(), &with).less(&self.read())
    }
}

/// What the reading shows of a further load: what acts on the reading as a whole (a delay, a gain) acts on
/// all that loads the sensor, first the known effects, then `whole`.
fn as_read(scene: &Scene, load: Column, whole: &[Valued<'_>]) -> Column {
    let known = known(&scene.model, &scene.model.effects, true);
    if whole.is_empty() && known.iter().all(|(law, _)| !law.acts_on_load()) {
        return scene.shown(load);
    }
    let mut reading = scene.load.clone();
    reading.add(&load.0);
    for (law, p) in known.iter().chain(whole) {
        let change = law.change_if_any(scene, &reading, p);
        reading.add(&change.0);
    }
    scene.shown(reading.less(&scene.reading))
}

/// Effects of a model file: those that act on the reading as a whole, or those that load the sensor.
fn known(model: &Model, effects: &[EffectModel], whole: bool) -> Vec<Valued<'static>> {
    let laws = effects.iter().filter_map(|effect| {
        let law = LoadEffect::find(model, &effect.id)?;
        Some((law, law.given(&effect.parameters)))
    });
    laws.filter(|(law, _)| law.acts_on_reading() == whole)
        .collect()
}

/// Through the filter of the import.
fn through(filter: FilterModel, cycle_s: f64, mut part: Column) -> Column {
    let filter = LowPass::new(filter.order, filter.cutoff_hz * cycle_s);
    for series in part.0.iter_mut().filter(|series| !series.is_empty()) {
        *series = filter.zero_phase(series);
    }
    part
}

/// Samples at the end of a stretch without gaps whose motion lies behind it: a drive is told a delay before it moves, and a clock
/// may be late.
pub fn beyond_the_end(scene: &Scene) -> usize {
    let known = known(&scene.model, &scene.model.effects, true).into_iter();
    let acting = known.filter(|(effect, _)| effect.acts(scene));
    let ahead = acting.filter_map(|(effect, p)| match effect.effect.law {
        Law::Actuator(Actuator {
            late: Some(law), ..
        }) => Some(law(&p).delay_s),
        Law::Apart(law) => Some(law(&p)),
        _ => None,
    });
    (ahead.sum::<f64>().max(0.0) / scene.cycle_s).ceil() as usize
}

/// Adds what effects of a model file do to the reading of a scene. What acts on the reading as a
/// whole acts last, wherever it stands in the file.
pub fn add_known(scene: &mut Scene, effects: &[EffectModel]) {
    for whole in [false, true] {
        for (law, p) in known(&scene.model, effects, whole) {
            let change = law.change_if_any(scene, &scene.reading, &p);
            scene.reading.add(&change.0);
        }
        if !whole {
            scene.load = scene.reading.clone();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An excess that fades over 10 mm/s: of one that turns round over 2 mm/s eight tenths act, over 20 mm/s a fifth.
    #[test]
    fn an_excess_that_is_gone_before_the_friction_has_turned_is_none() {
        let stribeck = LoadEffect::find(&Model::default(), "guide_stribeck").expect("catalogued");
        let fades = |smoothing_m_s: f64| {
            let shapes = [0.01, smoothing_m_s, 0.0, 2.0];
            let (law, speed) = stribeck.turns_over_speed(&shapes).expect("over a speed");
            stribeck.fades_as_it_turns(law, speed, &shapes)
        };
        assert_eq!([0.002, 0.02].map(fades), [false, true]);
    }
}
