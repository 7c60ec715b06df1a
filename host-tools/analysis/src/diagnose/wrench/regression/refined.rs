//! Finds the best shapes of a hypothesis (a delay, the speed of a Stribeck curve): first one after the other by a search in one
//! dimension, then, for an estimate, all together.

use super::gauss_newton::ShapeDeviations;
use super::hypothesis::Hypothesis;
use super::joint::Joint;
use super::problem::Solution;
use super::shaped::{Care, RESOLVED, Shaped, has_size};
use super::variants::Library;
use softdock_physics::model::load::effects::{LoadEffect, Pace, Shape};
use softdock_physics::optimise::brent;
use softdock_statistics::DEVIATIONS_95;

/// Gain in χ² up to which the shapes of a hypothesis are not refined.
const WORTH_REFINING: f64 = 40.0;
/// Rounds over all shapes for an estimate; also the number of Gauss-Newton steps after them.
const ROUNDS: usize = 3;

/// Shapes at their best values, with standard deviations.
pub(crate) struct Refined {
    /// Shapes of each part of the hypothesis.
    pub(crate) shapes: Vec<Vec<f64>>,
    /// Standard deviations of shapes that have one, by part and place.
    pub(crate) sigmas: ShapeDeviations,
    /// Standard deviations of the coefficients with all else free; empty if this was not asked for.
    pub(crate) deviations: Vec<f64>,
    /// Standard deviations of shapes in which χ² is a staircase.
    stepped: ShapeDeviations,
    rounds: usize,
}

impl Refined {
    /// Refines the shapes of a hypothesis; `shaped` then holds them.
    pub(crate) fn of(
        hypothesis: &Hypothesis,
        shaped: &mut Shaped<'_>,
        library: &Library,
        joint: &Joint,
        care: Care,
    ) -> Self {
        let of_variant = |variant: usize| library.variants[variant].shapes.clone();
        let parts = hypothesis.parts.iter();
        let mut refined = Self {
            shapes: parts.map(|part| of_variant(part.variant)).collect(),
            sigmas: ShapeDeviations::new(),
            deviations: Vec::new(),
            stepped: ShapeDeviations::new(),
            // Shapes of a hopeless hypothesis are not worth refining.
            rounds: match care {
                _ if hypothesis.solution.gain <= WORTH_REFINING => 0,
                Care::Screening => 1,
                Care::Estimating => ROUNDS,
            },
        };
        for round in 0..refined.rounds {
            for (i, part) in hypothesis.parts.iter().enumerate() {
                let effect = library.variants[part.variant].effect;
                refined.one_by_one(i, effect, shaped, (joint.pace(), round, care));
            }
        }
        if refined.rounds > 0 && care == Care::Estimating {
            shaped.refine_together(&mut refined.shapes);
            refined.find_steps(shaped);
        }
        refined
    }

    /// One pass over the shapes of a part: in the first round between the neighbours on its grid, later near the last value.
    fn one_by_one(
        &mut self,
        i: usize,
        effect: &LoadEffect,
        shaped: &mut Shaped<'_>,
        (pace, round, care): (Pace, usize, Care),
    ) {
        for (k, shape) in effect.shapes.iter().enumerate() {
            let at = self.shapes[i][k];
            if !has_size(shape, at) {
                continue;
            }
            let range = match round {
                0 => neighbours(at, &effect.tried_values(shape, pace)),
                _ => (NEAR.recip() * at, NEAR * at),
            };
            let range = plausible(effect, shape, at, range, pace);
            let gain = |own: &[f64]| shaped.gain_with(i, own);
            let sigma = refine(&mut self.shapes[i], k, range, care.resolution(), &gain);
            if !shape.choice {
                self.sigmas.insert((i, k), sigma);
            }
            shaped.set(i, &self.shapes[i]);
        }
    }

    /// Moves each shape in which χ² is a staircase to the middle of its step.
    fn find_steps(&mut self, shaped: &mut Shaped<'_>) {
        for (&(i, k), sigma) in &self.sigmas {
            let gain = |own: &[f64]| shaped.gain_with(i, own);
            if let Some((middle, half)) = step_around(&self.shapes[i], k, &gain)
                && half > STEP_WIDENS * sigma
            {
                self.shapes[i][k] = middle;
                self.stepped.insert((i, k), half);
                shaped.set(i, &self.shapes[i]);
            }
        }
    }

    /// Number of Gauss-Newton steps over the coefficients; 0 for a hypothesis that was not refined.
    pub(crate) fn steps(&self) -> usize {
        if self.rounds > 0 { ROUNDS } else { 0 }
    }

    /// Sets the standard deviations of coefficients and shapes, all estimated together.
    pub(crate) fn estimate(&mut self, shaped: &Shaped<'_>, solution: &Solution) {
        let Some((own, of_shapes)) = shaped.deviations(&solution.coefficients, &self.shapes) else {
            return;
        };
        self.deviations = own;
        for (place, sigma) in &mut self.sigmas {
            *sigma = of_shapes.get(place).copied().unwrap_or(*sigma);
            *sigma = sigma.max(self.stepped.get(place).copied().unwrap_or(0.0));
        }
    }
}

/// A later round searches a shape from its value over this to its value times this.
const NEAR: f64 = 1.15;

/// The part of a range that the catalogue allows for such logs; it always includes `at`.
fn plausible(
    effect: &LoadEffect,
    shape: &Shape,
    at: f64,
    (low, high): (f64, f64),
    logs: Pace,
) -> (f64, f64) {
    let known = effect.parameters.iter().find(|p| p.name == shape.name);
    known.map_or((low, high), |p| {
        let [least, most] = effect.search_range(p, logs);
        (low.max(least).min(at), high.min(most).max(at))
    })
}

/// The next smaller and the next larger value of a grid; half or twice the value where there is none.
fn neighbours(at: f64, tried: &[f64]) -> (f64, f64) {
    let positive = || tried.iter().copied().filter(|t| *t > 0.0);
    let lower = positive().filter(|t| *t < at).fold(f64::NAN, f64::max);
    let upper = positive().filter(|t| *t > at).fold(f64::NAN, f64::min);
    (
        if lower.is_nan() { at / 2.0 } else { lower },
        if upper.is_nan() { at * 2.0 } else { upper },
    )
}

/// Ratio of the deviation from the width of a step to that from the curvature above which χ² is called a staircase. On a smooth
/// χ² both are the same, up to the resolution [`RESOLVED`].
const STEP_WIDENS: f64 = 1.5;

/// Middle of the step of χ² on which the best value lies, and half its width as a standard deviation; `None` if the step is no
/// wider than the spacing of the values. What a play does to a row depends on which side of its end the row is on. So χ² moves in
/// steps as the end passes rows, no value on one step is better than another, and the curvature says nothing.
fn step_around(shapes: &[f64], k: usize, gain: &dyn Fn(&[f64]) -> f64) -> Option<(f64, f64)> {
    /// Values on each side, [`RESOLVED`] apart.
    const SIDE: i32 = 40;
    /// By how much χ² rises at the ends of a 95 % interval.
    const RISE: f64 = DEVIATIONS_95 * DEVIATIONS_95;
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
    (high > low + 1).then_some((middle, half / DEVIATIONS_95))
}

/// Moves one shape to its best value in a range. Returns its standard deviation with all else held.
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
    // Curvature of χ² over a step of 5 %: χ² rises by 1 at one standard deviation.
    let step = 0.05;
    let bend = cost(best + step) + cost(best - step) - 2.0 * least;
    if bend > 0.0 {
        centre * step * (2.0 / bend).sqrt()
    } else {
        0.5 * (high - low)
    }
}
