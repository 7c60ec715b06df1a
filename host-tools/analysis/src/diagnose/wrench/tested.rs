//! A hypothesis with refined shapes.

use super::fitted::Fitted;
use super::joint::Joint;
use super::problem::{Problem, Solution};
use super::search::{Hypothesis, Part};
use super::shaped::{ShapeDeviations, Shaped};
use super::variants::Library;
use crate::diagnose::evidence::Foretold;
use crate::diagnose::finding::Trial;
use crate::diagnose::named::INTERVAL_95;
use softdock_physics::model::Channel;
use softdock_physics::model::load::effects::{
    Coefficient, LoadEffect, Pace, Shape, Valued, added, contribution,
};
use softdock_physics::model::load::{Column, Scene};
use softdock_physics::optimise::brent;
use softdock_report::number;
use std::collections::BTreeMap;

/// Gain in χ² below which shapes are not worth refining.
const WORTH_REFINING: f64 = 40.0;

/// A hypothesis after its shapes were refined, with its evidence on all logs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tested {
    /// Its effects.
    pub effects: Vec<Fitted>,
    /// Ids of what the model had already.
    pub beside: Vec<String>,
    /// χ² of all there was to explain. Its unit is the noise beside which the hypothesis was tried: that is the same where
    /// this is.
    pub to_explain: f64,
    /// Fall of χ² over all logs.
    pub gain: f64,
    /// Fall of χ² of each log.
    pub gains: Vec<f64>,
    /// Gain less the price of the parameters and the prior odds of the effects.
    pub evidence: f64,
    /// Number of parameters.
    pub parameters: usize,
    /// Parameters with a sign that physics forbids, or out of any plausible range; effects that are larger than what was
    /// measured by so much that they would have to cancel each other more exactly than laws hold.
    pub wrong: Vec<String>,
    /// Fall of the squared distance to the intervals of rounded readings.
    pub beyond_rounding: f64,
}

impl Tested {
    pub(super) fn trial(&self) -> Trial {
        Trial {
            effects: self.ids(),
            channel: Channel::Wrench,
            gain: self.gain,
        }
    }

    /// With χ² in the unit in which there is so much to explain.
    pub(crate) fn beside_noise(mut self, to_explain: f64) -> Self {
        let by = to_explain / self.to_explain;
        self.to_explain = to_explain;
        self.gain *= by;
        self.evidence *= by;
        self.gains.iter_mut().for_each(|gain| *gain *= by);
        self
    }

    /// Whether its effects are those of another hypothesis, in whatever order.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.effects_in_order() == other.effects_in_order()
    }

    /// Ids by the alphabet: those of the same effects are equal.
    pub(crate) fn effects_in_order(&self) -> Vec<&'static str> {
        let mut ids: Vec<&'static str> = self.effects.iter().map(|e| e.id).collect();
        ids.sort_unstable();
        ids
    }

    /// Ids, in order.
    pub(crate) fn ids(&self) -> Vec<String> {
        self.effects.iter().map(|e| e.id.to_owned()).collect()
    }

    fn valued(&self, scene: &Scene) -> Vec<Valued<'static>> {
        let effects = self.effects.iter();
        effects.filter_map(|one| one.valued(scene)).collect()
    }

    /// Its effects that do not move the reading in time.
    pub(super) fn loads(&self, scene: &Scene) -> Vec<Valued<'static>> {
        let mut loads = self.valued(scene);
        loads.retain(|(effect, _)| !effect.is_late());
        loads
    }

    /// Their part of a reading.
    pub(crate) fn contribution(&self, scene: &Scene) -> Column {
        contribution(scene, &self.valued(scene))
    }

    /// The part of one of them, or of one of its terms, so that the parts are the whole: what moves the reading in time
    /// does so to what the others load the sensor with.
    pub(crate) fn part(&self, scene: &Scene, one: &Fitted) -> Column {
        match one.valued(scene) {
            Some(late) if late.0.is_late() => added(scene, &self.loads(scene), late),
            Some(load) => contribution(scene, &[load]),
            None => Column::default(),
        }
    }
}

