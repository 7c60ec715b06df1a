//! Free-run simulation: the motion of one axis, from the recorded force alone, or of a free swing from its initial state.
//!
//! A comparison predicts the force from the measured motion, one instant at a time. Published models are judged by the reverse:
//! the force is the only input from the beginning of the log on, so that errors accumulate.
//!
//! Each step is the midpoint rule with the friction at its end (Moreau 1988), which can hold a sticking axis: the velocity at the
//! end of a step is the one at which force, load and inertia balance.

use super::swing::amplitude_factor;
use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;
use softdock_control::frames::{Pose, Twist, Wrench};
use softdock_control::wrench::Motion;
use softdock_physics::effects::sensor::tool::ToolState;
use softdock_physics::effects::{Actuator, DelayAndLag, DelayLine, Direction, Guide, Law, Slide};
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::load::{
    LoadModel, angle_about, angles, in_motion, nominal_tool, pose_of, positions,
};
use softdock_physics::model::log::Log;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::{Axis, EffectModel, Model, WrenchMeaning};
use softdock_report::number;
use std::f64::consts::TAU;

/// Steps of the simulation in a cycle of the log.
const STEPS: usize = 8;
/// Cycles at the beginning of the log that are left out: the simulation begins with the state behind them.
const FIRST: usize = 4;
/// Ratio of error to motion, both rms, from which on the simulation is said to run away.
pub(crate) const RUN_OFF: f64 = 1e3;

/// Error of a motion that is simulated from the force alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FreeSimulation {
    /// The axis.
    pub axis: Axis,
    /// Root mean square of measured minus simulated position, m or rad; of velocities, m/s or rad/s.
    pub rms: f64,
    /// `rms` over the root mean square of the measured values about their mean.
    pub relative: f64,
    /// Velocities are compared: the log has no positions but the integral of the velocity.
    pub of_velocity: bool,
    /// How long it was simulated, s.
    pub seconds: f64,
    /// No force drives the motion (a free swing).
    pub is_free: bool,
    /// Nothing in the model acts by position, so that an error of the force is never pulled back.
    pub drifts: bool,
    /// Factor by which the amplitude of a free swing is wrong, 1 or more: exp of the rms, over parts of the log, of the logarithm of
    /// simulated over measured amplitude. None of a motion that is no free swing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_factor: Option<f64>,
}

/// Why there is no free simulation.
pub(crate) struct NotSimulated {
    /// In words.
    pub why: String,
    /// There is a simulation, but it departs far from the motion.
    pub runs_away: bool,
}

impl NotSimulated {
    /// Something acts that a simulation of one axis does not have.
    fn as_asked(why: String) -> Self {
        Self {
            why,
            runs_away: false,
        }
    }
}

/// Share of the motion from which a simulation strays from it.
pub(crate) const STRAYS: f64 = 0.1;

impl FreeSimulation {
    /// Whether it is off by more than the motion.
    fn is_off(&self) -> bool {
        self.relative > 1.0
    }

    /// Whether it is off by more than a tenth of the motion, or of the change of a velocity: a model that leaves so much does not
    /// agree with the log, however small the error of an instant is.
    pub(super) fn strays(&self) -> bool {
        self.relative > STRAYS
    }

    /// As a sentence.
    pub fn words(&self) -> String {
        use super::regime::quantity;
        let (what, unit, whole) = match (self.of_velocity, self.axis.is_rotation()) {
            (false, false) => ("", "m", "motion"),
            (false, true) => ("", "rad", "motion"),
            (true, false) => ("the velocity of ", "m/s", "change"),
            (true, true) => ("the velocity of ", "rad/s", "change"),
        };
        let why = match (self.is_off() && !self.of_velocity, self.drifts) {
            (true, true) => {
                " It drifts, as nothing in the model acts by position: small errors of the force add up."
            }
            (true, false) => {
                " Errors of the force add up where what acts by position does not pull the motion back."
            }
            (false, _) => "",
        };
        format!(
            "Simulated forward {} over {:.1} s, {what}{} is off by {} rms, {} % of its {whole}.{why}",
            from(self.is_free),
            self.seconds,
            self.axis,
            quantity(self.rms, unit),
            number::significant(100.0 * self.relative, 3)
        )
    }
}

