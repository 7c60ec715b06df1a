//! A log, prepared for the regression of its wrench.

use super::nuisance;
use super::problem::subtract;
use super::saturated;
use super::stiction::without_stiction;
use super::tested::TestedHypothesis;
use crate::diagnose::noise::autoregressive::{AutoregressiveNoise, LEAST, ORDER};
use crate::diagnose::wrench::sampling::Sampling;
use softdock_physics::model::Model;
use softdock_physics::model::load::{Column, Scene};
use softdock_physics::model::log::Log;

/// One log, ready for the regression.
pub(crate) struct PreparedLog {
    /// Its motion and nominal reading.
    pub scene: Scene,
    /// Measured minus nominal reading.
    pub residual: Column,
    /// Rows that count.
    pub fresh: Vec<bool>,
    /// Autoregressive noise model of each axis.
    pub noise_model: [AutoregressiveNoise; 6],
    /// Change of the reading for one tolerance of each nuisance parameter.
    pub tolerances: Vec<Column>,
    /// Noise by data sheet, N or N·m, including the rounding of the readings.
    pub sheet_sigma: [f64; 6],
    /// Half a step of the readings, N or N·m; 0 where they are not visibly rounded.
    pub half_step: [f64; 6],
    /// Its poses are the integral of its velocities: where a rig stands nobody has measured.
    pub has_own_origin: bool,
}

impl PreparedLog {
    /// Mean time between rows that count, s. It is longer than the sampling period where the sensor is slower than the log.
    pub(crate) fn counted_cycle_s(&self) -> f64 {
        let counted = self.fresh.iter().filter(|fresh| **fresh).count();
        self.scene.cycle_s * self.fresh.len() as f64 / counted.max(1) as f64
    }

    /// Computes residual, noise and tolerance columns of a log.
    pub(crate) fn new(model: &Model, log: &Log, scene: Scene, sampling: &mut Sampling) -> Self {
        let measured = log.measured();
        let mut residual = Column::of(log.cycle_count(), |n| {
            std::array::from_fn(|axis| match measured[axis] {
                true => log.wrench[axis][n] - scene.reading.at(axis, n),
                false => 0.0,
            })
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
        let tolerances: Vec<Column> = tolerances
            .into_iter()
            .map(|c| scene.on_measured_axes(c))
            .collect();
        let apart = model.sensor.at_rest || is_sparse(&sampling.fresh);
        let whole = match apart {
            true => sampling.fresh.clone(),
            false => after_gaps(&sampling.fresh),
        };
        let fresh = without_stiction(&scene, &whole);
        let unexplained = saturated::residual(&scene, &residual, &tolerances, &sheet, &fresh);
        let cutoff_hz = model.sensor.filter.map(|filter| filter.cutoff_hz);
        let noise_model = std::array::from_fn(|axis| {
            let series = &unexplained.0[axis];
            if model.sensor.at_rest || series.is_empty() {
                return AutoregressiveNoise::white(sheet[axis]);
            }
            // Rows that do not count are missing values, not values of 0.
            let counted = series.iter().zip(&fresh);
            let counted = counted.map(|(value, fresh)| if *fresh { *value } else { f64::NAN });
            let mut counted: Vec<f64> = counted.collect();
            if apart {
                counted.retain(|value| value.is_finite());
            }
            let cycle_s = log.cycle_s * series.len() as f64 / counted.len().max(1) as f64;
            let mut noise_model = AutoregressiveNoise::of(&counted, cycle_s, LEAST, cutoff_hz);
            if apart {
                noise_model = AutoregressiveNoise::white(noise_model.level);
            }
            noise_model.sigma *= sheet[axis];
            noise_model.level *= sheet[axis];
            noise_model
        });
        Self {
            scene,
            residual,
            fresh,
            noise_model,
            tolerances,
            sheet_sigma: sheet,
            half_step: std::array::from_fn(|axis| 0.5 * sampling.lsb[axis / 3]),
            has_own_origin: log.has_own_origin(),
        }
    }

    /// Sum of squares of what a hypothesis leaves of all axes, in units of the noise by data sheet, and the number of rows that count.
    pub(crate) fn chi2_left(&self, tested: &TestedHypothesis) -> (f64, usize) {
        let mut left = self.residual.clone();
        subtract(&mut left, &tested.contribution(&self.scene), 1.0);
        let of_axis = |(series, sheet): (&Vec<f64>, f64)| {
            let counted = series.iter().zip(&self.fresh).filter(|(_, fresh)| **fresh);
            counted.map(|(r, _)| (r / sheet).powi(2)).sum::<f64>()
        };
        let axes = left.0.iter().zip(self.sheet_sigma);
        let rows = self.fresh.iter().filter(|fresh| **fresh).count();
        (axes.map(of_axis).sum(), rows)
    }

    /// Fall of Σ (distance to the interval that a rounded reading stands for)², in σ². An effect that only moves predictions
    /// within these intervals has no evidence. Infinite without rounding.
    pub(crate) fn gain_beyond_rounding(&self, contribution: &Column) -> f64 {
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

/// Rows that count and whose whitened residual uses only rows that count: the filter reaches [`ORDER`] rows back.
fn after_gaps(fresh: &[bool]) -> Vec<bool> {
    let whole = |n: usize| {
        fresh[n.saturating_sub(ORDER)..=n]
            .iter()
            .all(|fresh| *fresh)
    };
    (0..fresh.len()).map(whole).collect()
}

/// Whether most rows that count follow one that does not, as where a sensor is slower than the log. Each row is then taken by
/// itself, with white noise.
fn is_sparse(fresh: &[bool]) -> bool {
    let count = |rows: &[bool]| rows.iter().filter(|fresh| **fresh).count();
    2 * count(&after_gaps(fresh)) < count(fresh)
}

/// Noise of the six readings by data sheet, N and N·m.
pub(crate) fn sheet_sigma(model: &Model) -> [f64; 6] {
    let (force, torque) = (model.noise.force_n, model.noise.torque_n_m);
    [force, force, force, torque, torque, torque]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a sensor at half the rate no row has the predecessors that whitening needs, so each counts by itself.
    #[test]
    fn readings_of_a_slow_sensor_are_taken_one_by_one() {
        let every = |kept: fn(usize) -> bool| -> Vec<bool> { (0..1000).map(kept).collect() };
        assert!(is_sparse(&every(|n| n % 2 == 0)));
        assert!(!is_sparse(&every(|n| n % 20 != 0)));
        assert!(!is_sparse(&every(|_| true)));
    }
}
