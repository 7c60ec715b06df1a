//! How large the error of a model is on recordings, and how it falls.

use crate::compare::ROUND_OFF_SIGMA;
use serde::Serialize;
use softdock_io::recording::Recording;
use softdock_physics::model::prediction::{ChannelPrediction, Prediction, predict};
use softdock_physics::model::{Axis, Channel, Model};
use softdock_statistics::digit_of;

/// Error per channel in units of the data sheet's noise, as docking-rig-log/1 sums it up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ChannelLevels {
    /// Channel A.
    pub executed_velocity: f64,
    /// Channel B.
    pub wrench: f64,
    /// Channel C.
    pub model_velocity: f64,
    /// Channel K.
    pub pose: f64,
}

impl ChannelLevels {
    /// Error per channel of several logs together.
    pub fn of(predictions: &[Prediction]) -> Self {
        let level = |channel: Channel| {
            let each = predictions.iter().map(|p| sum_of_squares(p, channel));
            let add = |all: (f64, usize), one: (f64, usize)| (all.0 + one.0, all.1 + one.1);
            let (squares, count) = each.fold((0.0, 0), add);
            // A wrench that is judged, but of which no row is predicted, has no error: NaN in place of 0.
            let is_judged = predictions.iter().any(|p| !p.judged(channel).is_empty());
            match (count, is_judged) {
                (0, true) if channel == Channel::Wrench => f64::NAN,
                _ => (squares / count.max(1) as f64).sqrt(),
            }
        };
        Self {
            executed_velocity: level(Channel::ExecutedVelocity),
            wrench: level(Channel::Wrench),
            model_velocity: level(Channel::ModelVelocity),
            pose: level(Channel::Pose),
        }
    }

    /// Root mean square over the channels that have noise of their own, so that 1 means noise, however many channels were
    /// measured. The model velocity has no such noise and is not counted; its squared error is in the sum, and is 0 with the
    /// right model.
    pub fn rms(&self) -> f64 {
        let noisy = [self.executed_velocity, self.wrench, self.pose];
        let count = noisy.iter().filter(|z| **z > ROUND_OFF_SIGMA).count();
        let all = noisy.iter().chain([&self.model_velocity]);
        let squares: f64 = all.map(|z| z * z).sum();
        (squares / count.max(1) as f64).sqrt()
    }
}

/// Error before and after the named effects, on unseen data where there is some.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BeforeAfter {
    /// With the model as it was given.
    pub before: ChannelLevels,
    /// With the named effects.
    pub after: ChannelLevels,
    /// Noise of the wrench, if all axes on which it is judged have the same: its error in N or N·m is its level times this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wrench_noise: Option<Noise>,
}

/// Noise of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Noise {
    /// One standard deviation.
    pub sigma: f64,
    /// Its SI unit.
    pub unit: &'static str,
}

impl BeforeAfter {
    /// The errors of two predictions of the same logs.
    pub fn of(before: &[Prediction], after: &[Prediction]) -> Self {
        Self {
            before: ChannelLevels::of(before),
            after: ChannelLevels::of(after),
            wrench_noise: wrench_noise(before),
        }
    }

    /// Errors before and after in SI units, with the unit. `None` if they are not those of a wrench alone, on axes with one noise.
    pub fn of_wrench_alone(&self) -> Option<([f64; 2], &'static str)> {
        let both = [&self.before, &self.after];
        let is_known = both.iter().all(|levels| levels.wrench.is_finite());
        let is_alone = both.iter().all(|levels| {
            let others = [levels.executed_velocity, levels.model_velocity, levels.pose];
            others.iter().all(|level| *level < ROUND_OFF_SIGMA)
        });
        let Noise { sigma, unit } = self.wrench_noise.filter(|_| is_known && is_alone)?;
        Some((both.map(|levels| levels.wrench * sigma), unit))
    }
}

/// See [`BeforeAfter::wrench_noise`].
fn wrench_noise(predictions: &[Prediction]) -> Option<Noise> {
    let mut all = predictions.iter().flat_map(|prediction| {
        let sigma = prediction.channel(Channel::Wrench).sigma;
        let axes = prediction.judged(Channel::Wrench).iter();
        axes.map(move |axis| Noise {
            sigma: sigma[axis.index()],
            unit: Channel::Wrench.unit(*axis),
        })
    });
    let first = all.next()?;
    all.all(|other| other == first).then_some(first)
}

