//! χ² of the executed velocities of all logs for a given actuator.

use super::tried::{Scale, slower};
use crate::diagnose::evidence::strained;
use crate::diagnose::noise::autoregressive::LEAST;
use nalgebra::{SMatrix, SVector};
use softdock_actuator::{Chain, Reading, Timing, simulate};
use softdock_physics::model::log::Log;
use softdock_physics::model::stage::Stage;
use softdock_physics::model::{Model, ToleranceModel};
use softdock_statistics::{Noise, dot, noise_floor};
use std::collections::BTreeSet;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Nuisance parameters: longer delay, shorter delay, lag. A delay of whole cycles has a different slope on either side, because
/// it lets another command through.
const NUISANCES: usize = 3;
/// Index of the longer delay among them.
const LONGER: usize = 0;
/// Index of the shorter delay.
const SHORTER: usize = 1;

/// A stage with the values of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Term {
    /// The stage.
    pub stage: Stage,
    /// Its parameters, in the order of [`Stage::parameters`].
    pub values: Vec<f64>,
    /// Axes on which the stage acts.
    pub axes: [bool; 6],
}

/// Cost of one axis over all logs, before the nuisance parameters are eliminated.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AxisCost {
    /// Σ (r/σ)².
    squares: f64,
    /// Σ J r/σ for one tolerance of each nuisance parameter.
    gradient: [f64; NUISANCES],
}

/// One log, prepared for the comparison with simulated velocities.
#[derive(Clone)]
pub(crate) struct LogCost<'a> {
    log: &'a Log,
    /// Velocity that the nominal actuator would execute, on axes that move.
    undisturbed: [Vec<f64>; 6],
    /// Noise of each axis as the log itself shows it, at least [`LEAST`] and at most 3 times the data sheet's.
    pub sigma: [f64; 6],
    /// Noise of each axis by data sheet.
    pub sheet_sigma: [f64; 6],
    /// Change of the velocity for one tolerance of each nuisance parameter, in σ.
    jacobian: [[Vec<f64>; NUISANCES]; 6],
    intervals_s: Vec<f64>,
    /// Number of first cycles that do not count, as the commands before them are not known.
    settling: usize,
}

/// All logs, prepared for comparison with one actuator.
#[derive(Clone)]
pub(crate) struct Cost<'a> {
    /// The logs.
    pub logs: Vec<LogCost<'a>>,
    nominal: [Chain; 6],
    /// The nominal actuator without the effects of the model.
    bare: [Chain; 6],
    tolerance: ToleranceModel,
    /// Axes that move.
    pub active: [bool; 6],
    /// Products of the columns of the nuisance parameters, by axis.
    normal: [[[f64; NUISANCES]; NUISANCES]; 6],
    known: Known,
}

/// Costs of each axis for chains that were simulated before. Most terms act on some axes only, and a search comes back to the
/// best ones, so that this saves most of the simulations.
#[derive(Default)]
struct Known([Mutex<HashMap<[u64; 21], AxisCost>>; 6]);

impl Known {
    fn get_or(&self, axis: usize, chain: &Chain, cost: impl FnOnce() -> AxisCost) -> AxisCost {
        let known = || self.0[axis].lock().unwrap_or_else(PoisonError::into_inner);
        let key = chain.bits();
        if let Some(cost) = known().get(&key).copied() {
            return cost;
        }
        let cost = cost();
        known().insert(key, cost);
        cost
    }
}

impl Clone for Known {
    /// Nothing is known: a copy is made to be changed.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<'a> LogCost<'a> {
    fn new(log: &'a Log, intervals_s: Vec<f64>, nominal: &[Chain; 6], active: &[bool; 6]) -> Self {
        let mut cost = Self {
            log,
            undisturbed: Default::default(),
            sigma: log.velocity_sigma,
            sheet_sigma: log.velocity_sigma,
            jacobian: std::array::from_fn(|_| Default::default()),
            intervals_s,
            settling: 0,
        };
        cost.settling = cost.settling(&nominal[0], active);
        for axis in (0..6).filter(|axis| active[*axis]) {
            let predicted = cost.simulate(&nominal[axis], axis);
            cost.sigma[axis] = cost.noise(&predicted, axis);
            cost.undisturbed[axis] = predicted;
        }
        cost
    }

