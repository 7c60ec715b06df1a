//! The columns of a hypothesis with given shapes.

use super::hypothesis::Part;
use super::joint::Joint;
use super::prepared_log::PreparedLog;
use super::problem::{Problem, Projected, Solution, products, solve, subtract};
use super::variants::Library;
use nalgebra::{DMatrix, DVector};
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::{LoadEffect, Loaded, Shape, Sign, Valued};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Share of a shape to which its best value is known.
pub(super) const RESOLVED: f64 = 5e-4;

/// How carefully shapes are refined.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Care {
    /// Once, one after the other.
    Screening,
    /// Until they fit each other, with the covariance of everything together.
    Estimating,
}

impl Care {
    /// Share of a shape to which its best value is known: χ² hardly changes on the way there.
    pub(super) fn resolution(self) -> f64 {
        match self {
            Self::Screening => 10.0 * RESOLVED,
            Self::Estimating => RESOLVED,
        }
    }

    /// Rise of the gain in χ² below which steps of Gauss and Newton end: a parameter costs more by far than what
    /// screening leaves.
    pub(crate) fn rise(self) -> f64 {
        match self {
            Self::Screening => 1.0,
            Self::Estimating => 1e-3,
        }
    }
}

/// Whether a shape has a size that can be refined: a form of no size has none.
pub(crate) fn has_size(shape: &Shape, value: f64) -> bool {
    shape.continuous && value > 0.0
}

/// What a part with some shapes loads the sensor of each log with by each coefficient that is 1; none where that is not in proportion.
type UnitLoads = (Vec<f64>, Rc<Vec<Option<Vec<Column>>>>);

/// The columns of a hypothesis in units of the noise: a shape that moves changes only those of its
/// own part.
pub(crate) struct Shaped<'a> {
    joint: &'a Joint,
    problem: &'a Problem,
    library: &'a Library,
    parts: &'a [Part],
    /// Per part; none where it has nothing to act on.
    white: Vec<Option<Vec<Projected>>>,
    /// Shapes of each part, and coefficients of all columns, around which the columns of what moves the reading in
    /// time stand.
    shapes: Vec<Vec<f64>>,
    coefficients: Vec<f64>,
    /// Of each part, what it loads the sensor with.
    loads: RefCell<Vec<Option<UnitLoads>>>,
    /// Products of all columns, in their order.
    gram: DMatrix<f64>,
    signs: Vec<Sign>,
}

impl<'a> Shaped<'a> {
    pub(crate) fn new(
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
            shapes: parts
                .iter()
                .map(|part| library.variants[part.variant].shapes.clone())
                .collect(),
            coefficients: Vec::new(),
            loads: RefCell::new(vec![None; parts.len()]),
            gram: DMatrix::zeros(0, 0),
            signs: parts.iter().flat_map(sign).collect(),
        };
        for (i, part) in parts.iter().enumerate() {
            let variant = &library.variants[part.variant];
            if shaped.is_late(i) {
                continue;
            }
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
        shaped.move_in_time();
        shaped
    }

    /// Takes other shapes for a part.
    pub(crate) fn set(&mut self, i: usize, shapes: &[f64]) {
        self.shapes[i] = shapes.to_vec();
        self.white[i] = self.built(i, shapes, &[]);
        self.multiply();
        self.move_in_time();
    }

    fn built(&self, i: usize, shapes: &[f64], around: &[f64]) -> Option<Vec<Projected>> {
        let part = &self.parts[i];
        let effect = self.effect(part);
        if self.is_late(i) {
            return Some(vec![self.beside_others(i, shapes)?]);
        }
        let columns = self
            .joint
            .columns(self.problem, effect, shapes, &part.used, around)?;
        let columns = columns.into_iter();
        Some(columns.map(|c| self.problem.projected(c)).collect())
    }

    /// Whether a part moves in time what others load the sensor with.
    fn is_late(&self, i: usize) -> bool {
        self.parts.len() > 1 && self.effect(&self.parts[i]).is_late()
    }

    /// Columns of what moves the reading in time, around what the others load the sensor with.
    fn move_in_time(&mut self) {
        /// Coefficients of the others without it, then beside it.
        const ROUNDS: usize = 2;
        let late: Vec<usize> = (0..self.parts.len()).filter(|i| self.is_late(*i)).collect();
        if late.is_empty() {
            return;
        }
        for _ in 0..ROUNDS {
            let found = self.solution().map(|found| found.coefficients);
            self.coefficients = found.unwrap_or_else(|| self.coefficients_of_loads());
            for &i in &late {
                self.white[i] = self.built(i, &self.shapes[i], &[]);
            }
            self.multiply();
        }
    }

