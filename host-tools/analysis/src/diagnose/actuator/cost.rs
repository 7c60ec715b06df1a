//! How well an actuator explains the executed velocity of a log.

use super::tried::Scale;
use crate::model::actuator::{Chain, Reading, Stage, Timing, simulate};
use crate::model::log::Log;
use crate::model::prediction::retimed::clock_value;
use crate::model::{Model, ToleranceModel};
use crate::statistics::{Noise, noise_floor};
use nalgebra::{SMatrix, SVector};

/// Tolerances that are spent: more delay, less delay, lag. A delay of whole cycles has another
/// slope to either side, because it lets another command through.
const NUISANCES: usize = 3;
/// Place of more delay among them.
const LONGER: usize = 0;
/// Place of less delay.
const SHORTER: usize = 1;

/// A stage with the values of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Term {
    /// The stage.
    pub stage: Stage,
    /// Its parameters, in the order of [`Stage::parameters`].
    pub values: Vec<f64>,
    /// Axes that have it.
    pub axes: [bool; 6],
}

/// Cost of one axis before the tolerances are spent.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AxisCost {
    /// Σ (r/σ)².
    squares: f64,
    /// Σ J r/σ for a tolerance of delay and lag each.
    gradient: [f64; NUISANCES],
}

/// One log, ready to be explained.
#[derive(Clone)]
pub(crate) struct Cost<'a> {
    log: &'a Log,
    nominal: [Chain; 6],
    /// Executed velocity with it, of the axes that move.
    undisturbed: [Vec<f64>; 6],
    tolerance: ToleranceModel,
    /// Axes that move.
    pub active: [bool; 6],
    /// Noise of each axis that the log itself shows, not below a third of the data sheet's.
    pub sigma: [f64; 6],
    /// The data sheet's.
    pub sheet_sigma: [f64; 6],
    /// Change of the velocity for one tolerance of delay and lag, in σ.
    jacobian: [[Vec<f64>; NUISANCES]; 6],
    /// Their products.
    normal: [[[f64; NUISANCES]; NUISANCES]; 6],
    intervals_s: Vec<f64>,
}

impl<'a> Cost<'a> {
    /// `intervals_s`: true durations of the cycles, empty where they are nominal.
    pub(crate) fn new(model: &Model, log: &'a Log, intervals_s: Vec<f64>) -> Self {
        // Poses that are taken late show a velocity late.
        let late_s = match log.reading {
            Reading::Mean => clock_value(model, "clock_offset", "offset_s"),
            Reading::AtEnd => 0.0,
        };
        let mut active = [false; 6];
        for axis in &model.rig.active_axes {
            active[axis.index()] = log.sent[axis.index()].iter().any(|v| *v != 0.0);
        }
        let mut cost = Self {
            log,
            nominal: std::array::from_fn(|axis| later(model.chain(axis), late_s)),
            undisturbed: Default::default(),
            tolerance: model.tolerance.clone(),
            active,
            sigma: log.velocity_sigma,
            sheet_sigma: log.velocity_sigma,
            jacobian: std::array::from_fn(|_| Default::default()),
            normal: [[[0.0; NUISANCES]; NUISANCES]; 6],
            intervals_s,
        };
        for axis in (0..6).filter(|axis| active[*axis]) {
            cost.prepare(axis);
        }
        cost.linearise(&[]);
        cost
    }

    fn prepare(&mut self, axis: usize) {
        let predicted = self.simulate(&self.nominal[axis], axis);
        self.sigma[axis] = self.noise(&predicted, axis);
        self.undisturbed[axis] = predicted;
    }

    /// Noise that is left of an axis by a prediction.
    fn noise(&self, predicted: &[f64], axis: usize) -> f64 {
        let residual = self.residual(predicted, axis);
        let noise = match self.log.reading {
            Reading::Mean => Noise::Differenced,
            Reading::AtEnd => Noise::White,
        };
        let sheet = self.sheet_sigma[axis];
        let floor = noise_floor(&residual, noise);
        floor.map_or(sheet, |f| f.clamp(0.3 * sheet, 3.0 * sheet))
    }

