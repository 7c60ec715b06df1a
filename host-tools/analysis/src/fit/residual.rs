//! Residuals of all channels as one list of numbers, each in units of its expected noise.

use super::parameter_id::ParameterId;
use super::sandwich;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::load::loaded::LoadOfEach;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::prediction::wrench::Nominal;
use softdock_physics::model::prediction::{
    ChannelPrediction, Prediction, Six, bodies, executed, intervals, pose, predict_signals,
    residual,
};
use softdock_physics::model::{Axis, Channel, Model};
use std::sync::{Arc, Mutex, PoisonError};

/// Largest number of residuals in a fit. Of longer recordings every second, third ... cycle is used; the intervals widen
/// accordingly.
const MOST: usize = 300_000;

/// One residual.
struct Row {
    log: usize,
    channel: Channel,
    axis: Axis,
    cycle: usize,
    sigma: f64,
}

/// The residual vector of a fit, as a function of the model.
pub(super) struct Residuals<'a> {
    /// The model before the fit: its tool and sensor are those that the rig's controller works with.
    given: &'a Model,
    signals: &'a [Signals<'a>],
    /// Durations of the cycles of each recording, by the model as it was given; empty if nominal.
    intervals_s: Vec<Vec<f64>>,
    rows: Vec<Row>,
    /// Poses as the given model predicts them. They hold for every model with the same clock.
    poses: Vec<ChannelPrediction>,
    /// The model velocity is predicted with tool and sensor of the given model, because the recording does not say with which
    /// ones the rig's controller computed it.
    pub(super) believed: bool,
    /// A velocity was sent, or may have been.
    moves: bool,
    /// See [`Self::keep`].
    cache: Mutex<Option<ModelCache>>,
    /// Ratio of rms residual to expected noise that is left on each channel and axis; at least 1. Residuals are divided by it.
    excess: [Six; 4],
}