    /// Coefficients of the others, with nothing moved in time.
    fn coefficients_of_loads(&self) -> Vec<f64> {
        let loads = |i: &usize| !self.is_late(*i);
        let all = (0..self.parts.len()).filter(loads);
        let all: Vec<&Projected> = all
            .filter_map(|i| self.white[i].as_ref())
            .flatten()
            .collect();
        let right = DVector::from_iterator(all.len(), all.iter().map(|p| p.right));
        let places: Vec<usize> = (0..all.len()).collect();
        let of_loads =
            (0..self.parts.len()).flat_map(|i| vec![loads(&i); self.parts[i].used.len()]);
        let signs = self.signs.iter().zip(of_loads.clone());
        let signs: Vec<Sign> = signs
            .filter(|(_, load)| *load)
            .map(|(sign, _)| *sign)
            .collect();
        let found =
            (signs.len() == all.len()).then(|| solve(&products(&all), &right, &places, &signs));
        let mut found = found
            .flatten()
            .map(|s| s.coefficients)
            .unwrap_or_default()
            .into_iter();
        of_loads
            .map(|load| {
                if load {
                    found.next().unwrap_or(0.0)
                } else {
                    1.0
                }
            })
            .collect()
    }

    /// What a part does that the others do not do without it.
    fn beside_others(&self, i: usize, shapes: &[f64]) -> Option<Projected> {
        let effect = self.effect(&self.parts[i]);
        let own = (effect, effect.values(shapes, &[]));
        let added = |others: Loaded<'_>| others.added(own.clone());
        let white = self.over_logs(&self.coefficients, &self.shapes, Some(i), &added)?;
        (!white.is_zero()).then(|| self.problem.projected(white))
    }

