//! A hypothesis with refined shapes.

use super::prepared_log::Joint;
use super::problem::{Problem, Projected, Solution, solve, subtract};
use super::search::{Hypothesis, Part};
use super::variants::Library;
use crate::diagnose::finding::Trial;
use crate::diagnose::named::INTERVAL_95;
use crate::diagnose::optimise::brent;
use crate::model::load::effects::{LoadEffect, Shape, Sign};
use crate::model::load::{Column, Scene};
use crate::model::{Channel, Model};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Gain in χ² below which shapes are not worth refining.
const WORTH_REFINING: f64 = 40.0;

/// An effect with fitted parameters.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    /// The effect's id.
    pub id: &'static str,
    /// Value, standard deviation and unit of each parameter; choices have no deviation.
    pub parameters: BTreeMap<&'static str, (f64, f64, &'static str)>,
    /// Its amount beside a smooth remainder, of that without.
    pub beside_remainder: f64,
}

impl Fitted {
    /// The effect with one coefficient of its several at a time, where it is their sum.
    pub(super) fn terms(&self, model: &Model) -> Vec<Self> {
        let effect = LoadEffect::find(model, self.id).filter(|effect| effect.is_linear());
        let names = effect.iter().flat_map(|effect| &effect.coefficients);
        let given = |name: &&str| self.parameters.get(name).is_some_and(|p| p.0 != 0.0);
        let names: Vec<&str> = names.map(|c| c.name).filter(given).collect();
        if names.len() < 2 {
            return vec![self.clone()];
        }
        let term = |own: &&str| {
            let mut term = self.clone();
            for other in names.iter().filter(|name| name != &own) {
                if let Some((value, _, _)) = term.parameters.get_mut(other) {
                    *value = 0.0;
                }
            }
            term
        };
        names.iter().map(term).collect()
    }

    /// Takes amount and deviation, a share of all coefficients, from how it stands beside a remainder.
    pub(crate) fn stand(&mut self, (amount, share): (f64, f64)) {
        self.beside_remainder = amount;
        for (value, sigma, _) in self.parameters.values_mut() {
            if *sigma > 0.0 {
                *sigma = sigma.hypot(share * *value);
            }
        }
    }

    /// Whether the logs say more of any coefficient than that it may be 0.
    pub(crate) fn is_determined(&self, model: &Model) -> bool {
        let effect = LoadEffect::find(model, self.id);
        let names = effect.iter().flat_map(|effect| &effect.coefficients);
        let mut open = names.filter_map(|c| self.parameters.get(c.name));
        let is_sure = |(value, sigma): (f64, f64)| {
            let [low, high] = self.interval(value, sigma);
            low * high > 0.0
        };
        effect.is_some_and(|effect| effect.coefficients.is_empty())
            || open.any(|(value, sigma, _)| is_sure((*value, *sigma)))
    }

    /// 95 % interval of a parameter: it holds what the logs say without a remainder and beside one.
    pub(crate) fn interval(&self, value: f64, sigma: f64) -> [f64; 2] {
        let beside = self.beside_remainder * value;
        let reach = INTERVAL_95 * sigma;
        [value.min(beside) - reach, value.max(beside) + reach]
    }
}

/// A hypothesis after its shapes were refined, with its evidence on all logs.
#[derive(Clone, Debug)]
pub(crate) struct Tested {
    /// Its effects.
    pub effects: Vec<Fitted>,
    /// Ids of what the model had already.
    pub beside: Vec<String>,
    /// Fall of χ² over all logs.
    pub gain: f64,
    /// Fall of χ² of each log.
    pub gains: Vec<f64>,
    /// Gain less the price of the parameters and the prior odds of the effects.
    pub evidence: f64,
    /// Number of parameters.
    pub parameters: usize,
    /// Parameters with a sign that physics forbids, or out of any plausible range.
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

    /// Ids, in order.
    pub(crate) fn ids(&self) -> Vec<String> {
        self.effects.iter().map(|e| e.id.to_owned()).collect()
    }

