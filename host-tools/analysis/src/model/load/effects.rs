//! What the catalogue's laws do to the sensor's reading over a log, for prediction and fit.
//!
//! With all parameters given, an effect is a part of the reading. For a fit, the parts of its linear
//! parameters are columns of a regression; the others shape the columns. Columns are difference
//! quotients of the part itself, so that they cannot disagree with it.

use super::{Column, Scene, Touch};
use crate::effects::formula::{ActsOn, Formula, Signals};
use crate::effects::sensor::tool::{LoadMotion, ToolState};
use crate::effects::{
    CATALOGUE, Direction, Effect, Facing, Group, Guide, Late, Law, Parameter, Penetration, Role,
    Slide, Values, sign,
};
use crate::import::filter::LowPass;
use crate::model::{EffectModel, Model, WrenchMeaning};
use nalgebra::Vector3;
use softdock_control::frames::{Wrench, matrix};
use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

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
        let own = model.hypotheses.iter();
        let own = own.filter_map(|hypothesis| Self::own(hypothesis.effect().ok()?));
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
            Law::Sample(_) | Law::Actuator(None) | Law::Spacecraft | Law::Clock
        ) {
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

    /// Whether it changes the reading as a whole, whatever loads the sensor.
    pub fn acts_on_reading(&self) -> bool {
        matches!(
            self.effect.law,
            Law::Load(_) | Law::Zero(_) | Law::Late(_) | Law::Range(_) | Law::Actuator(_)
        )
    }

    /// Whether its columns depend on its coefficients: a wall does not pull, so that where it lifts
    /// off depends on all that pushes.
    pub fn is_linear(&self) -> bool {
        match self.effect.law {
            Law::Push(_) | Law::Depth(_) => false,
            Law::Formula(law) => law.acts_on != ActsOn::Contact,
            _ => true,
        }
    }

    /// The columns as they stand in the log, through the filter of its import if it had one; None if
    /// the log or the model has nothing for the effect to act on.
    pub fn columns(&self, scene: &Scene, shapes: &[f64]) -> Option<Vec<Column>> {
        if !self.acts(scene) {
            return None;
        }
        let columns: Option<Vec<Column>> = match self.coefficients.len() {
            0 => self.part(scene, &self.values(shapes, &[])).map(|c| vec![c]),
            count => (0..count).map(|k| self.slope(scene, shapes, k)).collect(),
        };
        columns.filter(|columns| !columns.iter().all(Column::is_zero))
    }

    /// The columns around given coefficients: times these they are the effect exactly, also where
    /// it is not linear in them.
    pub fn columns_at(
        &self,
        scene: &Scene,
        shapes: &[f64],
        coefficients: &[f64],
    ) -> Option<Vec<Column>> {
        match coefficients {
            [one] if *one != 0.0 && !self.is_linear() && self.acts(scene) => {
                let mut part = self.part(scene, &self.values(shapes, coefficients))?;
                part.scale(1.0 / one);
                Some(vec![part])
            }
            _ => self.columns(scene, shapes),
        }
    }

    /// Part of the reading, with parameters from a model file; what is left out is 0 or default.
    pub fn contribution(&self, scene: &Scene, parameters: &BTreeMap<String, f64>) -> Column {
        let part = self
            .acts(scene)
            .then(|| self.part(scene, &self.given(parameters)));
        part.flatten().unwrap_or_default()
    }

    /// Whether a coefficient is out of what the rig can be: beyond the plausible range of the
    /// catalogue, or a part of a tool that weighs more.
    pub fn is_implausible(&self, model: &Model, name: &str, value: f64) -> bool {
        let known = self.parameters.iter().find(|p| p.name == name);
        known.is_some_and(|p| {
            let least = p.of_the_tool * model.tool.mass_kg;
            !p.is_plausible(value) || (p.of_the_tool > 0.0 && value < least)
        })
    }

    /// Values of a model file in the order of the parameters; what is left out has its default.
    fn given(&self, values: &BTreeMap<String, f64>) -> Vec<f64> {
        let value = |p: &Parameter| values.get(p.name).copied().unwrap_or(p.default());
        self.parameters.iter().map(value).collect()
    }

    /// Values in the order of the catalogue's parameters.
    fn values(&self, shapes: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let (mut shapes, mut coefficients) = (shapes.iter(), coefficients.iter());
        let value = |p: &Parameter| match p.role {
            Role::Linear => coefficients.next(),
            Role::Shape(_) | Role::Form(_) => shapes.next(),
        };
        let given = self.effect.parameters.iter().map(value);
        given.map(|v| v.copied().unwrap_or(0.0)).collect()
    }

    /// Difference quotient of the part by a coefficient, at zero. Its step, a millionth of the plausible
    /// range, is a power of two, so that what is linear has no error of rounding.
    fn slope(&self, scene: &Scene, shapes: &[f64], k: usize) -> Option<Column> {
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
        let mut slope = self.part(scene, &self.values(shapes, &coefficients))?;
        slope.scale(1.0 / step);
        Some(slope)
    }

    /// Whether the log has what the effect acts on.
    fn acts(&self, scene: &Scene) -> bool {
        let sensor = &scene.model.sensor;
        let live = |meaning| sensor.wrench == meaning && !sensor.at_rest;
        match self.effect.law {
            Law::Guide(_) | Law::Spring(_) => {
                !sensor.at_rest && (0..scene.len()).any(|n| scene.along(n, 0.0) != 0.0)
            }
            Law::Push(_) | Law::Depth(_) | Law::Friction(_) => scene
                .touches
                .iter()
                .any(|t| t.penetration.iter().any(|p| *p > 0.0)),
            Law::Zero(_) => self.shapes.is_empty() || !sensor.at_rest,
            Law::Late(_) | Law::Range(_) => live(WrenchMeaning::Measured),
            Law::Actuator(_) => live(WrenchMeaning::Commanded),
            Law::Formula(law) if law.acts_on == ActsOn::Contact => scene
                .touches
                .iter()
                .any(|t| t.penetration.iter().any(|p| *p > 0.0)),
            Law::Formula(_) => !sensor.at_rest,
            _ => true,
        }
    }

    /// What the effect does to the reading; None for forms that exclude each other.
    fn part(&self, scene: &Scene, p: Values<'_>) -> Option<Column> {
        let form = |name| self.effect.place(name).map_or(0.0, |k| p[k]);
        let part = match self.effect.law {
            Law::Guide(law) => guide(scene, &law, p, form("acts_at"))?,
            Law::Spring(law) => {
                let rests_at_start = form("about_start") > 0.5;
                spring(scene, rests_at_start, form("acts_at"), |d| law(p, d))
            }
            Law::Push(law) => scene.wall_force(|t, n| {
                let more = penetration(t, n).map_or(0.0, |at| law(p, &at));
                (t.push_at(n, t.penetration[n]) + more).max(0.0) - t.force[n]
            }),
            Law::Depth(law) => scene.wall_force(|t, n| {
                let facing = Facing {
                    along_axis: t.normal.dot(&scene.axis),
                    number: t.number,
                };
                t.push_at(n, law(p, t.penetration[n], &facing)).max(0.0) - t.force[n]
            }),
            Law::Friction(law) => scene.force_of_walls(|t, n| {
                let (_, velocity) = scene.point(n, &t.tip);
                let sliding = velocity - t.normal * t.normal.dot(&velocity);
                match t.force[n] > 0.0 {
                    true => law(p, t.force[n], &sliding),
                    false => Vector3::zeros(),
                }
            }),
            Law::Tool(law) => {
                let mut state = tool_state(scene);
                Column::of(scene.len(), |n| {
                    move_tool(&mut state, scene, n);
                    law(p, &state).get()
                })
            }
            Law::Load(law) => {
                let kept = if form("with_zero") > 0.5 { 0.0 } else { 1.0 };
                let zero = Wrench::of(&scene.bias.map(|b| kept * b));
                changed(scene, |_, reading| {
                    let load = *reading - zero;
                    law(p, &load) + zero
                })
            }
            Law::Zero(law) => {
                let start = scene.time_s.first().copied().unwrap_or(0.0);
                Column::of(scene.len(), |n| law(p, scene.time_s[n] - start).get())
            }
            Law::Range(law) => changed(scene, |_, reading| law(p, reading)),
            Law::Late(law) => {
                let mut late = Late::new(law(p), scene.cycle_s, scene.reading_at(0));
                changed(scene, |_, reading| Wrench::of(&late.advance(reading.get())))
            }
            Law::Actuator(Some(law)) => {
                let late = law(p);
                changed(scene, |n, _| Wrench::of(&scene.anticipated(n, &late)))
            }
            Law::Formula(law) => formula(scene, law, p)?,
            Law::Sample(_) | Law::Actuator(None) | Law::Spacecraft | Law::Clock => return None,
        };
        Some(self.filtered(scene, part))
    }

    /// Through the filter of the import; the reading itself has been through it already.
    fn filtered(&self, scene: &Scene, mut part: Column) -> Column {
        let filter = scene.model.sensor.filter;
        if let Some(filter) = filter.filter(|_| !self.acts_on_reading()) {
            let filter = LowPass::new(filter.order, filter.cutoff_hz * scene.cycle_s);
            for series in part.0.iter_mut().filter(|series| !series.is_empty()) {
                *series = filter.zero_phase(series);
            }
        }
        part
    }
}