    /// What is `read` of the parts, but for one, over all logs, in units of the noise; none if there is not a coefficient of each
    /// column.
    fn over_logs(
        &self,
        coefficients: &[f64],
        shapes: &[Vec<f64>],
        but: Option<usize>,
        read: &dyn Fn(Loaded<'_>) -> Column,
    ) -> Option<Column> {
        let valued = self.valued(coefficients, shapes)?;
        let parts: Vec<usize> = (0..self.parts.len()).filter(|i| Some(*i) != but).collect();
        let loads = parts.iter().map(|&i| self.unit_loads(i, &shapes[i]));
        let loads: Vec<Rc<_>> = loads.collect();
        let of = |(k, log): (usize, &PreparedLog)| {
            if !self.problem.counts(k) {
                return Column::default();
            }
            let (mut load, mut others) = (Column::default(), Vec::new());
            for (&i, of_logs) in parts.iter().zip(&loads) {
                let Some(units) = &of_logs[k] else {
                    others.push(valued[i].clone());
                    continue;
                };
                for (unit, c) in units.iter().zip(&coefficients[self.places(i)]) {
                    subtract(&mut load, unit, -c);
                }
            }
            read(Loaded::by(&log.scene, &others).and(load))
        };
        let columns: Vec<Column> = self.joint.logs.iter().enumerate().map(of).collect();
        Some(self.problem.whitened(&columns.iter().collect::<Vec<_>>()))
    }

    /// What a part loads the sensor with, evaluated once for the same shapes.
    fn unit_loads(&self, i: usize, shapes: &[f64]) -> Rc<Vec<Option<Vec<Column>>>> {
        let known = self.loads.borrow()[i].clone();
        if let Some((_, known)) = known.filter(|(of, _)| of == shapes) {
            return known;
        }
        let part = &self.parts[i];
        let of = |(k, log): (usize, &PreparedLog)| match self.problem.counts(k) {
            true => self.effect(part).unit_loads(&log.scene, shapes, &part.used),
            false => None,
        };
        let of_logs: Rc<Vec<_>> = Rc::new(self.joint.logs.iter().enumerate().map(of).collect());
        self.loads.borrow_mut()[i] = Some((shapes.to_vec(), of_logs.clone()));
        of_logs
    }

    /// Of the coefficients of a part among all.
    fn places(&self, i: usize) -> std::ops::Range<usize> {
        let before = self.parts[..i].iter().map(|part| part.used.len()).sum();
        before..before + self.parts[i].used.len()
    }

    fn multiply(&mut self) {
        let all: Vec<&Projected> = self.white.iter().flatten().flatten().collect();
        self.gram = products(&all);
    }

    pub(crate) fn solution(&self) -> Option<Solution> {
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
    pub(crate) fn set_around(&mut self, coefficients: &[f64], shapes: &[Vec<f64>]) {
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
    pub(crate) fn gain_around(&mut self, coefficients: &[f64], shapes: &[Vec<f64>]) -> Option<f64> {
        self.set_around(coefficients, shapes);
        self.white.iter().all(Option::is_some).then(|| {
            let sum = self.sum(coefficients);
            self.problem.gain_of(&sum)
        })
    }

    /// What all parts contribute.
    pub(crate) fn sum(&self, coefficients: &[f64]) -> Column {
        let mut sum = Column::default();
        let columns = self.white.iter().flatten().flatten();
        for (column, factor) in columns.zip(coefficients) {
            subtract(&mut sum, &column.column, -factor);
        }
        sum
    }

    /// Coefficients with which parts of which one acts on what the others load the sensor with do most
    /// together, from `start`, in at most so many steps of Gauss and Newton, and what they then do. For an estimate
    /// the columns are their slopes from there on; for screening, what each does alone is close to its slope. None if
    /// no part acts on another.
    pub(crate) fn together(
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
        let mut whole = self.whole(&best.coefficients, shapes);
        best.gain = whole.gain();
        for _ in 0..steps {
            if care == Care::Estimating {
                self.set_slopes(&best, shapes, &whole);
            }
            let Some(next) = self.stepped(&best.coefficients, &whole) else {
                break;
            };
            let there = self.whole(&next.coefficients, shapes);
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

    fn effect(&self, part: &Part) -> &'static LoadEffect {
        self.library.variants[part.variant].effect
    }

    /// The parts with their values; none if there is not a coefficient of each column.
    fn valued(&self, coefficients: &[f64], shapes: &[Vec<f64>]) -> Option<Vec<Valued<'static>>> {
        let mut rest = coefficients.iter();
        let valued = |(part, shapes): (&Part, &Vec<f64>)| {
            let effect = self.effect(part);
            let mut all = vec![0.0; effect.coefficients.len()];
            for used in &part.used {
                let value = *rest.next()?;
                if let Some(coefficient) = all.get_mut(*used) {
                    *coefficient = value;
                }
            }
            Some((effect, effect.values(shapes, &all)))
        };
        self.parts.iter().zip(shapes).map(valued).collect()
    }

    /// What all parts together do to the reading.
    fn whole(&self, coefficients: &[f64], shapes: &[Vec<f64>]) -> Projected {
        let all = self.over_logs(coefficients, shapes, None, &|all| all.read());
        self.problem.projected(all.unwrap_or_default())
    }

    /// Takes the slopes of the contribution for the columns of open coefficients.
    fn set_slopes(&mut self, from: &Solution, shapes: &[Vec<f64>], whole: &Projected) {
        /// Of a standard deviation.
        const STEP: f64 = 0.1;
        let mut at = 0;
        for i in 0..self.parts.len() {
            let places = at..at + self.parts[i].used.len();
            at = places.end;
            let slope = |place: usize| {
                let step = STEP * from.sigma[place];
                let mut moved = from.coefficients.clone();
                moved[place] += step;
                let mut slope = self.whole(&moved, shapes).column;
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

    /// Columns of all parts; none if one has nothing to act on in these rows.
    fn columns(&self) -> Option<Vec<&Projected>> {
        let each = self.white.iter().map(Option::as_ref);
        let each: Vec<&Vec<Projected>> = each.collect::<Option<_>>()?;
        Some(each.into_iter().flatten().collect())
    }

    /// The next coefficients, from the slopes at these.
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

    /// Derivatives of what the hypothesis contributes by its open coefficients, and by the logarithms of its shapes that
    /// have a size.
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

    /// Moves all shapes that have a size together, by steps of Gauss and Newton, as long as χ² falls: those that do each
    /// other's work are not found one after the other.
    pub(crate) fn refine_together(&mut self, shapes: &mut [Vec<f64>]) {
        /// An end for steps that hardly rise; each is kept only if χ² falls.
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

    /// One step; half or a quarter of it where the whole does not make χ² fall. The gain after it, none if no part of it
    /// makes χ² fall.
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
                    let [low, high] = effect.searched(p, self.joint.pace());
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

    fn set_all(&mut self, shapes: &[Vec<f64>]) {
        self.shapes = shapes.to_vec();
        for (i, own) in shapes.iter().enumerate() {
            self.white[i] = self.built(i, own, &[]);
        }
        self.multiply();
        self.move_in_time();
    }

    /// Standard deviations of the coefficients, and of the shapes that have a size by part and
    /// place, all together. None if the logs do not determine them.
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

    /// By how much χ² falls with other shapes for part `i`.
    pub(crate) fn gain_with(&self, i: usize, shapes: &[f64]) -> f64 {
        let own = self.built(i, shapes, &[]);
        let solution = own.and_then(|own| self.solution_with(i, &own));
        solution.map_or(f64::NEG_INFINITY, |s| s.gain)
    }
}

/// Derivatives of a hypothesis, and their covariance in units of their lengths.
struct Slopes {
    columns: Vec<Projected>,
    /// Places of the coefficients, which come first.
    open: Vec<usize>,
    /// Part and place of each shape.
    places: Vec<(usize, usize)>,
    scale: Vec<f64>,
    covariance: DMatrix<f64>,
}

/// Standard deviations of shapes, by part and place.
pub(crate) type ShapeDeviations = BTreeMap<(usize, usize), f64>;
