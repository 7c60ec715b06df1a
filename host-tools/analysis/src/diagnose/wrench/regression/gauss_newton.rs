//! Gauss-Newton steps over all coefficients and shapes of a hypothesis together, and the standard deviations from their slopes.

use super::hypothesis::Part;
use super::problem::{Projected, Solution, solve, subtract};
use super::shaped::{Care, Shaped, has_size};
use nalgebra::{DMatrix, DVector};
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::Sign;
use std::collections::BTreeMap;

impl Shaped<'_> {
    /// Solves for all coefficients together where one part acts on the load that the others put on the sensor (a delay, a gain):
    /// at most `steps` Gauss-Newton steps from `start`. Returns the solution and its whitened contribution. For an estimate the
    /// columns are replaced by the slopes at each point; for screening the column of each part alone is close enough. `None` if
    /// no part acts on another.
    pub(crate) fn solve_together(
        &mut self,
        start: &Solution,
        shapes: &[Vec<f64>],
        steps: usize,
        care: Care,
    ) -> Option<(Solution, Column)> {
        let acts = |part: &Part| self.effect(part).acts_on_load();
        if self.parts.len() < 2 || !self.parts.iter().any(acts) {
            return None;
        }
        let mut best = start.clone();
        let mut whole = self.joint_contribution(&best.coefficients, shapes);
        best.gain = whole.gain();
        for _ in 0..steps {
            if care == Care::Estimating {
                self.set_slopes(&best, shapes, &whole);
            }
            let Some(next) = self.stepped(&best.coefficients, &whole) else {
                break;
            };
            let there = self.joint_contribution(&next.coefficients, shapes);
            let gain = there.gain();
            let rise = gain - best.gain;
            if rise.is_nan() || rise <= 0.0 {
                break;
            }
            best = Solution { gain, ..next };
            whole = there;
            if rise < care.rise() {
                break;
            }
        }
        Some((best, whole.column))
    }

    /// Replaces the columns of open coefficients by the slopes of the whole contribution.
    fn set_slopes(&mut self, from: &Solution, shapes: &[Vec<f64>], whole: &Projected) {
        /// Step of the difference quotient, in standard deviations.
        const STEP: f64 = 0.1;
        let mut at = 0;
        for i in 0..self.parts.len() {
            let places = at..at + self.parts[i].used.len();
            at = places.end;
            let slope = |place: usize| {
                let step = STEP * from.sigma[place];
                let mut moved = from.coefficients.clone();
                moved[place] += step;
                let mut slope = self.joint_contribution(&moved, shapes).column;
                subtract(&mut slope, &whole.column, 1.0);
                slope.scale(1.0 / step);
                self.problem.projected(slope)
            };
            let own = places.map(|place| match self.signs[place] {
                Sign::One => self.white[i].as_ref().map(|w| w[0].clone()),
                _ => Some(slope(place)),
            });
            self.white[i] = own.collect();
        }
        self.multiply();
    }

    /// The coefficients after one Gauss-Newton step from `coefficients`.
    fn stepped(&self, coefficients: &[f64], whole: &Projected) -> Option<Solution> {
        let columns = self.columns()?;
        let open: Vec<usize> = (0..columns.len())
            .filter(|place| self.signs[*place] != Sign::One)
            .collect();
        let right = DVector::from_iterator(
            columns.len(),
            columns.iter().map(|c| c.right - c.product(whole)),
        );
        let free = vec![Sign::Free; open.len()];
        let step = solve(&self.gram, &right, &open, &free)?;
        let mut next = Solution {
            gain: 0.0,
            coefficients: coefficients.to_vec(),
            sigma: vec![0.0; columns.len()],
            wrong: Vec::new(),
        };
        for (k, &place) in open.iter().enumerate() {
            next.coefficients[place] += step.coefficients[k];
            next.sigma[place] = step.sigma[k];
            if self.signs[place] == Sign::Positive && next.coefficients[place] < 0.0 {
                next.wrong.push(place);
            }
        }
        Some(next)
    }

    /// Derivatives of the contribution with respect to the open coefficients and to the logarithms of shapes that have a size.
    fn slopes(&self, coefficients: &[f64], shapes: &[Vec<f64>]) -> Option<Slopes> {
        /// Relative step of the derivatives.
        const STEP: f64 = 0.02;
        let mut columns: Vec<Projected> = Vec::new();
        let mut open = Vec::new();
        for (place, column) in self.columns()?.into_iter().enumerate() {
            if self.signs[place] != Sign::One {
                columns.push(column.clone());
                open.push(place);
            }
        }
        let (mut places, mut at) = (Vec::new(), 0);
        for (i, part) in self.parts.iter().enumerate() {
            let own = &coefficients[at..at + part.used.len()];
            at += part.used.len();
            for (k, shape) in self.effect(part).shapes.iter().enumerate() {
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
        let products = |i: usize, k: usize| columns[i].product(&columns[k]);
        let scale: Vec<f64> = (0..columns.len()).map(|i| products(i, i).sqrt()).collect();
        let unit = DMatrix::from_fn(columns.len(), columns.len(), |i, k| {
            products(i, k) / (scale[i] * scale[k])
        });
        let covariance = unit.cholesky()?.inverse();
        Some(Slopes {
            columns,
            open,
            places,
            scale,
            covariance,
        })
    }

    /// Moves all shapes that have a size together by Gauss-Newton steps as long as χ² falls: shapes that can replace each other
    /// are not found one after the other.
    pub(crate) fn refine_together(&mut self, shapes: &mut [Vec<f64>]) {
        /// A limit for many steps with little gain; a step is kept only if χ² falls.
        const STEPS: usize = 8;
        let Some(mut gain) = self.solution().map(|best| best.gain) else {
            return;
        };
        for _ in 0..STEPS {
            let rise = match self.step_together(shapes, gain) {
                Some(next) => next - gain,
                None => return,
            };
            gain += rise;
            if rise < Care::Estimating.rise() {
                return;
            }
        }
    }

    /// One step, or half or a quarter of it if χ² does not fall with the whole. The gain after the step; `None` if χ² falls with
    /// none of these, and the shapes are as before.
    fn step_together(&mut self, shapes: &mut [Vec<f64>], gain: f64) -> Option<f64> {
        /// Largest step of a shape's logarithm.
        const LONGEST: f64 = 0.3;
        let now = self.solution()?;
        let slopes = self.slopes(&now.coefficients, shapes)?;
        let left = self.problem.projected(self.sum(&now.coefficients));
        let right = slopes.columns.iter().map(|c| c.right - c.product(&left));
        let right = right.zip(&slopes.scale).map(|(right, scale)| right / scale);
        let step = &slopes.covariance * DVector::from_iterator(slopes.columns.len(), right);
        let of_shape = |n: usize| step[n + slopes.open.len()] / slopes.scale[n + slopes.open.len()];
        let before = shapes.to_vec();
        for share in [1.0, 0.5, 0.25] {
            for (n, &(i, k)) in slopes.places.iter().enumerate() {
                let effect = self.effect(&self.parts[i]);
                let moved = before[i][k] * (share * of_shape(n).clamp(-LONGEST, LONGEST)).exp();
                let known = effect.parameters.iter();
                let known = known.filter(|p| p.name == effect.shapes[k].name);
                shapes[i][k] = known.fold(moved, |moved, p| {
                    let [low, high] = effect.search_range(p, self.joint.pace());
                    moved.clamp(low, high)
                });
            }
            self.set_all(shapes);
            let next = self.solution().map(|next| next.gain);
            if let Some(next) = next.filter(|next| *next > gain) {
                return Some(next);
            }
        }
        shapes.clone_from_slice(&before);
        self.set_all(shapes);
        None
    }

    /// Standard deviations of all coefficients, and of all shapes that have a size, estimated together. `None` if the logs do not
    /// determine them.
    pub(crate) fn deviations(
        &self,
        coefficients: &[f64],
        shapes: &[Vec<f64>],
    ) -> Option<(Vec<f64>, ShapeDeviations)> {
        let slopes = self.slopes(coefficients, shapes)?;
        let sigma = |i: usize| slopes.covariance[(i, i)].sqrt() / slopes.scale[i];
        let mut of_coefficients = vec![0.0; coefficients.len()];
        for (i, place) in slopes.open.iter().enumerate() {
            of_coefficients[*place] = sigma(i);
        }
        let of_shapes = slopes.places.iter().enumerate();
        let of_shapes =
            of_shapes.map(|(n, &(i, k))| ((i, k), sigma(slopes.open.len() + n) * shapes[i][k]));
        Some((of_coefficients, of_shapes.collect()))
    }
}

/// Derivatives of a hypothesis, and their covariance when each is scaled to unit length.
struct Slopes {
    columns: Vec<Projected>,
    /// Places of the open coefficients, whose columns come first.
    open: Vec<usize>,
    /// Part and place of each shape.
    places: Vec<(usize, usize)>,
    scale: Vec<f64>,
    covariance: DMatrix<f64>,
}

/// Standard deviations of shapes, by part and place.
pub(crate) type ShapeDeviations = BTreeMap<(usize, usize), f64>;