    /// One of its effects.
    pub(crate) fn alone(&self, place: usize) -> Self {
        self.with_only(self.effects[place].clone())
    }

    /// An effect in the place of its own.
    pub(super) fn with_only(&self, effect: Fitted) -> Self {
        Self {
            effects: vec![effect],
            ..self.clone()
        }
    }

    /// Their part of a reading.
    pub(crate) fn contribution(&self, scene: &Scene) -> Column {
        let mut sum = Column::default();
        for fitted in &self.effects {
            let Some(effect) = LoadEffect::find(&scene.model, fitted.id) else {
                continue;
            };
            let values: BTreeMap<String, f64> = fitted
                .parameters
                .iter()
                .map(|(name, (value, _, _))| ((*name).to_owned(), *value))
                .collect();
            sum.add(&effect.contribution(scene, &values).0);
        }
        sum
    }
}

/// The columns of a hypothesis in units of the noise: a shape that moves changes only those of its
/// own part.
struct Shaped<'a> {
    joint: &'a Joint,
    problem: &'a Problem,
    library: &'a Library,
    parts: &'a [Part],
    /// Per part; none where it has nothing to act on.
    white: Vec<Option<Vec<Projected>>>,
    /// Products of all columns, in their order.
    gram: DMatrix<f64>,
    signs: Vec<Sign>,
}

