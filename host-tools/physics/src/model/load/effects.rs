//! Effect of the catalogue's laws on the sensor's reading over a log, for prediction and fit.
//!
//! With all parameters given, an effect is an additive part of the reading. For a fit, each linear parameter has a column of the
//! design matrix; the others shape the columns. Columns are difference quotients of that part itself, so that the two cannot
//! disagree.

use super::{Scene, laws};
use crate::effects::{
    Actuator, CATALOGUE, Effect, Guide, Kind, Law, Parameter, Reversal, Role, Slide,
};
use crate::model::Model;
use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Longest delay of a reading that is searched in logs of 100 Hz and more, s.
const LATEST_S: f64 = 0.1;
/// The same in cycles, in slower logs.
const LATEST_CYCLES: f64 = 10.0;
/// The same as a share of the shortest log: a longer delay leaves too little to compare. Set by hand.
const LATEST_SHARE: f64 = 0.25;
/// Shortest time constant of a drift as a share of the shortest log: a faster one is a constant except in the first rows. Set by
/// hand.
const CREEPS: f64 = 0.1;
/// Share of the usual speed (rms) of the logs below which the fall of a friction has to end: one that still falls beyond it can
/// be distinguished neither from one that falls throughout nor from less friction with a higher peak.
const FALLEN: f64 = 0.5;
/// Multiple of the largest tried transition speed of a friction up to which a search refines it: in the likelihood a slower
/// transition competes with other errors of form, and least squares choose it in the end.
const SHARP: f64 = 10.0;

/// Ratio of a speed to the transition speed of a friction at which the friction has its level to 3 % (tanh), which is the
/// accuracy of laws. A friction that does not reach it at the usual speed is not searched.
pub const LEVEL: f64 = 2.1;
/// Ratio of a stroke to the distance over which a friction builds up at which the friction has its level to 3 % at the end (1 − 2
/// exp(−ratio), Dahl). A friction that does not reach it at the end of the usual stroke cannot be distinguished from a spring.
pub(super) const STROKE_TO_LEVEL: f64 = 4.2;
/// The same ratio for linear unloading (Bouc-Wen): a loop shorter than its distance is a line except for its first part. Set by
/// hand.
pub(super) const STROKE_TO_LOOP: f64 = 1.0;
/// Least share of its level that each part of a friction must reach: below it, the log does not determine the level. Set by hand:
/// an excess whose transition speed is two thirds of the speed over which it fades reaches half.
const REACHED: f64 = 0.5;

/// Longest delay that is searched if the shortest log has this duration, both in s.
pub fn latest_s(shortest_s: f64) -> f64 {
    LATEST_SHARE * shortest_s
}

/// Sampling, speed and duration of a set of logs.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The longest cycle time of the logs, s.
    pub cycle_s: f64,
    /// The largest rms velocity along the guide of the logs, m/s or rad/s.
    pub speed: f64,
    /// Duration of the shortest log, s.
    pub shortest_s: f64,
}

impl Pace {
    /// Factor by which the searched delays are longer than in fast logs, at least 1.
    fn slower(self) -> f64 {
        (self.cycle_s * LATEST_CYCLES / LATEST_S).max(1.0)
    }
}

/// Constraint of a coefficient.
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
    /// Its constraint.
    pub sign: Sign,
    /// It acts like all others at once.
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
    /// It selects a form and is no physical size of interest: it has no interval.
    pub choice: bool,
    /// It may take any value between those that are tried.
    pub continuous: bool,
}

/// An effect on the reading.
pub struct LoadEffect {
    /// Its entry.
    pub effect: &'static Effect,
    /// Id in the catalogue.
    pub id: &'static str,
    /// Its parameters, for a bearing where it acts on one.
    pub parameters: Vec<Parameter>,
    /// Parameters that multiply the columns, in their order.
    pub coefficients: Vec<Coefficient>,
    /// Parameters that shape the columns.
    pub shapes: Vec<Shape>,
}