/// Refines the shapes of a hypothesis on all logs.
pub(super) fn tested(library: &Library, hypothesis: &Hypothesis, joint: &Joint) -> Tested {
    let mut tested = fitted_to(&joint.problem, library, hypothesis, joint, Care::Screening);
    tested.beyond_rounding = joint.gain_beyond_rounding(&tested);
    tested
}

/// How carefully shapes are refined.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Care {
    /// Once, one after the other.
    Screening,
    /// Until they fit each other, with the covariance of everything together.
    Estimating,
}

impl Care {
    /// Share of a shape to which its best value is known: χ² hardly changes on the way there.
    fn resolution(self) -> f64 {
        match self {
            Self::Screening => 10.0 * RESOLVED,
            Self::Estimating => RESOLVED,
        }
    }

    /// Rise of the gain in χ² below which steps of Gauss and Newton end: a parameter costs more by far than what
    /// screening leaves.
    pub(super) fn rise(self) -> f64 {
        match self {
            Self::Screening => 1.0,
            Self::Estimating => 1e-3,
        }
    }
}

/// The same, fitted to some rows of the logs.
pub(super) fn fitted_to(
    problem: &Problem,
    library: &Library,
    hypothesis: &Hypothesis,
    joint: &Joint,
    care: Care,
) -> Tested {
    /// Rounds over all shapes.
    const ROUNDS: usize = 3;
    let parts = &hypothesis.parts;
    let mut shapes: Vec<Vec<f64>> = parts
        .iter()
        .map(|p| library.variants[p.variant].shapes.clone())
        .collect();
    let mut shaped = Shaped::new(joint, problem, library, parts);
    let mut sigmas = ShapeDeviations::new();
    let mut stepped = ShapeDeviations::new();
    // Shapes of a hopeless hypothesis are not worth refining.
    let rounds = match care {
        _ if hypothesis.solution.gain <= WORTH_REFINING => 0,
        Care::Screening => 1,
        Care::Estimating => ROUNDS,
    };
    for round in 0..rounds {
        for (i, part) in parts.iter().enumerate() {
            let effect = library.variants[part.variant].effect;
            for (k, shape) in effect.shapes.iter().enumerate() {
                if !has_size(shape, shapes[i][k]) {
                    continue;
                }
                let gain = |own: &[f64]| shaped.gain_with(i, own);
                let range = match round {
                    0 => neighbours(shapes[i][k], &effect.tried(shape, joint.pace())),
                    _ => (NEAR.recip() * shapes[i][k], NEAR * shapes[i][k]),
                };
                let range = plausible(effect, shape, shapes[i][k], range, joint.pace());
                let sigma = refine(&mut shapes[i], k, range, care.resolution(), &gain);
                if !shape.choice {
                    sigmas.insert((i, k), sigma);
                }
                shaped.set(i, &shapes[i]);
            }
        }
    }
    if rounds > 0 && care == Care::Estimating {
        shaped.refine_together(&mut shapes);
        for (&(i, k), sigma) in &sigmas {
            let gain = |own: &[f64]| shaped.gain_with(i, own);
            if let Some((middle, half)) = step_around(&shapes[i], k, &gain)
                && half > STEP_WIDENS * sigma
            {
                shapes[i][k] = middle;
                stepped.insert((i, k), half);
                shaped.set(i, &shapes[i]);
            }
        }
    }
    let solution = shaped.solution().unwrap_or_else(|| Solution {
        gain: 0.0,
        ..hypothesis.solution.clone()
    });
    let linear = |part: &Part| library.variants[part.variant].effect.is_linear();
    let solution = if parts.iter().all(linear) {
        solution
    } else {
        exact(solution, &mut shaped, &shapes)
    };
    let steps = if rounds > 0 { ROUNDS } else { 0 };
    let (solution, white) = match shaped.together(&solution, &shapes, steps, care) {
        Some(together) => together,
        None => {
            let white = shaped.sum(&solution.coefficients);
            (solution, white)
        }
    };
    let mut deviations = solution.sigma.clone();
    if care == Care::Estimating
        && let Some((own, of_shapes)) = shaped.deviations(&solution.coefficients, &shapes)
    {
        deviations = own;
        for (place, sigma) in &mut sigmas {
            *sigma = of_shapes.get(place).copied().unwrap_or(*sigma);
            *sigma = sigma.max(stepped.get(place).copied().unwrap_or(0.0));
        }
    }
    let mut effects = Vec::new();
    let mut wrong = Vec::new();
    let mut at = 0;
    for (i, part) in parts.iter().enumerate() {
        let effect = library.variants[part.variant].effect;
        let mut parameters = BTreeMap::new();
        for &k in &part.used {
            if let Some(coefficient) = effect.coefficients.get(k) {
                let value = solution.coefficients[at];
                parameters.insert(coefficient.name, (value, deviations[at], coefficient.unit));
                let model = &joint.logs[0].scene.model;
                if solution.wrong.contains(&at)
                    || effect.is_implausible(model, coefficient.name, value)
                {
                    wrong.push(forbidden(effect, coefficient, value));
                }
            }
            at += 1;
        }
        for (k, shape) in effect.shapes.iter().enumerate() {
            let sigma = sigmas.get(&(i, k)).copied().unwrap_or(0.0);
            parameters.insert(shape.name, (shapes[i][k], sigma, shape.unit));
        }
        effects.push(Fitted {
            beside_remainder: 1.0,
            elsewhere: BTreeMap::new(),
            foretold: Foretold::UNKNOWN,
            id: effect.id,
            parameters,
        });
    }
    wrong.extend(effects.iter().filter_map(|effect| joint.oversized(effect)));
    let improvement = solution.gain - hypothesis.solution.gain;
    let known = joint
        .logs
        .iter()
        .take(1)
        .flat_map(|l| &l.scene.model.effects);
    Tested {
        effects,
        beside: known.map(|e| e.id.clone()).collect(),
        to_explain: problem.chi2,
        gain: solution.gain,
        gains: problem.gains(&white),
        evidence: hypothesis.evidence + improvement,
        parameters: hypothesis.parameters,
        wrong,
        beyond_rounding: f64::INFINITY,
    }
}

