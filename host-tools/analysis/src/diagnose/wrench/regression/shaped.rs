//! The columns of a hypothesis at given shapes, and the regression on them.

use super::hypothesis::Part;
use super::joint::Joint;
use super::memo::{Built, Key};
use super::prepared_log::PreparedLog;
use super::problem::{Problem, Projected, Solution, products, solve, subtract};
use super::variants::Library;
use nalgebra::{DMatrix, DVector};
use softdock_physics::model::load::Column;
use softdock_physics::model::load::effects::{LoadEffect, Shape, Sign};
use softdock_physics::model::load::loaded::{Loaded, ValuedEffect};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

/// Relative precision with which the best value of a shape is found for an estimate.
pub(super) const RESOLVED: f64 = 5e-4;

/// The effort of a fit.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Care {
    /// Each shape is refined once, one after the other.
    Screening,
    /// Shapes are refined until they fit each other, with the covariance of all parameters together.
    Estimating,
}

impl Care {
    /// Relative precision with which the best value of a shape is found: χ² hardly changes over such a step.
    pub(super) fn resolution(self) -> f64 {
        match self {
            Self::Screening => 10.0 * RESOLVED,
            Self::Estimating => RESOLVED,
        }
    }

    /// Rise of the gain in χ² below which Gauss-Newton steps end. What screening leaves is far less than the price of a
    /// parameter.
    pub(crate) fn rise(self) -> f64 {
        match self {
            Self::Screening => 1.0,
            Self::Estimating => 1e-3,
        }
    }
}

/// Whether a shape can be refined: it is continuous and not 0, a value that stands for a form without this size.
pub(crate) fn has_size(shape: &Shape, value: f64) -> bool {
    shape.continuous && value > 0.0
}

/// Shapes of a part, and for each log the load on the sensor for one unit of each coefficient at these shapes. `None` for a log
/// where the load is not linear in the coefficients.
type UnitLoads = (Vec<f64>, Rc<Vec<Option<Vec<Column>>>>);