impl<'a> Shaped<'a> {
    fn new(
        joint: &'a Joint,
        problem: &'a Problem,
        library: &'a Library,
        parts: &'a [Part],
    ) -> Self {
        let sign = |part: &'a Part| {
            let signs = &library.variants[part.variant].signs;
            part.used.iter().map(|k| signs[*k])
        };
        let mut shaped = Self {
            joint,
            problem,
            library,
            parts,
            white: vec![None; parts.len()],
            gram: DMatrix::zeros(0, 0),
            signs: parts.iter().flat_map(sign).collect(),
        };
        for (i, part) in parts.iter().enumerate() {
            let variant = &library.variants[part.variant];
            if std::ptr::eq(problem, &joint.problem) {
                let known = part.used.iter().map(|k| variant.columns[*k]);
                let columns = known.map(|c| problem.projected(library.columns[c].clone()));
                shaped.white[i] = Some(columns.collect());
            } else {
                // For small effects, where they are not linear.
                shaped.white[i] = shaped.built(i, &variant.shapes, &[]);
            }
        }
        shaped.multiply();
        shaped
    }

    /// Takes other shapes for a part.
    fn set(&mut self, i: usize, shapes: &[f64]) {
        self.white[i] = self.built(i, shapes, &[]);
        self.multiply();
    }

    fn built(&self, i: usize, shapes: &[f64], around: &[f64]) -> Option<Vec<Projected>> {
        let part = &self.parts[i];
        let effect = self.library.variants[part.variant].effect;
        let mut columns = self
            .joint
            .columns_of(self.problem, effect, shapes, around)?;
        let used = part.used.iter().map(|k| std::mem::take(&mut columns[*k]));
        Some(used.map(|column| self.problem.projected(column)).collect())
    }

    fn multiply(&mut self) {
        let all: Vec<&Projected> = self.white.iter().flatten().flatten().collect();
        self.gram = DMatrix::from_fn(all.len(), all.len(), |i, k| match i <= k {
            true => all[i].product(all[k]),
            false => 0.0,
        });
        self.gram.fill_lower_triangle_with_upper_triangle();
    }

    fn solution(&self) -> Option<Solution> {
        self.solution_with(usize::MAX, &[])
    }

    /// The best solution with other columns for part `i`.
    fn solution_with(&self, i: usize, own: &[Projected]) -> Option<Solution> {
        let mut all: Vec<&Projected> = Vec::with_capacity(self.signs.len());
        let mut changed = 0..0;
        for (k, white) in self.white.iter().enumerate() {
            if k == i {
                changed = all.len()..all.len() + own.len();
                all.extend(own);
            } else {
                all.extend(white.as_ref()?);
            }
        }
        let mut gram = self.gram.clone();
        if !changed.is_empty() {
            gram.resize_mut(all.len(), all.len(), 0.0);
        }
        for a in changed {
            for b in 0..all.len() {
                let product = all[a].product(all[b]);
                (gram[(a, b)], gram[(b, a)]) = (product, product);
            }
        }
        let right = DVector::from_iterator(all.len(), all.iter().map(|p| p.right));
        let places: Vec<usize> = (0..all.len()).collect();
        solve(&gram, &right, &places, &self.signs)
    }

    /// Columns of the parts that are not linear, around coefficients of all columns.
    fn set_around(&mut self, coefficients: &[f64], shapes: &[Vec<f64>]) {
        let mut at = 0;
        for (i, part) in self.parts.iter().enumerate() {
            let own = &coefficients[at..at + part.used.len()];
            at += part.used.len();
            if !self.library.variants[part.variant].effect.is_linear() {
                self.white[i] = self.built(i, &shapes[i], own);
            }
        }
        self.multiply();
    }

    /// By how much χ² really falls with coefficients.
    fn gain_around(&mut self, coefficients: &[f64], shapes: &[Vec<f64>]) -> Option<f64> {
        self.set_around(coefficients, shapes);
        self.white.iter().all(Option::is_some).then(|| {
            let sum = self.sum(coefficients);
            self.problem.gain_of(&sum)
        })
    }

    /// What all parts contribute.
    fn sum(&self, coefficients: &[f64]) -> Column {
        let mut sum = Column::default();
        let columns = self.white.iter().flatten().flatten();
        for (column, factor) in columns.zip(coefficients) {
            subtract(&mut sum, &column.column, -factor);
        }
        sum
    }

    /// Standard deviations of the coefficients, and of the shapes that have a size by part and
    /// place, all together: from the products of the columns with the derivatives of what the shapes
    /// contribute. None if the logs do not determine them.
    fn deviations(
        &self,
        coefficients: &[f64],
        shapes: &[Vec<f64>],
    ) -> Option<(Vec<f64>, ShapeDeviations)> {
        /// Relative step of the derivatives.
        const STEP: f64 = 0.02;
        let mut columns: Vec<Projected> = Vec::new();
        let mut open = Vec::new();
        for (place, column) in self.white.iter().flatten().flatten().enumerate() {
            if self.signs[place] != Sign::One {
                columns.push(column.clone());
                open.push(place);
            }
        }
        let (mut places, mut at) = (Vec::new(), 0);
        for (i, part) in self.parts.iter().enumerate() {
            let own = &coefficients[at..at + part.used.len()];
            at += part.used.len();
            let effect = self.library.variants[part.variant].effect;
            for (k, shape) in effect.shapes.iter().enumerate() {
                if !has_size(shape, shapes[i][k]) {
                    continue;
                }
                let mut slope = Column::default();
                for (factor, side) in [(1.0 + STEP, 1.0), (1.0 - STEP, -1.0)] {
                    let mut moved = shapes[i].clone();
                    moved[k] *= factor;
                    for (column, c) in self.built(i, &moved, own)?.iter().zip(own) {
                        subtract(&mut slope, &column.column, -c * side / (2.0 * STEP));
                    }
                }
                columns.push(self.problem.projected(slope));
                places.push((i, k));
            }
        }
        let size = columns.len();
        let products = DMatrix::from_fn(size, size, |i, k| columns[i].product(&columns[k]));
        let scale: Vec<f64> = (0..size).map(|i| products[(i, i)].sqrt()).collect();
        let unit = DMatrix::from_fn(size, size, |i, k| products[(i, k)] / (scale[i] * scale[k]));
        let covariance = unit.cholesky()?.inverse();
        let sigma = |i: usize| covariance[(i, i)].sqrt() / scale[i];
        let mut of_coefficients = vec![0.0; coefficients.len()];
        for (i, place) in open.iter().enumerate() {
            of_coefficients[*place] = sigma(i);
        }
        let of_shapes = places
            .into_iter()
            .enumerate()
            .map(|(n, (i, k))| ((i, k), sigma(open.len() + n) * shapes[i][k]));
        Some((of_coefficients, of_shapes.collect()))
    }

    /// By how much χ² falls with other shapes for part `i`.
    fn gain_with(&self, i: usize, shapes: &[f64]) -> f64 {
        let own = self.built(i, shapes, &[]);
        let solution = own.and_then(|own| self.solution_with(i, &own));
        solution.map_or(f64::NEG_INFINITY, |s| s.gain)
    }
}