/// The effects of the catalogue; of two that explain a log equally well, the earlier one is named.
static CATALOGUED: LazyLock<Vec<LoadEffect>> = LazyLock::new(|| catalogued(false));
/// The same for a guide that is a bearing.
static OF_BEARINGS: LazyLock<Vec<LoadEffect>> = LazyLock::new(|| catalogued(true));
/// The effects of hypotheses, by their entries.
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

    /// The effect with this id; `None` if the model has none.
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

    /// `None` for an effect that does not change the reading, or only its samples, and for one of a bearing if there is none.
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
        let shaping = parameters
            .iter()
            .filter_map(|p| Some((p, p.search_start()?)));
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

    /// Whether it changes only the reading of the sensor: neither the rig's motion nor its clocks.
    pub fn is_of_the_reading_alone(&self) -> bool {
        !matches!(self.effect.law, Law::Actuator(_) | Law::ClockOffset(_))
    }

    /// Whether it acts on the whole reading, whatever loads the sensor.
    pub fn acts_on_reading(&self) -> bool {
        matches!(
            self.effect.law,
            Law::SensorGain(_)
                | Law::CommandGain(_)
                | Law::SensorZero(_)
                | Law::ReadingDelay(_)
                | Law::ClockOffset(_)
                | Law::Saturation(_)
                | Law::Actuator(_)
        )
    }

    /// Whether its part depends on the other effects, because it acts on the total load of the sensor.
    pub fn acts_on_load(&self) -> bool {
        self.acts_on_reading() && !self.is_of_a_zero()
    }

    /// Whether it shifts the whole reading in time.
    pub fn is_late(&self) -> bool {
        matches!(
            self.effect.law,
            Law::ReadingDelay(_)
                | Law::ClockOffset(_)
                | Law::Actuator(Actuator { late: Some(_), .. })
        )
    }

    /// Whether it is a delay between a command and its execution: if the command drives, the motion of its last samples lies
    /// beyond the end of the log.
    pub fn is_a_delay(&self) -> bool {
        match self.effect.law {
            Law::Actuator(Actuator {
                late: Some(law), ..
            }) => law(&vec![1.0; self.parameters.len()]).delay_s > 0.0,
            _ => false,
        }
    }

    /// Range in which a search looks for a parameter. The delay of a reading is that of some cycles of a sensor, a bus or a
    /// clock; a longer one has another cause.
    pub fn search_range(&self, parameter: &Parameter, logs: Pace) -> [f64; 2] {
        let Parameter { low, high, .. } = *parameter;
        let Some(tried) = parameter.search_start() else {
            return [low, high];
        };
        let high = high.min(tried.most);
        if self.is_late_reading() {
            let latest = (LATEST_S * logs.slower()).min(latest_s(logs.shortest_s));
            return [low, high].map(|end| end.clamp(-latest, latest));
        }
        if self.is_a_delay() {
            return [low, high.min(latest_s(logs.shortest_s))];
        }
        if self.is_a_drift() {
            return [low.max(CREEPS * logs.shortest_s).min(high), high];
        }
        match self.is_speed_of_friction(parameter) {
            true if parameter.is_form() => {
                let largest = tried.values.iter().copied().fold(0.0, f64::max);
                [low, high.min(SHARP * largest)]
            }
            true => [low, high.min(FALLEN * logs.speed).max(low)],
            false => [low, high],
        }
    }

    /// Values of a shape that a search tries.
    pub fn tried_values(&self, shape: &Shape, logs: Pace) -> Vec<f64> {
        let known = self.parameters.iter().find(|p| p.name == shape.name);
        let [low, high] = known.map_or([f64::NEG_INFINITY, f64::INFINITY], |p| {
            self.search_range(p, logs)
        });
        let factor = match self.is_late_reading() {
            true => logs.slower(),
            false => 1.0,
        };
        let values = shape.tried.iter().map(|value| factor * value);
        let mut values: Vec<f64> = values.map(|value| value.clamp(low, high)).collect();
        values.dedup();
        let falls = |p: &Parameter| self.is_speed_of_friction(p) && !p.is_form();
        if known.is_some_and(falls) {
            values.extend(further(&values, high));
        }
        values
    }

    /// Whether a parameter is a speed over which a friction falls or, as a form, changes its sign.
    fn is_speed_of_friction(&self, parameter: &Parameter) -> bool {
        let is_speed = matches!(parameter.unit, "m/s" | "rad/s");
        matches!(self.effect.law, Law::Guide(_)) && is_speed
    }

    /// Whether it puts reading and motion at different times.
    fn is_late_reading(&self) -> bool {
        self.effect.kind == Some(Kind::LateReading)
    }

    /// Whether it depends on time alone: a zero of the sensor with a shape, which is how it changes.
    pub fn is_a_drift(&self) -> bool {
        self.is_of_a_zero() && !self.shapes.is_empty()
    }

    /// Whether it is constant, whatever the motion.
    pub fn is_a_constant(&self) -> bool {
        let moving = Slide {
            position: 0.1,
            acceleration: 0.3,
            ..Slide::at_velocity(0.2)
        };
        match &self.effect.law {
            Law::SensorZero(_) => self.shapes.is_empty(),
            Law::Guide(law) | Law::Bearing(law) => {
                let ones = vec![1.0; self.coefficients.len()];
                let values = self.values(&[], &ones);
                (law.force)(&values, &moving) == (law.force)(&values, &Slide::default())
            }
            _ => false,
        }
    }

    /// Whether it takes energy from a motion: a force against the velocity, and zero at rest.
    pub fn dissipates(&self) -> bool {
        let at_rest = Slide {
            position: 0.1,
            acceleration: 0.3,
            ..Slide::default()
        };
        match &self.effect.law {
            Law::Guide(law) => {
                let ones = vec![1.0; self.coefficients.len()];
                let values = self.values(&[], &ones);
                let moving = (law.force)(&values, &Slide::at_velocity(0.2));
                moving < 0.0 && (law.force)(&values, &at_rest) == 0.0
            }
            _ => false,
        }
    }

    /// Whether it is the zero of a sensor.
    pub fn is_of_a_zero(&self) -> bool {
        matches!(self.effect.law, Law::SensorZero(_))
    }

    /// Whether the log contains what it acts on.
    pub fn acts(&self, scene: &Scene) -> bool {
        laws::acts(scene, self.effect)
    }

    /// Whether a search tries it on the log: it acts there, is no weight about an axis that stands upright by the model's gravity,
    /// and no gain where the nominal parameters make no load: the amounts of all effects would make up for it.
    pub fn is_tried_on(&self, scene: &Scene) -> bool {
        let lifts_nothing = self.effect.is_weight_about_bearing() && scene.turns_upright();
        let is_free = self.effect.is_gain_of_all() && !scene.has_nominal_load();
        self.acts(scene) && !lifts_nothing && !is_free
    }

    /// Whether its columns do not depend on its coefficients. Those of a contact do: a wall does not pull, so that where it lifts
    /// off depends on everything that pushes.
    pub fn is_linear(&self) -> bool {
        !self.effect.is_of_a_contact() && !matches!(self.effect.law, Law::Docking(_))
    }

    /// Whether the coefficients that are known not to be 0 suffice to make it this effect: a Stribeck friction whose excess may
    /// be 0 is a dry friction. `is_sure` tells it of the coefficient with a name.
    pub fn is_determined(&self, is_sure: impl Fn(&str) -> bool) -> bool {
        let names = self.coefficients.iter().enumerate();
        let sure = names.filter(|(_, c)| is_sure(c.name)).map(|(k, _)| k);
        let sure: Vec<usize> = sure.collect();
        // Beside any subset of the effects of which it is a detail.
        let simpler = self.effect.detail_of;
        let is_whole = |there: u32| {
            let beside = |id: &str| {
                let place = simpler.iter().position(|(of, _)| *of == id);
                place.is_none_or(|place| there >> place & 1 == 1)
            };
            (self.effect.is_whole)(&sure, &beside)
        };
        self.coefficients.is_empty() || (!sure.is_empty() && (0..1 << simpler.len()).any(is_whole))
    }

    /// Whether the intervals show that it is present: the interval of one of its amounts excludes 0, or, for a late effect
    /// without amounts, that of its time. An effect with amounts and a shape on which they depend passes here and is judged
    /// elsewhere: of a slow drift only the slope is known.
    pub fn is_significant(&self, is_sure: impl Fn(&str) -> bool) -> bool {
        let mut shapes = self.shapes.iter().filter(|shape| !shape.choice);
        match self.is_late() && self.coefficients.is_empty() {
            true => shapes.any(|shape| is_sure(shape.name)),
            false => shapes.next().is_some() || self.is_determined(is_sure),
        }
    }

    /// Whether it becomes another, simpler effect without some of its coefficients.
    pub fn may_be_simpler(&self) -> bool {
        let alone = |k: usize| (self.effect.is_whole)(&[k], &|_| true);
        !(0..self.coefficients.len()).all(alone)
    }

    /// Places of all its columns: one per coefficient, or a single one for an effect without coefficients.
    pub fn places(&self) -> Vec<usize> {
        (0..self.coefficients.len().max(1)).collect()
    }

    /// Its law and the speed over which its direction changes; `None` if it does not change over a speed.
    pub(super) fn turns_over_speed(&self, shapes: &[f64]) -> Option<(&Guide, f64)> {
        let (Law::Guide(law) | Law::Bearing(law)) = &self.effect.law else {
            return None;
        };
        match (law.reversal)(&self.values(shapes, &[]))? {
            Reversal::OverSpeed(speed) => Some((law, speed)),
            _ => None,
        }
    }

    /// The shortest usual stroke in which it can be distinguished from a spring, from the distance over which it builds up; 0 if
    /// it changes at once or over a speed.
    pub(super) fn needs_stroke(&self, shapes: &[f64]) -> f64 {
        let (Law::Guide(law) | Law::Bearing(law)) = &self.effect.law else {
            return 0.0;
        };
        match (law.reversal)(&self.values(shapes, &[])) {
            Some(Reversal::OverDistance(distance)) => STROKE_TO_LEVEL * distance,
            Some(Reversal::BoucWen(distance)) => STROKE_TO_LOOP * distance,
            _ => 0.0,
        }
    }

    /// Whether a part of it (an excess at low speed) has decayed before it has [`REACHED`] its level.
    pub(super) fn fades_as_it_turns(&self, law: &Guide, speed: f64, shapes: &[f64]) -> bool {
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

    /// Whether a coefficient is impossible for the rig: beyond the plausible range of the catalogue, a part that weighs more than
    /// the whole tool, or an error that leaves nothing of the nominal value.
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

    /// Values of a model file in the order of the parameters; missing ones have their default.
    pub fn values_or_defaults(&self, values: &BTreeMap<String, f64>) -> Vec<f64> {
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
}

/// Further values in equal ratios from the last one up to an end: the values are those of docking rigs, and other machines are
/// faster by any factor.
fn further(values: &[f64], end: f64) -> Vec<f64> {
    /// Largest ratio between successive values, unless that takes more than [`MOST`].
    const RATIO: f64 = 2.5;
    /// Most values.
    const MOST: f64 = 6.0;
    let reach = values.last().map_or(1.0, |last| end / last);
    let count = (reach.ln() / RATIO.ln()).ceil().clamp(0.0, MOST);
    let ratio = reach.powf(1.0 / count.max(1.0));
    let further = (1..=count as i32).map(|k| end / reach * ratio.powi(k));
    further.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fast_machine_is_searched_up_to_its_own_speeds() {
        let all = further(&[0.01, 0.02], 0.5);
        assert_eq!(all.len(), 4);
        assert!((all[3] - 0.5).abs() < 1e-12 && (all[0] / 0.02 - all[3] / all[2]).abs() < 1e-12);
        assert!(further(&[0.01, 0.02], 0.02).is_empty());
        assert_eq!(further(&[0.02], 150.0).len(), 6);
    }

    /// An excess that fades over 10 mm/s: with a transition over 2 mm/s it reaches 0.8, over 20 mm/s a fifth.
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

    /// All three amounts of a friction that differs by direction: its dry part stands alone, its viscous one beside another
    /// effect.
    #[test]
    fn what_is_known_of_all_its_amounts_is_known() {
        let asymmetry = LoadEffect::find(&Model::default(), "guide_asymmetry").expect("catalogued");
        let is_determined = |sure: &[&str]| asymmetry.is_determined(|name| sure.contains(&name));
        let levels = ["forward_n", "backward_n"];
        let slope = "viscous_difference_n_s_per_m";
        assert!(is_determined(&levels) && is_determined(&[slope]) && is_determined(&levels[..1]));
        assert!(is_determined(&[levels[0], levels[1], slope]));
        assert!(!is_determined(&[]));
    }

    /// A friction that builds up by Dahl's law over half a millimetre has its level after two; one by Bouc and Wen shows in a
    /// stroke of that length; a sharp one in any stroke.
    #[test]
    fn a_friction_that_builds_up_needs_a_stroke() {
        let needs = |id: &str, shapes: &[f64]| {
            let effect = LoadEffect::find(&Model::default(), id).expect("catalogued");
            effect.needs_stroke(shapes)
        };
        assert!((needs("guide_coulomb", &[0.0, 5e-4, 0.0]) - 2.1e-3).abs() < 1e-12);
        assert_eq!(needs("guide_coulomb", &[1e-3, 0.0, 0.0]), 0.0);
        assert_eq!(needs("guide_hysteresis", &[5e-4, 0.0]), 5e-4);
        let dahl = needs("guide_hysteresis", &[5e-4, 1.0]);
        assert!((dahl - 2.1e-3).abs() < 1e-12);
        assert_eq!(needs("cable_stiffness", &[0.0, 0.0]), 0.0);
    }
}