    /// Noise of an axis, estimated from what a prediction leaves: between [`LEAST`] and 3 times the data sheet's.
    fn noise(&self, predicted: &[f64], axis: usize) -> f64 {
        let residual = self.residual(predicted, axis);
        let noise = match self.log.reading {
            Reading::Mean => Noise::Differenced,
            Reading::AtEnd => Noise::White,
        };
        let sheet = self.sheet_sigma[axis];
        let known = residual.get(self.known_cycles()).unwrap_or_default();
        let filter = self.log.filter.map(|f| f.on_samples(self.log.cycle_s));
        let floor = noise_floor(known, noise, filter);
        floor.map_or(sheet, |f| f.clamp(LEAST * sheet, 3.0 * sheet))
    }

    /// Change of the velocity by one tolerance of delay or lag, in σ; all 0 where the nominal value is exact.
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
        let known = self.known_cycles();
        change
            .enumerate()
            .map(|(n, c)| if known.contains(&n) { c } else { 0.0 })
            .collect()
    }

    /// Executed velocity of an axis, simulated with a chain of stages.
    pub(crate) fn simulate(&self, chain: &Chain, axis: usize) -> Vec<f64> {
        let timing = Timing {
            cycle_s: self.log.cycle_s,
            intervals_s: &self.intervals_s,
        };
        let mut velocity = simulate(chain, &self.log.sent[axis], &timing, self.log.reading);
        timing.as_recorded(&mut velocity, self.log.reading);
        self.log.as_imported(velocity)
    }

    /// Measured minus predicted velocity; 0 in cycles that do not count.
    pub(crate) fn residual(&self, predicted: &[f64], axis: usize) -> Vec<f64> {
        let executed = self.log.executed[axis].iter();
        let mut residual: Vec<f64> = executed.zip(predicted).map(|(e, p)| e - p).collect();
        // The commands before the first cycles are not known, nor the motion after the last ones, which a filter mixes in.
        let known = self.known_cycles();
        residual[..known.start].fill(0.0);
        residual[known.end..].fill(0.0);
        residual
    }

    /// Cycles that count: the commands before them are known and, behind a filter, the motion after them.
    pub(crate) fn known_cycles(&self) -> Range<usize> {
        let count = self.log.cycle_count();
        let end = count.saturating_sub(self.bent());
        self.settling.min(end)..end
    }

    /// Number of cycles at an end of the log into which a filter mixes what is beyond.
    fn bent(&self) -> usize {
        let filter = self.log.filter;
        let count = self.log.cycle_count();
        filter.map_or(0, |filter| filter.settling(self.log.cycle_s, count))
    }

    fn settling(&self, nominal: &Chain, active: &[bool; 6]) -> usize {
        /// Longest past, s, that a hypothesis may need beyond the nominal actuator, for a drive as fast as a docking rig's.
        const PAST_S: f64 = 0.25;
        let cycle_s = self.log.cycle_s;
        let past_s = nominal.delay_s + 5.0 * nominal.lag_s + PAST_S * slower(cycle_s);
        // A log that starts at rest needs no past: nothing is commanded and nothing moves, or nothing moves yet.
        let first = |series: &Vec<f64>| series.first().map_or(0.0, |first| first.abs());
        let unsent = self.log.sent.iter().all(|series| first(series) < 1e-9);
        if (unsent && self.stands_still(0, active))
            || self.stands_still((nominal.delay_s / cycle_s) as usize, active)
        {
            0
        } else {
            // At least half of a short log counts all the same.
            let unknown = (past_s / cycle_s) as usize + 1 + self.bent();
            unknown.min(self.log.cycle_count() / 2)
        }
    }

    /// Whether no axis moves in the first `more` + 2 cycles. The second one is needed as a difference of poses shows the motion
    /// of the first cycle there.
    fn stands_still(&self, more: usize, active: &[bool; 6]) -> bool {
        /// Multiples of the noise that are taken for no motion.
        const STILL: f64 = 4.0;
        (0..6).filter(|axis| active[*axis]).all(|axis| {
            let first = self.log.executed[axis].iter().take(more + 2);
            first.fold(0.0_f64, |m, v| m.max(v.abs())) < STILL * self.sheet_sigma[axis]
        })
    }

    fn add_cost(&self, chain: &Chain, axis: usize, cost: &mut AxisCost) {
        let predicted = self.simulate(chain, axis);
        let residual = self.residual(&predicted, axis);
        let scale = 1.0 / self.sigma[axis];
        cost.squares += scale * scale * dot(&residual, &residual);
        for (gradient, column) in cost.gradient.iter_mut().zip(&self.jacobian[axis]) {
            *gradient += scale * dot(&residual, column);
        }
    }

    /// Number of its cycles.
    pub(crate) fn cycle_count(&self) -> usize {
        self.log.cycle_count()
    }

    /// Duration of a cycle, s.
    pub(crate) fn cycle_s(&self) -> f64 {
        self.log.cycle_s
    }

    /// Whether the velocity was measured, not taken from two poses.
    pub(crate) fn is_sampled(&self) -> bool {
        self.log.reading == Reading::AtEnd
    }
}