/// Refines the shapes of a hypothesis on all logs.
pub(super) fn tested(library: &Library, hypothesis: &Hypothesis, joint: &Joint) -> Tested {
    let mut tested = fitted_to(&joint.problem, library, hypothesis, joint, Care::Screening);
    tested.beyond_rounding = joint.gain_beyond_rounding(&tested);
    tested
}

/// Standard deviations of shapes, by part and place.
type ShapeDeviations = BTreeMap<(usize, usize), f64>;

/// How carefully shapes are refined.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Care {
    /// Once, one after the other.
    Screening,
    /// Until they fit each other, with the covariance of everything together.
    Estimating,
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
                    0 => neighbours(shapes[i][k], shape.tried),
                    _ => (NEAR.recip() * shapes[i][k], NEAR * shapes[i][k]),
                };
                let sigma = refine(&mut shapes[i], k, range, &gain);
                if !shape.choice {
                    sigmas.insert((i, k), sigma);
                }
                shaped.set(i, &shapes[i]);
            }
        }
    }
    let solution = shaped
        .solution()
        .unwrap_or_else(|| hypothesis.solution.clone());
    let linear = |part: &Part| library.variants[part.variant].effect.is_linear();
    let solution = if parts.iter().all(linear) {
        solution
    } else {
        exact(solution, &mut shaped, &shapes)
    };
    let white = shaped.sum(&solution.coefficients);
    let mut deviations = solution.sigma.clone();
    if care == Care::Estimating
        && let Some((own, of_shapes)) = shaped.deviations(&solution.coefficients, &shapes)
    {
        deviations = own;
        for (place, sigma) in &mut sigmas {
            *sigma = of_shapes.get(place).copied().unwrap_or(*sigma);
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
                    wrong.push(format!(
                        "{} = {value:.3e} {}",
                        coefficient.name, coefficient.unit
                    ));
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
            id: effect.id,
            parameters,
        });
    }
    let improvement = solution.gain - hypothesis.solution.gain;
    let known = joint
        .logs
        .iter()
        .take(1)
        .flat_map(|l| &l.scene.model.effects);
    Tested {
        effects,
        beside: known.map(|e| e.id.clone()).collect(),
        gain: solution.gain,
        gains: joint.gains(problem, &white),
        evidence: hypothesis.evidence + improvement,
        parameters: hypothesis.parameters,
        wrong,
        beyond_rounding: f64::INFINITY,
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
fn has_size(shape: &Shape, value: f64) -> bool {
    shape.continuous && value > 0.0
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

/// Share of a shape to which its best value is known.
const RESOLVED: f64 = 5e-4;

/// Moves one shape to its best value in a range; returns its deviation with all else as it is.
fn refine(
    shapes: &mut [f64],
    k: usize,
    (low, high): (f64, f64),
    gain: &dyn Fn(&[f64]) -> f64,
) -> f64 {
    let at = shapes[k];
    let mut trial = shapes.to_vec();
    let mut cost = |log_value: f64| {
        trial[k] = log_value.exp();
        -gain(&trial)
    };
    let range = (low.ln(), at.ln(), high.ln());
    let (best, least) = brent(range, RESOLVED, &mut cost);
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