/// Simulates the longest stretch of a log. None where no recorded force drives a single axis freely, or the log is too short. The
/// error says what prevents a simulation.
pub(crate) fn simulate(
    model: &Model,
    signals: &Signals<'_>,
) -> Option<Result<FreeSimulation, NotSimulated>> {
    let [axis] = model.rig.active_axes[..] else {
        return None;
    };
    let driven = model.sensor.wrench.drives() && !model.sensor.at_rest;
    if !driven || signals.is_commanded() {
        return None;
    }
    let log = Log::of(signals, model).ok()?;
    if log.cycle_count() < 2 * FIRST {
        return None;
    }
    let body = Body::new(model, &log, axis);
    if !model.contact.docking.is_empty() {
        let why = "The motion is not simulated forward: a docking mechanism acts on it.";
        return Some(Err(NotSimulated::as_asked(why.to_owned())));
    }
    let acting = match Acting::of_model(model) {
        Ok(acting) => acting,
        Err(id) => {
            return Some(Err(NotSimulated::as_asked(format!(
                "The motion is not simulated forward: `{id}` does not act on it alone."
            ))));
        }
    };
    if acting.inertia(&body, &Slide::default()) <= 0.0 {
        let why = "The motion is not simulated forward: nothing in the model has a mass or a moment of inertia along its axis.";
        return Some(Err(NotSimulated::as_asked(why.to_owned())));
    }
    let velocity = signals.velocity_at_pose(log.first + FIRST)?.get()[axis.index()];
    Some(run(&body, &log, acting, velocity))
}

fn run(
    body: &Body,
    log: &Log,
    mut acting: Acting,
    velocity: f64,
) -> Result<FreeSimulation, NotSimulated> {
    let step_s = log.cycle_s / STEPS as f64;
    let input = acting.input(body, log);
    let positions = body.along_axis(log);
    let mut slide = Slide {
        position: positions[FIRST],
        velocity,
        ..Slide::default()
    };
    let of_velocity = log.is_integrated();
    let measured = match of_velocity {
        true => &log.executed[body.axis.index()],
        false => &positions,
    };
    let mean = measured[FIRST..].iter().sum::<f64>() / (log.cycle_count() - FIRST) as f64;
    let [mut error, mut motion] = [0.0; 2];
    let mut swing = Vec::with_capacity(log.cycle_count());
    for n in FIRST..log.cycle_count() {
        let simulated = match of_velocity {
            true => slide.velocity,
            false => slide.position,
        };
        error += (measured[n] - simulated).powi(2);
        motion += (measured[n] - mean).powi(2);
        swing.push([measured[n], simulated]);
        if n + 1 < log.cycle_count() {
            for k in 0..STEPS {
                let share = (k as f64 + 0.5) / STEPS as f64;
                let force = input[n] + share * (input[n + 1] - input[n]);
                acting.step(body, &mut slide, force, step_s);
            }
        }
    }
    let stays = error < RUN_OFF * RUN_OFF * motion; // not so for NaN
    if !stays {
        let from = from(body.is_free);
        return Err(NotSimulated {
            why: format!("Simulated forward {from}, the motion runs away."),
            runs_away: motion > 0.0,
        });
    }
    let count = (log.cycle_count() - FIRST) as f64;
    Ok(FreeSimulation {
        axis: body.axis,
        rms: (error / count).sqrt(),
        relative: (error / motion).sqrt(),
        of_velocity,
        seconds: (count - 1.0) * log.cycle_s,
        is_free: body.is_free,
        drifts: body.drifts,
        amplitude_factor: body.is_free.then(|| amplitude_factor(&swing)).flatten(),
    })
}

/// Whether something that the model has, or may have, acts by position along an axis.
fn acts_by_position(model: &Model, axis: Axis) -> bool {
    let turns = axis.is_rotation();
    let by_position = |known: &EffectModel| {
        LoadEffect::find(model, &known.id).is_some_and(|law| {
            law.effect.acts_by_position(turns) || matches!(law.effect.law, Law::Formula(_))
        })
    };
    let hangs = turns && model.tool.mass_kg > 0.0;
    hangs || !model.contact.walls.is_empty() || model.effects.iter().any(by_position)
}

/// The inputs of a simulation, in words.
fn from(is_free: bool) -> &'static str {
    match is_free {
        true => "from its beginning, without a force,",
        false => "from the recorded force alone",
    }
}

/// Law of an effect of the tool, in addition to the nominal tool.
type ToolLaw = fn(&[f64], &ToolState) -> Wrench<f64>;

/// The carried body, along or about one axis.
struct Body {
    load: LoadModel,
    /// The nominal tool, and the effects that act on it.
    tool: ToolState,
    tool_laws: Vec<(ToolLaw, Vec<f64>)>,
    axis: Axis,
    direction: Vector3<f64>,
    first: Pose<f64>,
    start: f64,
    /// Position at the beginning of the log, of which the simulation may cover a part.
    rest: f64,
    /// Nothing drives it.
    is_free: bool,
    /// See [`FreeSimulation::drifts`].
    drifts: bool,
}

