//! A hypothesis with refined shapes, held against unseen data.

use super::prepared_log::PreparedLog;
use super::problem::{Problem, Solution};
use super::search::{Hypothesis, Part};
use super::variants::Library;
use crate::model::load::effects::{LoadEffect, Sign};
use crate::model::load::{Column, Scene};
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
}

/// A hypothesis after its shapes were refined, with its evidence on both logs.
#[derive(Clone, Debug)]
pub(crate) struct Tested {
    /// Its effects.
    pub effects: Vec<Fitted>,
    /// Ids of what the model had already.
    pub beside: Vec<String>,
    /// Fall of χ² on the log of the fit.
    pub gain: f64,
    /// Fall of χ² on unseen data with the same parameters.
    pub gain_test: f64,
    /// Gain less the price of the parameters.
    pub evidence: f64,
    /// Number of parameters.
    pub parameters: usize,
    /// Parameters with a sign that physics forbids.
    pub wrong: Vec<String>,
    /// Fall of the squared distance to the intervals of rounded readings, on both logs.
    pub beyond_rounding: (f64, f64),
}

impl Tested {
    /// Ids, in order.
    pub(crate) fn ids(&self) -> Vec<String> {
        self.effects.iter().map(|e| e.id.to_owned()).collect()
    }

    /// Their part of a reading.
    pub(crate) fn contribution(&self, scene: &Scene) -> Column {
        let mut sum: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; scene.len()]);
        for fitted in &self.effects {
            let Some(effect) = LoadEffect::find(fitted.id) else {
                continue;
            };
            let values: BTreeMap<String, f64> = fitted
                .parameters
                .iter()
                .map(|(name, (value, _, _))| ((*name).to_owned(), *value))
                .collect();
            let part = effect.contribution(scene, &values);
            for (sum, part) in sum.iter_mut().zip(part) {
                sum.iter_mut().zip(part).for_each(|(s, p)| *s += p);
            }
        }
        Column(sum)
    }
}

/// Columns of a hypothesis with given shapes, around the given coefficients of its columns.
fn columns(
    library: &Library,
    parts: &[Part],
    shapes: &[Vec<f64>],
    around: &[f64],
    scene: &Scene,
) -> Option<Vec<(Column, Sign)>> {
    let mut all = Vec::new();
    for (part, shapes) in parts.iter().zip(shapes) {
        let variant = &library.variants[part.variant];
        let own = around.get(all.len()..).unwrap_or_default();
        let mut built = variant.effect.columns_at(scene, shapes, own)?;
        for &k in &part.used {
            all.push((std::mem::take(&mut built[k]), variant.signs[k]));
        }
    }
    Some(all)
}

/// The columns of a hypothesis in units of the noise: a shape that moves changes only those of its
/// own part.
struct Shaped<'a> {
    problem: &'a Problem,
    library: &'a Library,
    parts: &'a [Part],
    scene: &'a Scene,
    /// Per part; none where it has nothing to act on.
    white: Vec<Option<Vec<Column>>>,
    signs: Vec<Sign>,
}

impl<'a> Shaped<'a> {
    fn new(
        problem: &'a Problem,
        library: &'a Library,
        parts: &'a [Part],
        scene: &'a Scene,
    ) -> Self {
        let sign = |part: &'a Part| {
            let signs = &library.variants[part.variant].signs;
            part.used.iter().map(|k| signs[*k])
        };
        let mut shaped = Self {
            problem,
            library,
            parts,
            scene,
            white: vec![None; parts.len()],
            signs: parts.iter().flat_map(sign).collect(),
        };
        for (i, part) in parts.iter().enumerate() {
            shaped.set(i, &library.variants[part.variant].shapes);
        }
        shaped
    }

    /// Takes other shapes for a part.
    fn set(&mut self, i: usize, shapes: &[f64]) {
        self.white[i] = self.built(i, shapes);
    }

    fn built(&self, i: usize, shapes: &[f64]) -> Option<Vec<Column>> {
        let part = &self.parts[i];
        let effect = self.library.variants[part.variant].effect;
        // For small effects, where they are not linear.
        let columns = effect.columns_at(self.scene, shapes, &[])?;
        let used = part
            .used
            .iter()
            .map(|k| self.problem.whitened(&columns[*k]));
        Some(used.collect())
    }

    fn solution(&self) -> Option<Solution> {
        self.solution_with(usize::MAX, &[])
    }

    /// The best solution with other columns for part `i`.
    fn solution_with(&self, i: usize, own: &[Column]) -> Option<Solution> {
        let mut all: Vec<&Column> = Vec::with_capacity(self.signs.len());
        for (k, white) in self.white.iter().enumerate() {
            match k == i {
                true => all.extend(own),
                false => all.extend(white.as_ref()?),
            }
        }
        self.problem.solve_whitened(&all, &self.signs)
    }

    /// By how much χ² falls with other shapes for part `i`.
    fn gain_with(&self, i: usize, shapes: &[f64]) -> f64 {
        let own = self.built(i, shapes);
        let solution = own.and_then(|own| self.solution_with(i, &own));
        solution.map_or(f64::NEG_INFINITY, |s| s.gain)
    }
}