impl<'a> Residuals<'a> {
    /// Residuals of everything that the model predicts of the signals.
    pub(super) fn new(given: &'a Model, signals: &'a [Signals<'a>]) -> Self {
        let predictions: Vec<Prediction> =
            signals.iter().map(|s| predict_signals(given, s)).collect();
        let rows = |every: usize| -> Vec<Row> {
            let each = predictions.iter().enumerate();
            each.flat_map(|(log, prediction)| all_rows(log, prediction, every))
                .collect()
        };
        let mut all = rows(1);
        if all.len() > MOST {
            all = rows(all.len().div_ceil(MOST));
        }
        let predicts = |channel: Channel| {
            let each = predictions.iter().map(|p| &p.channel(channel).predicted);
            each.flatten().any(Option::is_some)
        };
        let foreign = signals.iter().all(|s| s.settings.is_none());
        Self {
            given,
            signals,
            intervals_s: signals.iter().map(|s| intervals(given, s)).collect(),
            rows: all,
            poses: predictions
                .iter()
                .map(|p| p.channel(Channel::Pose).clone())
                .collect(),
            believed: foreign && predicts(Channel::ModelVelocity),
            moves: predicts(Channel::ExecutedVelocity) || signals.iter().any(Signals::is_of_a_rig),
            cache: Mutex::default(),
            excess: [[1.0; 6]; 4],
        }
    }

    /// Number of residuals.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Residuals of a model, weighted. Where it predicts nothing the residual is 0, and those of the same log and channel are
    /// scaled up in its place.
    pub(super) fn of(&self, model: &Model) -> Vec<f64> {
        self.weighted(&self.relative(model))
    }

    /// Divides values in units of noise by the excess that [`Self::weigh`] has found.
    pub(super) fn weighted(&self, relative: &[f64]) -> Vec<f64> {
        let all = relative.iter().zip(&self.rows);
        all.map(|(value, row)| value / self.excess[row.channel as usize][row.axis.index()])
            .collect()
    }

    /// Part of the logs to which each residual belongs, for the sandwich covariance.
    pub(super) fn parts(&self) -> Vec<usize> {
        let cycles = self.signals.iter().map(|s| s.cycles.len());
        let rows = self.rows.iter().map(|row| (row.log, row.cycle));
        sandwich::parts(&cycles.collect::<Vec<_>>(), rows)
    }

    /// Sets the weight of each channel and axis by the rms of its residuals with this model: an error that no parameter removes
    /// must not make the parameters look certain.
    pub(super) fn weigh(&mut self, model: &Model) {
        let mut sums = [[(0.0, 0_usize); 6]; 4];
        for (residual, row) in self.relative(model).iter().zip(&self.rows) {
            let (sum, count) = &mut sums[row.channel as usize][row.axis.index()];
            *sum += residual * residual;
            *count += 1;
        }
        self.excess =
            sums.map(|axes| axes.map(|(sum, count)| (sum / count.max(1) as f64).sqrt().max(1.0)));
    }

    /// Caches the residuals of a model, and the predictions it shares with all models that differ only in effects on the reading.
    /// Most models that a fit tries next are of that kind, and only their wrench is predicted anew.
    pub(super) fn keep(&self, model: &Model) {
        let before = self.cached();
        if before.as_ref().is_some_and(|cache| cache.model == *model) {
            return;
        }
        let common = self.common(model);
        let before = before.filter(|cache| cache.common == common);
        let mut cache = self.cache_of(model, common, before.as_ref());
        cache.relative = self.relative_residuals(model, &cache).into();
        *self.cache.lock().unwrap_or_else(PoisonError::into_inner) = Some(cache);
    }

    /// Cached derivatives of the residuals of the kept model, in units of noise, by parameter; empty if there are none.
    pub(super) fn slopes(&self) -> Vec<(ParameterId, Arc<[f64]>)> {
        self.cached().map_or_else(Vec::new, |cache| cache.slopes)
    }

    /// Caches derivatives for the kept model, until another model is kept.
    pub(super) fn keep_slopes(&self, slopes: Vec<(ParameterId, Arc<[f64]>)>) {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(cache) = cache.as_mut() {
            cache.slopes = slopes;
        }
    }

    fn cached(&self) -> Option<ModelCache> {
        let cache = self.cache.lock();
        cache.unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn cache_of(&self, model: &Model, common: Model, before: Option<&ModelCache>) -> ModelCache {
        let (logs, loads) = match before {
            Some(before) => (before.logs.clone(), before.loads.clone()),
            None => (self.unaffected(model), Arc::default()),
        };
        let none = LoadOfEach::default();
        let load = |(log, n): (&Unaffected, usize)| {
            let before = loads.get(n).unwrap_or(&none);
            log.wrench.load_of_each(model, before)
        };
        let loads = logs.iter().zip(0..).map(load).collect();
        ModelCache {
            model: model.clone(),
            common,
            logs,
            loads,
            relative: Arc::default(),
            slopes: Vec::new(),
        }
    }

    /// Residuals over noise.
    pub(super) fn relative(&self, model: &Model) -> Arc<[f64]> {
        let cache = self.cached();
        if let Some(same) = cache.as_ref().filter(|cache| cache.model == *model) {
            return same.relative.clone();
        }
        let common = self.common(model);
        let cache = cache.filter(|cache| cache.common == common);
        let cache = cache.unwrap_or_else(|| self.cache_of(model, common, None));
        self.relative_residuals(model, &cache).into()
    }

    /// Computes these for a model that shares the predictions of `cache`.
    fn relative_residuals(&self, model: &Model, cache: &ModelCache) -> Vec<f64> {
        let logs = &cache.logs;
        let each = logs.iter().zip(self.signals).zip(&*cache.loads);
        let wrenches: Vec<Vec<Option<Six>>> = each
            .map(|((log, signals), loads)| log.wrench.with_effects(model, signals, loads))
            .collect();
        let missed_by = |row: &Row| {
            let log = &logs[row.log];
            let channel = match row.channel {
                Channel::Wrench => {
                    let measured = &self.signals[row.log].cycles[row.cycle].inputs.sensor.wrench;
                    let read = wrenches[row.log][row.cycle]?;
                    return residual(measured, &read, row.axis);
                }
                Channel::ExecutedVelocity => &log.executed,
                Channel::ModelVelocity => &log.model_velocity,
                Channel::Pose => log.pose.as_ref().unwrap_or(&self.poses[row.log]),
            };
            channel.residual(row.cycle, row.axis)
        };
        let of_row = |row: &Row| missed_by(row).map(|missed| missed / row.sigma);
        in_place_of_lost(&self.rows, self.rows.iter().map(of_row).collect())
    }

    /// The model without its effects on the reading alone and with a zero of 0: equal for all models that share predictions. In
    /// logs in which no velocity is sent, a delay of a drive or a clock is such an effect, too.
    fn common(&self, model: &Model) -> Model {
        let mut common = model.clone();
        common.sensor.bias = [0.0; 6];
        common.effects.retain(|effect| {
            let load = LoadEffect::find(model, &effect.id);
            load.is_none_or(|load| self.moves && !load.is_of_the_reading_alone())
        });
        common
    }

    /// Predictions that all models with the same [`Self::common`] share, one per log.
    fn unaffected(&self, model: &Model) -> Arc<[Unaffected]> {
        // The model velocity depends on the tool and sensor that the controller assumes, not on the true ones.
        let believed = Model {
            tool: self.given.tool.clone(),
            sensor: self.given.sensor.clone(),
            ..model.clone()
        };
        let clock = |model: &Model| (model.clock_offset_s(), model.clock_rate_error());
        let moved = clock(model) != clock(self.given);
        let of = |(signals, intervals_s): (&Signals<'_>, &Vec<f64>)| {
            let executed = executed::predict(model, signals, intervals_s);
            Unaffected {
                wrench: Nominal::new(model, signals, intervals_s, &executed),
                executed,
                model_velocity: bodies::predict(&believed, signals, &mut Vec::new()),
                pose: moved.then(|| pose::predict(model, signals, intervals_s)),
            }
        };
        self.signals.iter().zip(&self.intervals_s).map(of).collect()
    }
}

/// Cached residuals of a model, and the predictions it shares with others.
#[derive(Clone)]
struct ModelCache {
    model: Model,
    /// The model without its effects on the reading alone.
    common: Model,
    logs: Arc<[Unaffected]>,
    /// Loads on the sensor by each of the model's effects, per log.
    loads: Arc<[LoadOfEach]>,
    /// Its residuals in units of noise.
    relative: Arc<[f64]>,
    /// Derivatives of these by some parameters.
    slopes: Vec<(ParameterId, Arc<[f64]>)>,
}

/// Predictions of one log that no effect on the reading alone changes.
struct Unaffected {
    wrench: Nominal,
    executed: ChannelPrediction,
    model_velocity: ChannelPrediction,
    /// None where it is that of the model as it was given.
    pose: Option<ChannelPrediction>,
}

/// Replaces residuals without a prediction by 0, and scales those of the same log and channel so that their sum of squares stands
/// for all. Otherwise a delay of a drive would gain by every row that it leaves unpredicted. Delays are bounded so that some rows
/// are left.
fn in_place_of_lost(rows: &[Row], relative: Vec<Option<f64>>) -> Vec<f64> {
    let same = |a: &(&Row, &Option<f64>), b: &(&Row, &Option<f64>)| {
        (a.0.log, a.0.channel) == (b.0.log, b.0.channel)
    };
    let all: Vec<(&Row, &Option<f64>)> = rows.iter().zip(&relative).collect();
    let each = all.chunk_by(same).flat_map(|part| {
        let known = part.iter().filter(|(_, missed)| missed.is_some()).count();
        let weight = (part.len() as f64 / known.max(1) as f64).sqrt();
        part.iter()
            .map(move |(_, missed)| weight * missed.unwrap_or(0.0))
    });
    each.collect()
}

fn all_rows(log: usize, prediction: &Prediction, every: usize) -> Vec<Row> {
    let mut rows = Vec::new();
    for channel in Channel::ALL {
        let series = prediction.channel(channel);
        for axis in prediction.judged(channel).iter().copied() {
            for cycle in (0..prediction.time_s.len()).step_by(every) {
                let sigma = series.expected_sigma(cycle, axis);
                if series.residual(cycle, axis).is_some() && sigma > 0.0 {
                    rows.push(Row {
                        log,
                        channel,
                        axis,
                        cycle,
                        sigma,
                    });
                }
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each log and channel is scaled by itself; one without any prediction has no error.
    #[test]
    fn lost_rows_count_as_those_that_are_left() {
        let row = |log, channel| Row {
            log,
            channel,
            axis: Axis::Rx,
            cycle: 0,
            sigma: 1.0,
        };
        let rows: Vec<Row> = [
            (0, Channel::Wrench),
            (0, Channel::Pose),
            (1, Channel::Wrench),
        ]
        .into_iter()
        .flat_map(|(log, channel)| (0..4).map(move |_| row(log, channel)))
        .collect();
        let known = [
            [Some(3.0), None, None, None],
            [Some(1.0), Some(-1.0), Some(1.0), Some(1.0)],
            [None, None, None, None],
        ];
        let found = in_place_of_lost(&rows, known.into_iter().flatten().collect());
        let expected = [6.0, 0.0, 0.0, 0.0, 1.0, -1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(found, expected);
    }
}