/// Adds what effects of a model file do to the reading of a scene. What acts on the reading as a
/// whole (a delay, a gain) acts last, on all that loads the sensor, wherever it stands in the file.
pub(crate) fn add_known(scene: &mut Scene, effects: &[EffectModel]) {
    let known: Vec<(&EffectModel, &LoadEffect)> = effects
        .iter()
        .filter_map(|effect| Some((effect, LoadEffect::find(&scene.model, &effect.id)?)))
        .collect();
    for on_reading in [false, true] {
        for (effect, law) in &known {
            if law.acts_on_reading() == on_reading {
                let part = law.contribution(scene, &effect.parameters);
                scene.reading.add(&part.0);
            }
        }
    }
}

/// A force along the guide on the point where it acts.
fn guide(scene: &Scene, law: &Guide, p: Values<'_>, acts_at: f64) -> Option<Column> {
    let mut direction = Direction::new((law.reversal)(p)?);
    let start = scene.time_s.first().copied().unwrap_or(0.0);
    Some(scene.guide_force(acts_at, |n| {
        let velocity = scene.along(n, acts_at);
        let slide = Slide {
            position: scene.position[n],
            velocity,
            acceleration: scene.acceleration[n],
            time_s: scene.time_s[n] - start,
            direction: direction.advance(velocity, scene.cycle_s),
        };
        (law.force)(p, &slide)
    }))
}