impl<'a> Cost<'a> {
    /// Prepares logs with the true durations of their cycles, s; empty where these are nominal.
    pub(crate) fn new(model: &Model, logs: &'a [Log], intervals_s: &[Vec<f64>]) -> Self {
        let mut active = [false; 6];
        for axis in &model.rig.active_axes {
            let moves = |log: &Log| log.sent[axis.index()].iter().any(|v| *v != 0.0);
            active[axis.index()] = logs.iter().any(moves);
        }
        // Poses that are taken late show a velocity late.
        let late_s = match logs.first().map(|log| log.reading) {
            Some(Reading::Mean) => model.clock_offset_s(),
            _ => 0.0,
        };
        let bare = Model {
            effects: Vec::new(),
            ..model.clone()
        };
        let [nominal, bare] = [model, &bare]
            .map(|model| std::array::from_fn(|axis| later(model.chain(axis), late_s)));
        let both = logs.iter().zip(intervals_s);
        let mut cost = Self {
            logs: both
                .map(|(log, intervals_s)| LogCost::new(log, intervals_s.clone(), &nominal, &active))
                .collect(),
            nominal,
            bare,
            tolerance: model.tolerance.clone(),
            active,
            normal: Default::default(),
            known: Known::default(),
        };
        cost.linearise(&[]);
        cost
    }

    /// The cost of some of the logs alone.
    pub(crate) fn of_logs(&self, keeps: impl Fn(usize) -> bool) -> Self {
        let mut some = self.clone();
        let mut number = 0;
        some.logs.retain(|_| {
            number += 1;
            keeps(number - 1)
        });
        some.sum_products();
        some
    }