impl Body {
    fn new(model: &Model, log: &Log, axis: Axis) -> Self {
        let of_tool = |known: &EffectModel| {
            let effect = LoadEffect::find(model, &known.id)?;
            match effect.effect.law {
                Law::Tool(law) => {
                    Some((law as ToolLaw, effect.values_or_defaults(&known.parameters)))
                }
                _ => None,
            }
        };
        let mut body = Self {
            load: LoadModel::new(model),
            tool: nominal_tool(model),
            tool_laws: model.effects.iter().filter_map(of_tool).collect(),
            axis,
            direction: Vector3::ith(axis.index() % 3, 1.0),
            first: log.pose[0],
            start: 0.0,
            rest: 0.0,
            is_free: model.sensor.wrench == WrenchMeaning::Free,
            drifts: !acts_by_position(model, axis),
        };
        body.start = body.at(&log.pose[0], log.whole_turns);
        body.rest = body.at(&pose_of(&log.began.pose), log.began.whole_turns);
        body
    }

    /// Position along the axis, or angle about it with whole turns, in each cycle.
    fn along_axis(&self, log: &Log) -> Vec<f64> {
        match self.axis.is_rotation() {
            true => angles(log.turned_poses(), &self.direction, log.whole_turns),
            false => positions(&log.pose, &self.direction),
        }
    }

    /// The same of one pose and its whole turns.
    fn at(&self, pose: &Pose<f64>, whole_turns: i32) -> f64 {
        match self.axis.is_rotation() {
            true => angle_about(pose, &self.direction) + TAU * f64::from(whole_turns),
            false => self.direction.dot(&pose.translation.vector),
        }
    }

    /// Component of a reading along or about the axis, N or N·m, moved to M.
    fn along(&self, reading: &Wrench<f64>, pose: &Pose<f64>) -> f64 {
        let at_m = reading.transferred(&self.load.m_from_s);
        // A guide has its direction in C, a bearing in M.
        match self.axis.is_rotation() {
            true => at_m.torque.dot(&self.direction),
            false => (pose.rotation * at_m.force).dot(&self.direction),
        }
    }

    fn pose(&self, position: f64) -> Pose<f64> {
        let moved = self.direction * (position - self.start);
        let mut pose = self.first;
        match self.axis.is_rotation() {
            false => pose.translation.vector += moved,
            true => pose.rotation *= UnitQuaternion::from_scaled_axis(moved),
        }
        pose
    }

    /// Reading, along the axis, of the carried body with an acceleration.
    fn reading(&self, slide: &Slide, acceleration: f64) -> f64 {
        let pose = self.pose(slide.position);
        let twist = |value: f64| {
            let mut six = [0.0; 6];
            six[self.axis.index()] = value;
            Twist::of(&six)
        };
        let motion = Motion {
            velocity: twist(slide.velocity),
            acceleration: twist(acceleration),
        };
        let mut reading = self.load.wrench(&pose, &motion);
        if !self.tool_laws.is_empty() {
            let m_from_s = &self.load.m_from_s;
            let s_from_c = (pose.rotation * m_from_s.rotation).inverse();
            let s_from_c = s_from_c.to_rotation_matrix().into_inner();
            let tool = in_motion(self.tool, s_from_c, m_from_s, &pose, &motion);
            for (law, values) in &self.tool_laws {
                reading = reading + law(values, &tool);
            }
        }
        self.along(&reading, &pose)
    }

    /// Decrease of the reading per unit of acceleration, the effective inertia; kg or kg·m².
    fn inertia(&self, slide: &Slide) -> f64 {
        self.reading(slide, 0.0) - self.reading(slide, 1.0)
    }
}

/// A law of the model's effects, with its values.
enum Part {
    /// Force along, or torque about, the axis.
    Along(Guide, Direction, Vec<f64>),
    /// Force by the displacement from the rest position. The number is 1 if it rests where the log begins.
    Spring(fn(&[f64], &Vector3<f64>) -> Vector3<f64>, f64, Vec<f64>),
    /// Constant offset of the reading.
    Offset(Wrench<f64>),
}

/// All effects of the model that act on the motion.
struct Acting {
    parts: Vec<Part>,
    late: DelayAndLag,
}

impl Acting {
    /// The effects of a model; the error is the id of one that acts on more than the motion.
    fn of_model(model: &Model) -> Result<Self, String> {
        let mut acting = Self {
            parts: Vec::new(),
            late: DelayAndLag::default(),
        };
        for known in &model.effects {
            let id = || known.id.clone();
            let effect = LoadEffect::find(model, &known.id).ok_or_else(id)?;
            let values = effect.values_or_defaults(&known.parameters);
            let form = |name| effect.effect.place(name).map_or(0.0, |k| values[k]);
            match effect.effect.law {
                Law::Guide(law) | Law::Bearing(law) => {
                    let reversal = (law.reversal)(&values).ok_or_else(id)?;
                    let part = Part::Along(law, Direction::new(reversal), values);
                    acting.parts.push(part);
                }
                Law::Spring(law) => {
                    let about_start = form("about_start");
                    acting.parts.push(Part::Spring(law, about_start, values));
                }
                Law::SensorZero(law) if law(&values, 0.0) == law(&values, 1.0) => {
                    acting.parts.push(Part::Offset(law(&values, 0.0)));
                }
                Law::Actuator(Actuator {
                    late: Some(law), ..
                }) => {
                    let late = law(&values);
                    acting.late.delay_s += late.delay_s;
                    acting.late.lag_s += late.lag_s;
                }
                // Part of [`Body`].
                Law::Tool(_) => {}
                _ => return Err(id()),
            }
        }
        Ok(acting)
    }

