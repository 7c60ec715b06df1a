//! What the catalogue's laws do to the sensor's reading over a log, for prediction and fit.
//!
//! With all parameters given, an effect is a part of the reading. For a fit, the parts of its linear
//! parameters are columns of a regression; the others shape the columns. Columns are difference
//! quotients of the part itself, so that they cannot disagree with it.

use super::{Scene, laws};
use crate::effects::{
    Actuator, CATALOGUE, Effect, Guide, Kind, Law, Parameter, Reversal, Role, Slide,
};
use crate::model::Model;
use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Latest that a reading is looked for in logs of 100 Hz and more.
const LATEST_S: f64 = 0.1;
/// The same in cycles, in slower logs.
const LATEST_CYCLES: f64 = 10.0;
/// The same as a share of the shortest log: of what is later too little is left to compare. Set by hand.
const LATEST_SHARE: f64 = 0.25;
/// Shortest time constant of a drift as a share of the shortest log: what is over sooner is a constant but for the first rows. Set by
/// hand.
const CREEPS: f64 = 0.1;
/// Share of the usual speed (rms) of the logs at which the fall of a friction has ended: one that still falls beyond it is told
/// neither from one that falls all the way nor from less friction with a higher peak.
const FALLEN: f64 = 0.5;
/// Times the largest speed that is tried up to which a search refines that over which a friction turns round: in the likelihood a
/// slower turn competes with other errors of form, and least squares choose it in the end.
const SHARP: f64 = 10.0;

/// Ratio of a speed to the one over which a friction turns round from which the friction has its level to 3 % (tanh), to which
/// laws are right. One that does not have it at the usual speed is not looked for.
pub const LEVEL: f64 = 2.1;
/// Ratio of a stroke to the distance over which a friction builds up from which the friction has its level to 3 % at the end
/// (1 − 2 exp(−ratio), Dahl). One that does not have it at the end of the usual stroke is a spring by another name.
pub(super) const STROKE_TO_LEVEL: f64 = 4.2;
/// The same ratio of what relaxes linearly (Bouc-Wen): a loop of less than its distance is a line but for its first part. Set by hand.
pub(super) const STROKE_TO_LOOP: f64 = 1.0;
/// Share of its level that a part of a friction reaches at the least: of less it is not the level that a log tells. Set by hand: an
/// excess that turns round over two thirds of the speed over which it fades has half.
const REACHED: f64 = 0.5;

/// The latest that anything is looked for in logs of which the shortest is so long, both in s.
pub fn latest_s(shortest_s: f64) -> f64 {
    LATEST_SHARE * shortest_s
}

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

    /// Whether it is a delay between a command and its execution: where that drives, the end of a log is without its motion.
    pub fn is_a_delay(&self) -> bool {
        match self.effect.law {
            Law::Actuator(Actuator {
                late: Some(law), ..
            }) => law(&vec![1.0; self.parameters.len()]).delay_s > 0.0,
            _ => false,
        }
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
        let falls = |p: &Parameter| self.is_speed_of_friction(p) && !p.is_form();
        if known.is_some_and(falls) {
            values.extend(further(&values, high));
        }
        values
    }

    /// Whether a parameter is a speed over which a friction falls or, as a form, turns round.
    fn is_speed_of_friction(&self, parameter: &Parameter) -> bool {
        let is_speed = matches!(parameter.unit, "m/s" | "rad/s");
        matches!(self.effect.law, Law::Guide(_)) && is_speed
    }

    /// Whether readings and motion are of different times.
    fn is_late_reading(&self) -> bool {
        self.effect.kind == Some(Kind::LateReading)
    }

    /// Whether it follows the time and nothing else: a zero with a shape, which is how it changes.
    pub fn is_a_drift(&self) -> bool {
        self.is_of_a_zero() && !self.shapes.is_empty()
    }

    /// Whether it is the same at all times, whatever moves.
    pub fn is_a_constant(&self) -> bool {
        let moving = Slide {
            position: 0.1,
            acceleration: 0.3,
            ..Slide::at_velocity(0.2)
        };
        match &self.effect.law {
            Law::Zero(_) => self.shapes.is_empty(),
            Law::Guide(law) | Law::Bearing(law) => {
                let ones = vec![1.0; self.coefficients.len()];
                let values = self.values(&[], &ones);
                (law.force)(&values, &moving) == (law.force)(&values, &Slide::default())
            }
            _ => false,
        }
    }

    /// Whether it takes energy from a motion: a force by the velocity, and none without.
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
        // Beside some of what it may be a detail of.
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

    /// Its law, and the speed over which it turns round, if it does so over a speed.
    pub(super) fn turns_over_speed(&self, shapes: &[f64]) -> Option<(&Guide, f64)> {
        let (Law::Guide(law) | Law::Bearing(law)) = &self.effect.law else {
            return None;
        };
        match (law.reversal)(&self.values(shapes, &[]))? {
            Reversal::OverSpeed(speed) => Some((law, speed)),
            _ => None,
        }
    }

    /// The shortest usual stroke in which it is told from a spring: by the distance over which it builds up; 0 if it does so at once
    /// or over a speed.
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

    /// Whether a part of it (an excess at low speed) is gone before it has [`REACHED`] its level.
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
}

/// From the last of some values on in equal ratios, up to an end: machines are faster than a docking rig, whose values these are, by
/// whatever factor.
fn further(values: &[f64], end: f64) -> Vec<f64> {
    /// Largest ratio of one value to the one before, unless that would be more than [`MOST`].
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

    /// All three amounts of a friction that differs by direction, whose dry part stands alone and whose viscous one beside another effect.
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

    /// What builds up by Dahl's law over half a millimetre has its level after two; what does by Bouc and Wen's shows in a stroke of
    /// that length; what turns round at once does in any.
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