    /// Lowers the noise to what hypotheses leave, where that is clearly less than before: an error of the model that is as rough
    /// as the motion looks like noise. Returns whether any was lowered.
    pub(crate) fn quieten<'t>(&mut self, hypotheses: impl Iterator<Item = &'t [Term]>) -> bool {
        /// Ratio to the noise before, below which it is clearly less.
        const LESS: f64 = 0.9;
        let mut quieter: Vec<[f64; 6]> = self.logs.iter().map(|log| log.sigma).collect();
        for terms in hypotheses {
            for axis in (0..6).filter(|axis| self.active[*axis]) {
                let chain = self.chain(terms, axis);
                for (log, quieter) in self.logs.iter().zip(&mut quieter) {
                    let noise = log.noise(&log.simulate(&chain, axis), axis);
                    quieter[axis] = quieter[axis].min(noise);
                }
            }
        }
        let mut any = false;
        for (log, quieter) in self.logs.iter_mut().zip(quieter) {
            if (0..6).any(|axis| quieter[axis] < LESS * log.sigma[axis]) {
                log.sigma = quieter;
                any = true;
            }
        }
        if any {
            self.linearise(&[]);
        }
        any
    }

    /// The same logs with the nuisance parameters linearised around terms and not around the nominal actuator: an error of the
    /// nominal delay shifts the motion that the terms have made.
    pub(crate) fn around(&self, terms: &[Term]) -> Self {
        let mut around = self.clone();
        around.linearise(terms);
        around
    }

    /// Holds nuisance parameters at their nominal values if terms would need them to be too far off: that is a finding of its
    /// own. Returns whether there are any.
    pub(crate) fn hold_strained(&mut self, terms: &[Term]) -> bool {
        let axes = std::array::from_fn(|axis| self.of_axis(&self.chain(terms, axis), axis));
        let taken = self.total_and_nuisances(&axes).1;
        let strained = strained(taken.as_slice(), 2.0);
        let delay = strained.contains(&LONGER) || strained.contains(&SHORTER);
        let lag = strained.contains(&(NUISANCES - 1));
        if delay {
            self.tolerance.transport_delay_s = 0.0;
        }
        if lag {
            self.tolerance.lag_s = 0.0;
        }
        if delay || lag {
            self.linearise(&[]);
        }
        delay || lag
    }

    fn linearise(&mut self, terms: &[Term]) {
        let (delay, lag) = (self.tolerance.transport_delay_s, self.tolerance.lag_s);
        let active = self.active;
        for axis in (0..6).filter(|axis| active[*axis]) {
            let chain = self.chain(terms, axis);
            for log in &mut self.logs {
                let predicted = log.simulate(&chain, axis);
                let changes = [(delay, 0.0), (-delay, 0.0), (0.0, lag)];
                log.jacobian[axis] =
                    changes.map(|change| log.sensitivity(axis, &chain, change, &predicted));
            }
        }
        self.sum_products();
    }

    fn sum_products(&mut self) {
        self.known = Known::default();
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        self.normal = std::array::from_fn(|axis| {
            std::array::from_fn(|i| {
                std::array::from_fn(|k| {
                    let columns = self.logs.iter().map(|log| &log.jacobian[axis]);
                    columns.map(|c| dot(&c[i], &c[k])).sum()
                })
            })
        });
    }

    /// The nominal chain of an axis with terms applied.
    pub(crate) fn chain(&self, terms: &[Term], axis: usize) -> Chain {
        let mut chain = self.nominal[axis];
        for term in terms.iter().filter(|t| t.axes[axis]) {
            term.stage.apply(&mut chain, &term.values);
        }
        chain
    }

    /// Fall of χ² by the effects that the model has already.
    pub(crate) fn explained(&self) -> f64 {
        let of = |chains: &[Chain; 6]| -> f64 {
            let each = (0..6).map(|axis| self.of_axis(&chains[axis], axis).squares);
            each.sum()
        };
        (of(&self.bare) - of(&self.nominal)).max(0.0)
    }

    /// Cost of one axis.
    pub(crate) fn of_axis(&self, chain: &Chain, axis: usize) -> AxisCost {
        if !self.active[axis] {
            return AxisCost::default();
        }
        self.known.get_or(axis, chain, || {
            let mut cost = AxisCost::default();
            for log in &self.logs {
                log.add_cost(chain, axis, &mut cost);
            }
            cost
        })
    }

    /// Costs of some axes with these terms; those of the others are 0.
    pub(crate) fn of_axes(&self, terms: &[Term], axes: &[bool; 6]) -> [AxisCost; 6] {
        std::array::from_fn(|axis| {
            if axes[axis] {
                self.of_axis(&self.chain(terms, axis), axis)
            } else {
                AxisCost::default()
            }
        })
    }

    /// χ² of all axes, the nuisance parameters at their best and their priors included.
    pub(crate) fn total(&self, axes: &[AxisCost; 6]) -> f64 {
        self.total_and_nuisances(axes).0
    }

    /// That χ², and the values of the nuisance parameters in tolerances.
    fn total_and_nuisances(&self, axes: &[AxisCost; 6]) -> (f64, SVector<f64, NUISANCES>) {
        let mut squares = 0.0;
        let mut gradient = SVector::<f64, NUISANCES>::zeros();
        // The prior of each nuisance parameter has unit variance, in units of its tolerance.
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
        // A delay is either longer or shorter than stated. With both free, its tolerance would count twice.
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

    /// Whitened residuals of each log and axis with these terms, the nuisance parameters at their best.
    pub(crate) fn whitened_residuals(&self, terms: &[Term]) -> Vec<[Vec<f64>; 6]> {
        let costs = std::array::from_fn(|axis| self.of_axis(&self.chain(terms, axis), axis));
        let taken = self.total_and_nuisances(&costs).1;
        let of = |log: &LogCost<'_>, axis: usize| {
            let predicted = log.simulate(&self.chain(terms, axis), axis);
            let mut white = log.residual(&predicted, axis);
            white.iter_mut().for_each(|r| *r /= log.sigma[axis]);
            for (column, taken) in log.jacobian[axis].iter().zip(&taken) {
                white
                    .iter_mut()
                    .zip(column)
                    .for_each(|(w, c)| *w -= taken * c);
            }
            white
        };
        let of_log = |log: &LogCost<'a>| -> [Vec<f64>; 6] {
            std::array::from_fn(|axis| match self.active[axis] {
                true => of(log, axis),
                false => Vec::new(),
            })
        };
        self.logs.iter().map(of_log).collect()
    }

    /// χ² of each log with these terms, the nuisance parameters at their best.
    pub(crate) fn of_each(&self, terms: &[Term]) -> Vec<f64> {
        let squares = |white: &[Vec<f64>; 6]| white.iter().flatten().map(|w| w * w).sum();
        self.whitened_residuals(terms).iter().map(squares).collect()
    }

    /// χ² of the nominal actuator with an additional delay, s.
    pub(crate) fn of_later(&self, late_s: f64) -> f64 {
        let axes =
            std::array::from_fn(|axis| self.of_axis(&later(self.nominal[axis], late_s), axis));
        self.total(&axes)
    }

    /// Whether the velocity was measured, not taken from two poses.
    pub(crate) fn is_sampled(&self) -> bool {
        self.logs.first().is_some_and(LogCost::is_sampled)
    }

    /// Delay of the nominal actuator, s.
    pub(crate) fn delay_s(&self) -> f64 {
        self.nominal[0].delay_s
    }

    /// χ² with these terms and the nuisance parameters at their nominal values.
    pub(crate) fn exactly(&self, terms: &[Term]) -> f64 {
        (0..6)
            .map(|axis| self.of_axis(&self.chain(terms, axis), axis).squares)
            .sum()
    }

    /// χ² with these terms, the nuisance parameters at their best.
    pub(crate) fn of(&self, terms: &[Term]) -> f64 {
        let axes = std::array::from_fn(|axis| self.of_axis(&self.chain(terms, axis), axis));
        self.total(&axes)
    }

    /// Duration of a cycle, s.
    pub(crate) fn cycle_s(&self) -> f64 {
        self.logs.first().map_or(0.0, LogCost::cycle_s)
    }

    /// Number of velocities that count.
    pub(crate) fn count(&self) -> usize {
        self.count_of(&self.active)
    }

    /// Number of velocities that count on some axes.
    pub(crate) fn count_of(&self, axes: &[bool; 6]) -> usize {
        let cycles: usize = self.logs.iter().map(|log| log.known_cycles().len()).sum();
        axes.iter().filter(|a| **a).count() * cycles
    }

    /// Size of the motion of some axes, which sets the range of parameters.
    pub(crate) fn scale(&self, axes: &[bool; 6]) -> Scale {
        let series = self.logs.iter().flat_map(|log| {
            let moving = (0..6).filter(|a| axes[*a] && self.active[*a]);
            moving.map(|axis| (&log.log.sent[axis][..], &log.undisturbed[axis][..]))
        });
        let rotates = (3..6).any(|axis| axes[axis]);
        Scale::of(series, self.cycle_s(), rotates)
    }

    /// Number of different values that were sent on an axis.
    pub(super) fn commands(&self, axis: usize) -> usize {
        let values: BTreeSet<u64> = self.sent(axis).map(f64::to_bits).collect();
        values.len()
    }

    /// Number of different sizes among them, 0 not counted.
    pub(super) fn sizes_of_commands(&self, axis: usize) -> usize {
        let sizes = self.sent(axis).map(f64::abs).filter(|size| *size > 0.0);
        let sizes: BTreeSet<u64> = sizes.map(f64::to_bits).collect();
        sizes.len()
    }

    /// Whether an axis was commanded in both directions.
    pub(super) fn is_sent_both_ways(&self, axis: usize) -> bool {
        self.sent(axis).any(|v| v > 0.0) && self.sent(axis).any(|v| v < 0.0)
    }

    fn sent(&self, axis: usize) -> impl Iterator<Item = f64> + '_ {
        self.logs
            .iter()
            .flat_map(move |log| log.log.sent[axis].iter().copied())
    }
}

fn later(mut chain: Chain, late_s: f64) -> Chain {
    chain.delay_s = (chain.delay_s + late_s).max(0.0);
    chain
}