/// What a user has written; None where it has no value.
fn formula(scene: &Scene, law: &Formula, p: Values<'_>) -> Option<Column> {
    let start = scene.time_s.first().copied().unwrap_or(0.0);
    let push = |n: usize| {
        scene
            .touches
            .iter()
            .map(move |t| t.force[n] * t.normal.dot(&scene.axis))
    };
    let moving = |n: usize| Signals {
        position: scene.position[n],
        velocity: scene.along(n, 0.0),
        acceleration: scene.acceleration[n],
        direction: sign(scene.along(n, 0.0)),
        force: push(n).sum(),
        time: scene.time_s[n] - start,
        ..Signals::default()
    };
    let value = |n: usize| law.value(p, &moving(n));
    let column = match law.acts_on {
        ActsOn::Guide => scene.guide_force(0.0, value),
        ActsOn::Wall => scene.wall_force(|t, n| {
            let (gap, rate) = ((-t.penetration[n]).max(0.0), t.rate[n]);
            law.value(
                p,
                &Signals {
                    gap,
                    rate,
                    ..moving(n)
                },
            )
        }),
        ActsOn::Reading(axis) => Column::on_axis(axis, (0..scene.len()).map(value)),
        ActsOn::Contact => scene.wall_force(|t, n| {
            let more = penetration(t, n).map_or(0.0, |at| {
                let (depth, rate) = (at.depth, at.rate);
                law.value(
                    p,
                    &Signals {
                        depth,
                        rate,
                        ..moving(n)
                    },
                )
            });
            (t.push_at(n, t.penetration[n]) + more).max(0.0) - t.force[n]
        }),
    };
    let finite = column.0.iter().flatten().all(|value| value.is_finite());
    finite.then_some(column)
}