/// Why an amount is refused; of one that the logs leave open, the end of its range is said.
fn forbidden(effect: &LoadEffect, coefficient: &Coefficient, value: f64) -> String {
    /// Ranges beyond which a value is no estimate.
    const OPEN: f64 = 1e3;
    let unit = match coefficient.unit {
        "-" => String::new(),
        unit => format!(" {unit}"),
    };
    let known = effect
        .parameters
        .iter()
        .find(|p| p.name == coefficient.name);
    let farthest = known.map_or(f64::INFINITY, |p| p.low.abs().max(p.high.abs()));
    let is_beyond = known.is_some_and(|p| value > p.high);
    let is_of_the_tool = known.is_some_and(|p| p.of_the_tool != 0.0 && p.is_plausible(value));
    let (compared, value) = match value.abs() > OPEN * farthest {
        true => (
            if value < 0.0 { "<" } else { ">" },
            farthest.copysign(value),
        ),
        false => ("=", value),
    };
    let digits = number::significant(value, 3);
    let amount = format!("{} {compared} {digits}{unit}", coefficient.name);
    match known {
        Some(_) if is_of_the_tool => format!("{amount} is too little for the tool of the model"),
        Some(p) if p.low < 0.0 || is_beyond => format!(
            "{amount} is not plausible ({} to {}{unit})",
            number::significant(p.low, 3),
            number::significant(p.high, 3)
        ),
        _ => format!("physics forbids {amount}"),
    }
}

/// Times that coefficients are found anew with the columns around the last ones.
const ROUNDS: usize = 4;

/// The solution with columns that fit its own coefficients, the best of some rounds.
fn exact(start: Solution, shaped: &mut Shaped<'_>, shapes: &[Vec<f64>]) -> Solution {
    let mut best = start;
    best.gain = shaped
        .gain_around(&best.coefficients, shapes)
        .unwrap_or(best.gain);
    let mut last = best.clone();
    for _ in 0..ROUNDS {
        shaped.set_around(&last.coefficients, shapes);
        let Some(mut next) = shaped.solution() else {
            break;
        };
        let gain = shaped.gain_around(&next.coefficients, shapes);
        next.gain = gain.unwrap_or(f64::NEG_INFINITY);
        if next.gain > best.gain {
            best = next.clone();
        }
        last = next;
    }
    shaped.set_around(&best.coefficients, shapes);
    best
}