    /// Effective inertia of the carried body and of the effects: decrease of the reading per unit of acceleration, kg or kg·m².
    fn inertia(&self, body: &Body, slide: &Slide) -> f64 {
        let with = |acceleration: f64| {
            let slide = Slide {
                acceleration,
                ..*slide
            };
            let of = |part: &Part| match part {
                Part::Along(law, _, values) => (law.force)(values, &slide),
                Part::Spring(..) | Part::Offset(_) => 0.0,
            };
            self.parts.iter().map(of).sum::<f64>()
        };
        body.inertia(slide) + with(0.0) - with(1.0)
    }

    /// The recorded force along the axis, without constant offsets, delayed as the effects say.
    fn input(&self, body: &Body, log: &Log) -> Vec<f64> {
        let offset = self.parts.iter().filter_map(|part| match part {
            Part::Offset(wrench) => Some(*wrench),
            _ => None,
        });
        let offset = offset.fold(Wrench::zero(), |sum, wrench| sum + wrench);
        let along = |n: usize| {
            let reading = Wrench::of(&log.wrench.each_ref().map(|series| series[n]));
            body.along(&(reading - offset), &log.pose[n])
        };
        let mut late: Option<DelayLine> = None;
        let arrived = |n: usize| {
            let mut six = [0.0; 6];
            six[0] = along(n);
            let line = late.get_or_insert_with(|| DelayLine::new(self.late, log.cycle_s, six));
            line.advance(six)[0]
        };
        (0..log.cycle_count()).map(arrived).collect()
    }

    /// One step under a constant force.
    fn step(&mut self, body: &Body, slide: &mut Slide, force: f64, step_s: f64) {
        let middle = Slide {
            position: slide.position + 0.5 * step_s * slide.velocity,
            ..*slide
        };
        let (nominal, inertia) = (body.reading(&middle, 0.0), body.inertia(&middle));
        let ends = |velocity: f64| Slide {
            velocity: 0.5 * (slide.velocity + velocity),
            acceleration: (velocity - slide.velocity) / step_s,
            ..middle
        };
        // Falls with the velocity, as all that brakes grows with it.
        let excess = |velocity: f64| {
            let at = ends(velocity);
            let load = self.force(body, &at, velocity, step_s);
            nominal - inertia * at.acceleration + load - force
        };
        let per_excess = step_s / self.inertia(body, &middle);
        let velocity = root(excess, slide.velocity, per_excess);
        let path = 0.5 * (slide.velocity + velocity) * step_s;
        for part in &mut self.parts {
            if let Part::Along(_, direction, _) = part {
                direction.advance_by(path);
            }
        }
        slide.position += path;
        slide.velocity = velocity;
    }

    /// Force of the effects at the middle of a step that ends with velocity `end`.
    fn force(&self, body: &Body, at: &Slide, end: f64, step_s: f64) -> f64 {
        let of = |part: &Part| match part {
            Part::Along(law, direction, values) => {
                let mut moved = *direction;
                moved.advance_by(at.velocity * step_s);
                let direction = moved.at(end);
                (law.force)(values, &Slide { direction, ..*at })
            }
            Part::Spring(law, about_start, values) => {
                let from = if *about_start > 0.5 { body.rest } else { 0.0 };
                let displacement = body.direction * (at.position - from);
                law(values, &displacement).dot(&body.direction)
            }
            Part::Offset(_) => 0.0,
        };
        self.parts.iter().map(of).sum()
    }
}

/// Zero of a decreasing function; at a jump through zero, the jump. `per_excess` times the value at the start is the first step
/// of the search.
fn root(falls: impl Fn(f64) -> f64, start: f64, per_excess: f64) -> f64 {
    /// Largest number of doublings of the first step, and of halvings of the bracket.
    const DOUBLINGS: usize = 60;
    const HALVINGS: usize = 50;
    let first = falls(start);
    let mut step = per_excess * first;
    let mut end = start + step;
    for _ in 0..DOUBLINGS {
        if step == 0.0 || falls(end) * first <= 0.0 {
            break;
        }
        step *= 2.0;
        end += step;
    }
    let (mut low, mut high) = if step < 0.0 {
        (end, start)
    } else {
        (start, end)
    };
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if falls(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