    /// Takes the noise from what hypotheses leave, where it is clearly less than before: an error
    /// of the model that is as rough as the motion looks like noise. Returns whether it was.
    pub(crate) fn quieten<'t>(&mut self, hypotheses: impl Iterator<Item = &'t [Term]>) -> bool {
        /// Share of the noise before that is clearly less.
        const LESS: f64 = 0.9;
        let mut quieter = self.sigma;
        for terms in hypotheses {
            for axis in (0..6).filter(|axis| self.active[*axis]) {
                let predicted = self.simulate(&self.chain(terms, axis), axis);
                quieter[axis] = quieter[axis].min(self.noise(&predicted, axis));
            }
        }
        let less = |axis: &usize| quieter[*axis] < LESS * self.sigma[*axis];
        let any = (0..6).any(|axis| less(&axis));
        if any {
            self.sigma = quieter;
            self.linearise(&[]);
        }
        any
    }

    /// The same log with the tolerances acting around terms, not around the nominal actuator: an
    /// error of the nominal delay shifts the motion that the terms have made.
    pub(crate) fn around(&self, terms: &[Term]) -> Self {
        let mut around = self.clone();
        around.linearise(terms);
        around
    }

    fn linearise(&mut self, terms: &[Term]) {
        let (delay, lag) = (self.tolerance.transport_delay_s, self.tolerance.lag_s);
        let active = self.active;
        for axis in (0..6).filter(|axis| active[*axis]) {
            let chain = self.chain(terms, axis);
            let predicted = self.simulate(&chain, axis);
            let changes = [(delay, 0.0), (-delay, 0.0), (0.0, lag)];
            let columns = changes.map(|change| self.sensitivity(axis, &chain, change, &predicted));
            let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
            self.normal[axis] =
                std::array::from_fn(|i| std::array::from_fn(|k| dot(&columns[i], &columns[k])));
            self.jacobian[axis] = columns;
        }
    }

    /// Change of the velocity by a tolerance of delay or lag, in σ; none where a value is exact.
    fn sensitivity(
        &self,
        axis: usize,
        chain: &Chain,
        (delay_s, lag_s): (f64, f64),
        predicted: &[f64],
    ) -> Vec<f64> {
        let mut other = *chain;
        other.delay_s = (other.delay_s + delay_s).max(0.0);
        other.lag_s += lag_s;
        if other == *chain {
            return vec![0.0; predicted.len()];
        }
        let other = self.simulate(&other, axis);
        let sigma = self.sigma[axis];
        let change = other.iter().zip(predicted).map(|(o, p)| (o - p) / sigma);
        // Where the residual does not count its slope does not either.
        let unknown = self.settling();
        change
            .enumerate()
            .map(|(n, c)| if n < unknown { 0.0 } else { c })
            .collect()
    }

    /// Executed velocity of an axis with a chain.
    pub(crate) fn simulate(&self, chain: &Chain, axis: usize) -> Vec<f64> {
        let timing = Timing {
            cycle_s: self.log.cycle_s,
            intervals_s: &self.intervals_s,
        };
        let mut velocity = simulate(chain, &self.log.sent[axis], &timing, self.log.reading);
        timing.as_recorded(&mut velocity, self.log.reading);
        velocity
    }

    /// Measured minus predicted.
    pub(crate) fn residual(&self, predicted: &[f64], axis: usize) -> Vec<f64> {
        let mut residual: Vec<f64> = self.log.executed[axis]
            .iter()
            .zip(predicted)
            .map(|(e, p)| e - p)
            .collect();
        // The past of the first cycles is not known.
        let unknown = self.settling().min(residual.len());
        residual[..unknown].fill(0.0);
        residual
    }

    fn settling(&self) -> usize {
        /// Longest past that a hypothesis may have beyond the nominal one, s.
        const PAST_S: f64 = 0.25;
        let past_s = self.nominal[0].delay_s + 5.0 * self.nominal[0].lag_s + PAST_S;
        // A log that starts at rest has no past: nothing was sent, or nothing moves yet.
        let unsent = (0..6).all(|axis| {
            let first = self.log.sent[axis].first().copied().unwrap_or(0.0);
            first.abs() < 1e-9
        });
        let at_rest = unsent || self.stands_still_at_first();
        if at_rest {
            0
        } else {
            (past_s / self.log.cycle_s) as usize + 1
        }
    }

    /// Whether no axis moves until the first command can arrive.
    fn stands_still_at_first(&self) -> bool {
        /// Deviations of the noise that are no motion.
        const STILL: f64 = 4.0;
        let cycles = (self.nominal[0].delay_s / self.log.cycle_s) as usize + 1;
        (0..6).filter(|axis| self.active[*axis]).all(|axis| {
            let first = self.log.executed[axis].iter().take(cycles);
            first.fold(0.0_f64, |m, v| m.max(v.abs())) < STILL * self.sheet_sigma[axis]
        })
    }

    /// The chain of an axis with terms added.
    pub(crate) fn chain(&self, terms: &[Term], axis: usize) -> Chain {
        let mut chain = self.nominal[axis];
        for term in terms.iter().filter(|t| t.axes[axis]) {
            term.stage.apply(&mut chain, &term.values);
        }
        chain
    }

    /// Cost of one axis.
    pub(crate) fn of_axis(&self, chain: &Chain, axis: usize) -> AxisCost {
        if !self.active[axis] {
            return AxisCost::default();
        }
        let predicted = self.simulate(chain, axis);
        let residual = self.residual(&predicted, axis);
        let scale = 1.0 / self.sigma[axis];
        let mut cost = AxisCost::default();
        for r in &residual {
            cost.squares += (r * scale) * (r * scale);
        }
        for (gradient, column) in cost.gradient.iter_mut().zip(&self.jacobian[axis]) {
            *gradient = residual
                .iter()
                .zip(column)
                .map(|(r, c)| r * scale * c)
                .sum();
        }
        cost
    }

    /// Costs of some axes with these terms; the others count nothing.
    pub(crate) fn of_axes(&self, terms: &[Term], axes: &[bool; 6]) -> [AxisCost; 6] {
        std::array::from_fn(|axis| {
            if axes[axis] {
                self.of_axis(&self.chain(terms, axis), axis)
            } else {
                AxisCost::default()
            }
        })
    }

    /// Costs of all axes without any stage.
    pub(crate) fn bare(&self) -> [AxisCost; 6] {
        std::array::from_fn(|axis| self.of_axis(&self.nominal[axis], axis))
    }

    /// χ² of all axes, with what the tolerances of delay and lag take away at their price.
    pub(crate) fn total(&self, axes: &[AxisCost; 6]) -> f64 {
        self.taken(axes).0
    }

    /// χ², and what is taken of each tolerance.
    fn taken(&self, axes: &[AxisCost; 6]) -> (f64, SVector<f64, NUISANCES>) {
        let mut squares = 0.0;
        let mut gradient = SVector::<f64, NUISANCES>::zeros();
        // The prior of one tolerance each.
        let mut normal = SMatrix::<f64, NUISANCES, NUISANCES>::identity();
        for (cost, products) in axes.iter().zip(&self.normal) {
            squares += cost.squares;
            for i in 0..NUISANCES {
                gradient[i] += cost.gradient[i];
                for k in 0..NUISANCES {
                    normal[(i, k)] += products[i][k];
                }
            }
        }
        // A delay is longer or shorter than stated, not both: else its tolerance counted twice.
        let one_sided = |skipped: usize| {
            let (mut normal, mut gradient) = (normal, gradient);
            normal.row_mut(skipped).fill(0.0);
            normal.column_mut(skipped).fill(0.0);
            normal[(skipped, skipped)] = 1.0;
            gradient[skipped] = 0.0;
            let taken = normal.cholesky().map_or(gradient, |c| c.solve(&gradient));
            (squares - gradient.dot(&taken), taken)
        };
        let (longer, shorter) = (one_sided(SHORTER), one_sided(LONGER));
        if longer.0 <= shorter.0 {
            longer
        } else {
            shorter
        }
    }

    /// Residuals of all axes with these terms, in σ, less what the tolerances take.
    pub(crate) fn white(&self, terms: &[Term]) -> [Vec<f64>; 6] {
        let costs = std::array::from_fn(|axis| self.of_axis(&self.chain(terms, axis), axis));
        let taken = self.taken(&costs).1;
        std::array::from_fn(|axis| {
            if !self.active[axis] {
                return Vec::new();
            }
            let predicted = self.simulate(&self.chain(terms, axis), axis);
            let mut white = self.residual(&predicted, axis);
            white.iter_mut().for_each(|r| *r /= self.sigma[axis]);
            for (column, taken) in self.jacobian[axis].iter().zip(&taken) {
                white
                    .iter_mut()
                    .zip(column)
                    .for_each(|(w, c)| *w -= taken * c);
            }
            white
        })
    }

    /// χ² of the nominal actuator with all that it does later by a time, s.
    pub(crate) fn of_later(&self, late_s: f64) -> f64 {
        let axes =
            std::array::from_fn(|axis| self.of_axis(&later(self.nominal[axis], late_s), axis));
        self.total(&axes)
    }

    /// Whether the velocity was measured, not taken from two poses.
    pub(crate) fn is_sampled(&self) -> bool {
        self.log.reading == Reading::AtEnd
    }

    /// Delay of the nominal actuator, s.
    pub(crate) fn delay_s(&self) -> f64 {
        self.nominal[0].delay_s
    }

    /// χ² with these terms and exact nominal values.
    pub(crate) fn exactly(&self, terms: &[Term]) -> f64 {
        (0..6)
            .map(|axis| self.of_axis(&self.chain(terms, axis), axis).squares)
            .sum()
    }

    /// χ² with these terms.
    pub(crate) fn of(&self, terms: &[Term]) -> f64 {
        let axes = std::array::from_fn(|axis| self.of_axis(&self.chain(terms, axis), axis));
        self.total(&axes)
    }

    /// Duration of a cycle, s.
    pub(crate) fn cycle_s(&self) -> f64 {
        self.log.cycle_s
    }

    /// Number of velocities that are judged.
    pub(crate) fn count(&self) -> usize {
        self.count_of(&self.active)
    }

    /// Number of velocities of some axes.
    pub(crate) fn count_of(&self, axes: &[bool; 6]) -> usize {
        axes.iter().filter(|a| **a).count() * self.log.len()
    }

    /// How large the motion of some axes is.
    pub(crate) fn scale(&self, axes: &[bool; 6]) -> Scale {
        let moving = (0..6).filter(|a| axes[*a] && self.active[*a]);
        let series = moving.map(|axis| (&self.log.sent[axis][..], &self.undisturbed[axis][..]));
        Scale::of(series, self.log.cycle_s)
    }
}

fn later(mut chain: Chain, late_s: f64) -> Chain {
    chain.delay_s = (chain.delay_s + late_s).max(0.0);
    chain
}