/// A shape around which a later round looks goes from one over this to this times its value.
const NEAR: f64 = 1.15;

/// Whether a shape has a size that can be refined: a form of no size has none.
pub(super) fn has_size(shape: &Shape, value: f64) -> bool {
    shape.continuous && value > 0.0
}

/// The part of a range around a value in which a search looks in such logs.
fn plausible(
    effect: &LoadEffect,
    shape: &Shape,
    at: f64,
    (low, high): (f64, f64),
    logs: Pace,
) -> (f64, f64) {
    let known = effect.parameters.iter().find(|p| p.name == shape.name);
    known.map_or((low, high), |p| {
        let [least, most] = effect.searched(p, logs);
        (low.max(least).min(at), high.min(most).max(at))
    })
}

/// The values of a grid on either side.
fn neighbours(at: f64, tried: &[f64]) -> (f64, f64) {
    let positive = || tried.iter().copied().filter(|t| *t > 0.0);
    let lower = positive().filter(|t| *t < at).fold(f64::NAN, f64::max);
    let upper = positive().filter(|t| *t > at).fold(f64::NAN, f64::min);
    (
        if lower.is_nan() { at / 2.0 } else { lower },
        if upper.is_nan() { at * 2.0 } else { upper },
    )
}

/// Deviation by the width of a step over that by the curvature from which χ² counts as moving in steps: on a smooth χ²
/// both are the same, to what [`RESOLVED`] leaves open.
const STEP_WIDENS: f64 = 1.5;
/// Share of a shape to which its best value is known.
const RESOLVED: f64 = 5e-4;

/// Middle of the step of χ² on which the best value near by is, and half of it as a deviation; none if it is no wider than
/// the values are apart. What a play does to a row depends on which side of its end the row is on: χ² moves in steps as the end
/// passes rows, no value on a step is better than another, and the curvature says nothing.
fn step_around(shapes: &[f64], k: usize, gain: &dyn Fn(&[f64]) -> f64) -> Option<(f64, f64)> {
    /// Values on each side, [`RESOLVED`] apart.
    const SIDE: i32 = 40;
    /// By how much χ² is larger at the ends of a 95 % interval.
    const RISE: f64 = INTERVAL_95 * INTERVAL_95;
    let values: Vec<f64> = (-SIDE..=SIDE)
        .map(|step| shapes[k] * (RESOLVED * f64::from(step)).exp())
        .collect();
    let mut trial = shapes.to_vec();
    let gains = values.iter().map(|value| {
        trial[k] = *value;
        gain(&trial)
    });
    let gains: Vec<f64> = gains.collect();
    let best = (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]))?;
    let on = |place: &usize| gains[*place] > gains[best] - RISE;
    let low = (0..=best).rev().take_while(on).last()?;
    let high = (best..gains.len()).take_while(on).last()?;
    let (middle, half) = (
        0.5 * (values[low] + values[high]),
        0.5 * (values[high] - values[low]),
    );
    (high > low + 1).then_some((middle, half / INTERVAL_95))
}

/// Moves one shape to its best value in a range; returns its deviation with all else as it is.
fn refine(
    shapes: &mut [f64],
    k: usize,
    (low, high): (f64, f64),
    resolution: f64,
    gain: &dyn Fn(&[f64]) -> f64,
) -> f64 {
    let at = shapes[k];
    let mut trial = shapes.to_vec();
    let mut cost = |log_value: f64| {
        trial[k] = log_value.exp();
        -gain(&trial)
    };
    let range = (low.ln(), at.ln(), high.ln());
    let (best, least) = brent(range, resolution, &mut cost);
    shapes[k] = best.exp();
    let centre = shapes[k];
    // Curvature of χ² over a step of 5 %: half a unit of log L is one standard deviation.
    let step = 0.05;
    let bend = cost(best + step) + cost(best - step) - 2.0 * least;
    if bend > 0.0 {
        centre * step * (2.0 / bend).sqrt()
    } else {
        0.5 * (high - low)
    }
}