/// One step of the error's fall: the model before the first, then one effect each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Effect that is added, `nominal` for the first.
    pub effect: String,
    /// Error on the log of the fit.
    pub train_error: f64,
    /// Error on unseen data, if there is any.
    pub test_error: Option<f64>,
}

impl Step {
    /// The error by which it is judged: that on unseen data where there is some.
    pub fn judged(&self) -> f64 {
        self.test_error.unwrap_or(self.train_error)
    }
}

/// Error of a model on recordings, all channels together ([`ChannelLevels::rms`]).
///
/// # Errors
///
/// A recording that cannot be predicted.
pub fn error(model: &Model, recordings: &[&Recording]) -> anyhow::Result<f64> {
    let predictions = recordings.iter().map(|recording| predict(model, recording));
    let predictions = predictions.collect::<anyhow::Result<Vec<_>>>()?;
    Ok(ChannelLevels::of(&predictions).rms())
}

/// Sum of (residual / noise)² of a channel, and the number of its values, as docking-rig-log/1 counts them: all cycles; of the
/// wrench those that are predicted; of the pose the translations alone. The model velocity has no noise but the rounding to a
/// log's digits: its variance is subtracted from each squared residual.
fn sum_of_squares(prediction: &Prediction, channel: Channel) -> (f64, usize) {
    let series = prediction.channel(channel);
    let judged = prediction.judged(channel).iter();
    let axes: Vec<&Axis> = judged
        .filter(|a| !(channel == Channel::Pose && a.is_rotation()))
        .collect();
    let count = axes.len() * series.rows_that_count();
    let mut sum = 0.0;
    for axis in axes {
        let sigma = series.sigma[axis.index()];
        let digits = match channel {
            Channel::ModelVelocity => variance_of_digits(series, *axis),
            _ => 0.0,
        };
        for n in 0..prediction.time_s.len() {
            let residual = series.residual(n, *axis).unwrap_or(0.0);
            let by_digits = if residual == 0.0 { 0.0 } else { digits };
            sum += (residual * residual - by_digits) / (sigma * sigma);
        }
    }
    (sum.max(0.0), count)
}

/// Variance of the difference of two values that are both rounded to the digits of a log: 2 digit²/12. 0 if all values are 0.
fn variance_of_digits(series: &ChannelPrediction, axis: Axis) -> f64 {
    let values: Vec<f64> = series
        .measured
        .iter()
        .map(|row| row[axis.index()])
        .collect();
    if values.iter().all(|v| *v == 0.0) {
        return 0.0;
    }
    let digit = digit_of(&values);
    digit * digit / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Velocity, wrench, the model's velocity, pose.
    fn rms(levels: [f64; 4]) -> f64 {
        let [executed_velocity, wrench, model_velocity, pose] = levels;
        ChannelLevels {
            executed_velocity,
            wrench,
            model_velocity,
            pose,
        }
        .rms()
    }

    #[test]
    fn one_is_noise_whatever_was_measured() {
        assert_eq!(rms([0.0, 1.0, 0.0, 0.0]), 1.0);
        assert_eq!(rms([1.0, 1.0, 0.0, 0.0]), 1.0);
        assert_eq!(rms([1.0, 1.0, 0.0, 1.0]), 1.0);
    }

    /// An error of 4 times a noise of 0.5 N is one of 2 N, if nothing else has an error.
    #[test]
    fn errors_of_a_wrench_alone_have_its_unit() {
        let levels = |wrench: f64, executed_velocity: f64| ChannelLevels {
            executed_velocity,
            wrench,
            ..ChannelLevels::default()
        };
        let both = |before: ChannelLevels, after: ChannelLevels| BeforeAfter {
            before,
            after,
            wrench_noise: Some(Noise {
                sigma: 0.5,
                unit: "N",
            }),
        };
        let alone = both(levels(4.0, 0.0), levels(1.0, 0.0));
        assert_eq!(alone.of_wrench_alone(), Some(([2.0, 0.5], "N")));
        let unknown = BeforeAfter {
            wrench_noise: None,
            ..alone
        };
        let moves = both(levels(4.0, 1.0), levels(1.0, 1.0));
        let unpredicted = both(levels(4.0, 0.0), levels(f64::NAN, 0.0));
        for none in [unknown, moves, unpredicted] {
            assert_eq!(none.of_wrench_alone(), None);
        }
    }

    #[test]
    fn an_error_of_the_models_velocity_is_added_to_the_noise_of_the_others() {
        assert_eq!(rms([1.0, 1.0, 4.0, 0.0]), 3.0);
        assert_eq!(rms([0.0, 0.0, 4.0, 0.0]), 4.0);
    }
}
