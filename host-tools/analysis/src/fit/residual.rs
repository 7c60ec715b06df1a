//! Residuals of all channels as one list of numbers, each in units of its expected noise.

use super::sandwich;
use softdock_physics::model::prediction::signals::Signals;
use softdock_physics::model::prediction::{
    ChannelPrediction, Prediction, Six, bodies, executed, intervals, pose, predict_signals, wrench,
};
use softdock_physics::model::{Axis, Channel, Model};
use std::borrow::Cow;

/// Most residuals that a fit works with. Of a longer recording every second, third ... cycle is
/// judged; the intervals are as much wider.
const MOST: usize = 300_000;

/// One residual.
struct Row {
    log: usize,
    channel: Channel,
    axis: Axis,
    cycle: usize,
    sigma: f64,
}

/// What a fit makes small.
pub(super) struct Residuals<'a> {
    /// As it was given: the rig's own controller works with its tool and sensor.
    given: &'a Model,
    signals: &'a [Signals<'a>],
    /// Durations of the cycles of each recording, by the model as it was given; empty if nominal.
    intervals_s: Vec<Vec<f64>>,
    rows: Vec<Row>,
    /// Poses as the model as it was given predicts them: those of each model with the same clock.
    poses: Vec<ChannelPrediction>,
    /// The model velocity is predicted with the model's own tool and sensor, because the recording
    /// does not say with which ones the rig's controller computed it.
    pub(super) believed: bool,
    /// By how much each channel and axis is worse than its noise, whatever is fitted; 1 or more.
    excess: [Six; 4],
}

impl<'a> Residuals<'a> {
    /// Everything that the model predicts of the signals.
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
        let predicted = |p: &Prediction| {
            let velocities = &p.channel(Channel::ModelVelocity).predicted;
            velocities.iter().any(Option::is_some)
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
            believed: foreign && predictions.iter().any(predicted),
            excess: [[1.0; 6]; 4],
        }
    }

    /// Number of residuals.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// The residuals of a model; 0 where it predicts nothing.
    pub(super) fn of(&self, model: &Model) -> Vec<f64> {
        self.relative(model)
            .zip(&self.rows)
            .map(|(residual, row)| residual / self.excess[row.channel as usize][row.axis.index()])
            .collect()
    }

    /// The part of the logs in which each residual lies.
    pub(super) fn parts(&self) -> Vec<usize> {
        let cycles = self.signals.iter().map(|s| s.cycles.len());
        let rows = self.rows.iter().map(|row| (row.log, row.cycle));
        sandwich::parts(&cycles.collect::<Vec<_>>(), rows)
    }

    /// Gives each channel and axis the weight that its residuals with this model deserve: an error
    /// that no parameter takes away must not make the parameters look certain.
    pub(super) fn weigh(&mut self, model: &Model) {
        let mut sums = [[(0.0, 0_usize); 6]; 4];
        for (residual, row) in self.relative(model).zip(&self.rows) {
            let (sum, count) = &mut sums[row.channel as usize][row.axis.index()];
            *sum += residual * residual;
            *count += 1;
        }
        self.excess =
            sums.map(|axes| axes.map(|(sum, count)| (sum / count.max(1) as f64).sqrt().max(1.0)));
    }

    /// Residuals over noise.
    fn relative(&self, model: &Model) -> impl Iterator<Item = f64> + '_ {
        let logs: Vec<[Cow<'_, ChannelPrediction>; 4]> = (0..self.signals.len())
            .map(|log| self.channels(model, log))
            .collect();
        self.rows.iter().map(move |row| {
            let residual = logs[row.log][row.channel as usize].residual(row.cycle, row.axis);
            residual.unwrap_or(0.0) / row.sigma
        })
    }

    fn channels(&self, model: &Model, log: usize) -> [Cow<'_, ChannelPrediction>; 4] {
        let (signals, intervals_s) = (&self.signals[log], self.intervals_s[log].as_slice());
        // The model velocity shows what the controller believes of tool and sensor, not what is.
        let believed = Model {
            tool: self.given.tool.clone(),
            sensor: self.given.sensor.clone(),
            ..model.clone()
        };
        let executed = executed::predict(model, signals, intervals_s);
        let wrench = wrench::predict(model, signals, intervals_s, &executed);
        let clock = |model: &Model| (model.clock_offset_s(), model.clock_rate_error());
        let pose = match clock(model) == clock(self.given) {
            true => Cow::Borrowed(&self.poses[log]),
            false => Cow::Owned(pose::predict(model, signals, intervals_s)),
        };
        [
            Cow::Owned(executed),
            Cow::Owned(wrench),
            Cow::Owned(bodies::predict(&believed, signals, &mut Vec::new())),
            pose,
        ]
    }
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