/// A force in all directions, about the origin of C or about the first position.
fn spring(
    scene: &Scene,
    rests_at_start: bool,
    acts_at: f64,
    force: impl Fn(&Vector3<f64>) -> Vector3<f64>,
) -> Column {
    if scene.model.bearing().is_some() {
        let start = scene.position.first().copied().unwrap_or(0.0);
        let rest = if rests_at_start { start } else { 0.0 };
        let turned = |n: usize| scene.axis * (scene.position[n] - rest);
        return scene.guide_force(acts_at, |n| scene.axis.dot(&force(&turned(n))));
    }
    let at = scene.point_of_action(acts_at);
    let position = |n: usize| scene.pose[n].translation.vector + scene.pose[n].rotation * at - at;
    let rest = match rests_at_start && !scene.is_empty() {
        true => position(0),
        false => Vector3::zeros(),
    };
    Column::of(scene.len(), |n| {
        scene.reading_of(n, &at, &force(&(position(n) - rest)))
    })
}

/// The tip in a wall; None outside.
fn penetration(t: &Touch, n: usize) -> Option<Penetration> {
    let depth = t.penetration[n];
    (depth > 0.0).then(|| Penetration {
        depth,
        rate: t.rate[n],
        onset: t.onset(depth),
    })
}

/// Change of the reading of each cycle.
fn changed(scene: &Scene, mut read: impl FnMut(usize, &Wrench<f64>) -> Wrench<f64>) -> Column {
    Column::of(scene.len(), |n| {
        let reading = Wrench::of(&scene.reading_at(n));
        (read(n, &reading) - reading).get()
    })
}

/// The nominal tool.
fn tool_state(scene: &Scene) -> ToolState {
    let (tool, sensor) = (&scene.model.tool, &scene.model.sensor);
    ToolState {
        mass_kg: tool.mass_kg,
        hanging_kg: hanging(&scene.model),
        com: tool.com_m.into(),
        inertia: matrix(&tool.inertia_kg_m2),
        gravity: sensor.gravity_m_s2.into(),
        s_from_c: scene.s_from_m,
        motion: LoadMotion::uniform(),
        inertial: tool.dynamic_compensation,
    }
}

/// Moves it to a cycle.
fn move_tool(state: &mut ToolState, scene: &Scene, n: usize) {
    let (pose, motion) = (&scene.pose[n], &scene.motion[n]);
    let (velocity, acceleration) = (&motion.velocity, &motion.acceleration);
    state.s_from_c = scene.s_from_m * scene.m_from_c[n];
    state.motion = LoadMotion::of_sensor(&scene.m_from_s, &pose.rotation, velocity, acceleration);
}

/// Mass that hangs on the sensor: the nominal one, or without one what the model knows by an effect
/// on the tool; 1 kg where it knows neither, so that a fit gives the product of both.
fn hanging(model: &Model) -> f64 {
    if model.tool.mass_kg > 0.0 {
        return model.tool.mass_kg;
    }
    let kilograms = |effect: &EffectModel| -> f64 {
        let known = LoadEffect::find(model, &effect.id).map(|load| load.effect);
        let of_the_tool =
            known.filter(|e| matches!(e.law, Law::Tool(_)) && e.group == Group::Sensor);
        let of_mass = of_the_tool
            .into_iter()
            .flat_map(|e| e.parameters)
            .filter(|p| p.unit == "kg");
        of_mass.filter_map(|p| effect.parameters.get(p.name)).sum()
    };
    match model.effects.iter().map(kilograms).sum::<f64>() {
        mass if mass > 0.0 => mass,
        _ => 1.0,
    }
}
