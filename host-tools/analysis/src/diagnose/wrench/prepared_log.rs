//! One log of a pair, prepared for the regression of its wrench.

use super::autoregressive::AutoregressiveNoise;
use super::nuisance;
use super::problem::Problem;
use super::saturated;
use super::stiction::without_stiction;
use super::tested::Tested;
use crate::diagnose::sampling::Sampling;
use crate::model::Model;
use crate::model::load::{Column, Scene};
use crate::model::log::Log;

/// χ² per value beyond the noise that is more than details of the form of an effect.
const MUCH: f64 = 0.05;

/// One log, ready for the regression.
pub(crate) struct PreparedLog {
    /// Its motion and nominal reading.
    pub scene: Scene,
    /// Its regression.
    pub problem: Problem,
    /// Measured minus nominal reading.
    pub residual: Column,
    /// Autoregressive noise model of each axis.
    pub noise_model: [AutoregressiveNoise; 6],
    /// Change of the reading for one tolerance of each parameter.
    pub tolerances: Vec<Column>,
    /// Noise by data sheet, with what the rounding of the readings adds.
    pub sheet_sigma: [f64; 6],
    /// Half of a step of the readings, where they are visibly rounded.
    pub half_step: [f64; 6],
}

impl PreparedLog {
    /// Prepares a log.
    pub(crate) fn new(model: &Model, log: &Log, scene: Scene, sampling: &mut Sampling) -> Self {
        let mut residual = Column::of(log.len(), |n| {
            std::array::from_fn(|axis| log.wrench[axis][n] - scene.reading.at(axis, n))
        });
        let mean = |series: &Vec<f64>| series.iter().sum::<f64>() / series.len().max(1) as f64;
        sampling.look_at_zero(&residual.0.each_ref().map(mean));
        for (axis, series) in residual.0.iter_mut().enumerate() {
            series
                .iter_mut()
                .for_each(|r| *r += sampling.centring(axis));
        }
        // Rounding to a step q is noise of q/√12.
        let mut sheet = sheet_sigma(model);
        for (axis, sigma) in sheet.iter_mut().enumerate() {
            *sigma = sigma.hypot(sampling.lsb[axis / 3] / 12.0_f64.sqrt());
        }
        let tolerances = nuisance::columns(model, &scene);
        let counts = without_stiction(&scene, &sampling.fresh);
        let unexplained = saturated::residual(&scene, &residual, &tolerances, &sheet, &counts);
        let cutoff_hz = model.sensor.filter.map(|filter| filter.cutoff_hz);
        let noise_model = std::array::from_fn(|axis| {
            let series = &unexplained.0[axis];
            if model.sensor.at_rest || series.is_empty() {
                return AutoregressiveNoise::white(sheet[axis]);
            }
            let mut noise_model = AutoregressiveNoise::of(series, log.cycle_s, 0.3, cutoff_hz);
            noise_model.sigma *= sheet[axis];
            noise_model.level *= sheet[axis];
            noise_model
        });
        let mut problem = Problem::new(&residual, &tolerances, noise_model, counts);
        // A low-pass leaves two values per period of its cutoff.
        let share = cutoff_hz.map_or(1.0, |cutoff_hz| (2.0 * cutoff_hz * log.cycle_s).min(1.0));
        problem.count = (share * problem.count as f64) as usize;
        Self {
            scene,
            problem,
            residual,
            noise_model,
            tolerances,
            sheet_sigma: sheet,
            half_step: std::array::from_fn(|axis| 0.5 * sampling.lsb[axis / 3]),
        }
    }

    /// The regression without one of so many pieces of the log.
    pub(super) fn without(&self, piece: usize, of: usize) -> Problem {
        let fresh = self.problem.fresh();
        let place = |n: usize| n * of / fresh.len().max(1);
        let kept = fresh.iter().enumerate();
        let kept = kept.map(|(n, fresh)| *fresh && place(n) != piece).collect();
        Problem::new(&self.residual, &self.tolerances, self.noise_model, kept)
    }

    /// χ² that a hypothesis leaves beyond the number of values.
    pub(crate) fn left(&self, tested: &Tested) -> f64 {
        self.problem.chi2 - tested.gain - self.problem.count as f64
    }

    /// Whether that is more than details of the form of an effect.
    pub(crate) fn has_much_left(&self, tested: &Tested) -> bool {
        self.left(tested) > MUCH * self.problem.count as f64
    }

    /// Fall of Σ (distance to the interval that a rounded reading stands for)², in σ²; an effect
    /// that only moves predictions inside of these intervals has no evidence. Without rounding the
    /// question does not arise.
    pub(super) fn gain_beyond_rounding(&self, contribution: &Column) -> f64 {
        if self.half_step.iter().all(|h| *h <= 0.0) {
            return f64::INFINITY;
        }
        let sheet = sheet_sigma(&self.scene.model);
        let mut gain = 0.0;
        for (axis, sheet) in sheet.into_iter().enumerate() {
            let half = self.half_step[axis];
            let outside = |r: f64| ((r.abs() - half).max(0.0) / sheet).powi(2);
            for (n, residual) in self.residual.0[axis].iter().enumerate() {
                gain += outside(*residual) - outside(residual - contribution.at(axis, n));
            }
        }
        gain
    }
}

/// Noise of the six readings by data sheet.
pub(crate) fn sheet_sigma(model: &Model) -> [f64; 6] {
    let (force, torque) = (model.noise.force_n, model.noise.torque_n_m);
    [force, force, force, torque, torque, torque]
}