/// Refines the shapes of a hypothesis and holds it against unseen data.
pub(super) fn tested(
    library: &Library,
    hypothesis: &Hypothesis,
    train: &PreparedLog,
    test: &PreparedLog,
) -> Tested {
    fitted_to(&train.problem, library, hypothesis, train, test)
}

/// The same, fitted to another regression than that of the whole log.
pub(super) fn fitted_to(
    problem: &Problem,
    library: &Library,
    hypothesis: &Hypothesis,
    train: &PreparedLog,
    test: &PreparedLog,
) -> Tested {
    let parts = &hypothesis.parts;
    let mut shapes: Vec<Vec<f64>> = parts
        .iter()
        .map(|p| library.variants[p.variant].shapes.clone())
        .collect();
    let mut shaped = Shaped::new(problem, library, parts, &train.scene);
    let mut sigmas: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    // Shapes of a hopeless hypothesis are not worth refining.
    if hypothesis.solution.gain > WORTH_REFINING {
        for (i, part) in parts.iter().enumerate() {
            let effect = library.variants[part.variant].effect;
            for (k, shape) in effect.shapes.iter().enumerate().filter(|(_, s)| !s.choice) {
                let gain = |own: &[f64]| shaped.gain_with(i, own);
                let sigma = refine(&mut shapes[i], k, shape.tried, &gain);
                sigmas.insert((i, k), sigma);
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
        exact(solution, problem, |around| {
            columns(library, parts, &shapes, around, &train.scene)
        })
    };
    let mut effects = Vec::new();
    let mut wrong = Vec::new();
    let mut at = 0;
    for (i, part) in parts.iter().enumerate() {
        let effect = library.variants[part.variant].effect;
        let mut parameters = BTreeMap::new();
        for &k in &part.used {
            if let Some(coefficient) = effect.coefficients.get(k) {
                let value = solution.coefficients[at];
                parameters.insert(
                    coefficient.name,
                    (value, solution.sigma[at], coefficient.unit),
                );
                if solution.wrong.contains(&at) {
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
            id: effect.id,
            parameters,
        });
    }
    let improvement = solution.gain - hypothesis.solution.gain;
    let known = &train.scene.model.effects;
    let mut tested = Tested {
        effects,
        beside: known.iter().map(|e| e.id.clone()).collect(),
        gain: solution.gain,
        gain_test: 0.0,
        evidence: hypothesis.evidence + improvement,
        parameters: hypothesis.parameters,
        wrong,
        beyond_rounding: (0.0, 0.0),
    };
    let (on_train, on_test) = (
        tested.contribution(&train.scene),
        tested.contribution(&test.scene),
    );
    tested.gain_test = test.problem.gain_of(&on_test);
    tested.beyond_rounding = (
        train.gain_beyond_rounding(&on_train),
        test.gain_beyond_rounding(&on_test),
    );
    tested
}

/// Times that coefficients are found anew with the columns around the last ones.
const ROUNDS: usize = 4;

/// The solution with columns that fit its own coefficients, the best of some rounds.
fn exact(
    start: Solution,
    problem: &Problem,
    columns: impl Fn(&[f64]) -> Option<Vec<(Column, Sign)>>,
) -> Solution {
    let gain = |solution: &Solution| {
        let columns = columns(&solution.coefficients)?;
        let mut sum = Column::default();
        for ((column, _), factor) in columns.iter().zip(&solution.coefficients) {
            let scaled = column
                .0
                .each_ref()
                .map(|s| s.iter().map(|v| factor * v).collect());
            sum.add(&scaled);
        }
        Some(problem.gain_of(&sum))
    };
    let mut best = start;
    best.gain = gain(&best).unwrap_or(best.gain);
    let mut last = best.clone();
    for _ in 0..ROUNDS {
        let next = columns(&last.coefficients).and_then(|c| problem.solve(&c));
        let Some(mut next) = next else { break };
        next.gain = gain(&next).unwrap_or(f64::NEG_INFINITY);
        if next.gain > best.gain {
            best = next.clone();
        }
        last = next;
    }
    best
}

/// Moves one shape to its best value between its neighbours on the grid; returns its deviation.
fn refine(shapes: &mut [f64], k: usize, tried: &[f64], gain: &dyn Fn(&[f64]) -> f64) -> f64 {
    let at = shapes[k];
    let lower = tried
        .iter()
        .copied()
        .filter(|t| *t < at)
        .fold(f64::NAN, f64::max);
    let upper = tried
        .iter()
        .copied()
        .filter(|t| *t > at)
        .fold(f64::NAN, f64::min);
    let low = if lower.is_nan() { at / 2.0 } else { lower };
    let high = if upper.is_nan() { at * 2.0 } else { upper };
    let mut trial = shapes.to_vec();
    let mut cost = |log_value: f64| {
        trial[k] = log_value.exp();
        -gain(&trial)
    };
    let best = crate::diagnose::optimise::golden(low.ln(), high.ln(), 14, &mut cost);
    if cost(best) <= cost(at.ln()) {
        shapes[k] = best.exp();
    }
    let centre = shapes[k];
    // Curvature of χ² over a step of 5 %: half a unit of log L is one standard deviation.
    let step = 0.05;
    let bend = cost(centre.ln() + step) + cost(centre.ln() - step) - 2.0 * cost(centre.ln());
    if bend > 0.0 {
        centre * step * (2.0 / bend).sqrt()
    } else {
        0.5 * (high - low)
    }
}