/// The whitened columns of a hypothesis. If a shape moves, the columns of its own part are computed anew.
pub(crate) struct Shaped<'a> {
    pub(super) joint: &'a Joint,
    pub(super) problem: &'a Problem,
    library: &'a Library,
    pub(super) parts: &'a [Part],
    /// Columns of each part; `None` where it has nothing to act on.
    pub(super) white: Vec<Built>,
    /// Shapes of each part and coefficients of all columns at which the columns of late parts were computed.
    pub(super) shapes: Vec<Vec<f64>>,
    coefficients: Vec<f64>,
    /// For each part the last result of [`Self::unit_loads`].
    loads: RefCell<Vec<Option<UnitLoads>>>,
    /// Gram matrix of all columns, in their order.
    pub(super) gram: DMatrix<f64>,
    pub(super) signs: Vec<Sign>,
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
                // On other rows the columns are built anew, around small coefficients where an effect is not linear.
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

    pub(super) fn built(&self, i: usize, shapes: &[f64], around: &[f64]) -> Built {
        if self.is_late(i) {
            return Some([self.beside_others(i, shapes)?].into());
        }
        let (joint, part) = (self.joint, &self.parts[i]);
        let effect = self.effect(part);
        joint.memo.columns(self.key(part, shapes, around), || {
            let columns = joint.columns(self.problem, effect, shapes, &part.used, around)?;
            let columns = columns.into_iter();
            Some(columns.map(|c| self.problem.projected(c)).collect())
        })
    }

    /// All on which the columns of a part depend, as a key of the memo.
    fn key(&self, part: &Part, shapes: &[f64], around: &[f64]) -> Key {
        // Each entry of a catalogue has an address of its own.
        let effect = std::ptr::from_ref(self.effect(part)).addr();
        let counts = [effect, shapes.len(), around.len()].into_iter();
        let counts = counts.chain(part.used.iter().copied());
        let numbers = shapes.iter().chain(around).map(|number| number.to_bits());
        let key = counts.map(|count| count as u64).chain(numbers);
        key.chain(self.problem.fingerprint()).collect()
    }

    /// Whether a part moves in time the load that the other parts put on the sensor.
    fn is_late(&self, i: usize) -> bool {
        self.parts.len() > 1 && self.effect(&self.parts[i]).is_late()
    }

    /// Computes the columns of late parts, each around the load of the other parts.
    fn move_in_time(&mut self) {
        /// The coefficients of the other parts are first those without, then those beside the late ones.
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

    /// Coefficients of all columns for a start: those of loads are fitted with nothing late, those of late parts are 1.
    fn coefficients_of_loads(&self) -> Vec<f64> {
        let loads = |i: &usize| !self.is_late(*i);
        let all = (0..self.parts.len()).filter(loads);
        let all: Vec<&Projected> = all
            .filter_map(|i| self.white[i].as_ref())
            .flat_map(|own| own.iter())
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

    /// The column of a late part: the difference that it makes to the reading of the other parts. `None` if that is 0.
    fn beside_others(&self, i: usize, shapes: &[f64]) -> Option<Projected> {
        let effect = self.effect(&self.parts[i]);
        let own = (effect, effect.values(shapes, &[]));
        let added = |others: Loaded<'_>| others.added(own.clone());
        let white = self.over_logs(&self.coefficients, &self.shapes, Some(i), &added)?;
        (!white.is_zero()).then(|| self.problem.projected(white))
    }

    /// Applies `read` to the loaded sensor of each log, with all parts but `but`, and whitens the result. `None` if there are
    /// fewer coefficients than columns.
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

    /// The load of a part on the sensor of each log for one unit of each coefficient; kept until its shapes change.
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

    /// Places of the coefficients of a part among those of all parts.
    fn places(&self, i: usize) -> std::ops::Range<usize> {
        let before = self.parts[..i].iter().map(|part| part.used.len()).sum();
        before..before + self.parts[i].used.len()
    }

    pub(super) fn multiply(&mut self) {
        let all: Vec<&Projected> = self
            .white
            .iter()
            .flatten()
            .flat_map(|own| own.iter())
            .collect();
        self.gram = products(&all);
    }

    pub(crate) fn solution(&self) -> Option<Solution> {
        self.solution_with(usize::MAX, &[])
    }

    /// The best solution with the columns `own` in the place of those of part `i`.
    fn solution_with(&self, i: usize, own: &[Projected]) -> Option<Solution> {
        let mut all: Vec<&Projected> = Vec::with_capacity(self.signs.len());
        let mut changed = 0..0;
        for (k, white) in self.white.iter().enumerate() {
            if k == i {
                changed = all.len()..all.len() + own.len();
                all.extend(own);
            } else {
                all.extend(white.as_ref()?.iter());
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

    /// Linearises the parts that are not linear in their coefficients around given ones.
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

    /// By how much χ² falls with given coefficients, the columns linearised around them. `None` if a part has nothing to act on.
    pub(crate) fn gain_around(&mut self, coefficients: &[f64], shapes: &[Vec<f64>]) -> Option<f64> {
        self.set_around(coefficients, shapes);
        self.white.iter().all(Option::is_some).then(|| {
            let sum = self.sum(coefficients);
            self.problem.gain_of(&sum)
        })
    }

    /// The whitened contribution of all parts.
    pub(crate) fn sum(&self, coefficients: &[f64]) -> Column {
        let mut sum = Column::default();
        let columns = self.white.iter().flatten().flat_map(|own| own.iter());
        for (column, factor) in columns.zip(coefficients) {
            subtract(&mut sum, &column.column, -factor);
        }
        sum
    }

    pub(super) fn effect(&self, part: &Part) -> &'static LoadEffect {
        self.library.variants[part.variant].effect
    }

    /// The effects with their values; `None` if there are fewer coefficients than columns.
    fn valued(
        &self,
        coefficients: &[f64],
        shapes: &[Vec<f64>],
    ) -> Option<Vec<ValuedEffect<'static>>> {
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

    /// The whitened contribution of all parts, evaluated together and not linearised.
    pub(super) fn joint_contribution(
        &self,
        coefficients: &[f64],
        shapes: &[Vec<f64>],
    ) -> Projected {
        let all = self.over_logs(coefficients, shapes, None, &|all| all.read());
        self.problem.projected(all.unwrap_or_default())
    }

    /// Columns of all parts; `None` if one has nothing to act on in these rows.
    pub(super) fn columns(&self) -> Option<Vec<&Projected>> {
        let each = self.white.iter().map(Option::as_ref);
        let each: Vec<&Arc<[Projected]>> = each.collect::<Option<_>>()?;
        Some(each.into_iter().flat_map(|own| own.iter()).collect())
    }

    /// Takes other shapes for all parts.
    pub(super) fn set_all(&mut self, shapes: &[Vec<f64>]) {
        self.shapes = shapes.to_vec();
        for (i, own) in shapes.iter().enumerate() {
            self.white[i] = self.built(i, own, &[]);
        }
        self.multiply();
        self.move_in_time();
    }

    /// By how much χ² falls with other shapes for part `i`; −∞ if the part then has nothing to act on.
    pub(crate) fn gain_with(&self, i: usize, shapes: &[f64]) -> f64 {
        let own = self.built(i, shapes, &[]);
        let solution = own.and_then(|own| self.solution_with(i, &own));
        solution.map_or(f64::NEG_INFINITY, |s| s.gain)
    }
}
