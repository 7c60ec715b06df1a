//! The error of one axis as a series, and the correlation of its expected noise.

use super::Source;
use softdock_physics::model::load::LoadModel;
use softdock_physics::model::prediction::Six;
use softdock_physics::model::prediction::differences;
use softdock_physics::model::prediction::signals::VelocityMeaning;
use softdock_physics::model::{Axis, Channel, Model};

/// Values that are computed twice from the same numbers differ by round-off: errors below this multiple of the noise are not
/// looked at.
pub const ROUND_OFF_SIGMA: f64 = 1e-6;

/// Error of an axis in units of the noise to expect; NaN where nothing is predicted.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its channel.
    pub channel: Channel,
    /// Its axis.
    pub axis: Axis,
    /// Values.
    pub relative: Vec<f64>,
    /// Correlation of the expected noise at lags 1, 2 ...: differences of noisy values are not white.
    pub noise: Vec<f64>,
}

impl Series {
    /// Sum of squares and number of values.
    pub(super) fn squares(&self) -> (f64, usize) {
        let known = self.relative.iter().filter(|v| v.is_finite());
        known.fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1))
    }

    /// Whether the error is larger than round-off.
    pub fn is_there(&self) -> bool {
        let (squares, count) = self.squares();
        squares > ROUND_OFF_SIGMA * ROUND_OFF_SIGMA * count as f64
    }

    /// The values; NaN where a reading repeats that of the cycle before, as a slow sensor holds its sample.
    pub(super) fn fresh(&self, source: &Source<'_>) -> Vec<f64> {
        if self.channel != Channel::Wrench {
            return self.relative.clone();
        }
        let sampled = |n: usize| source.signals.sampled_in(n);
        let values = self.relative.iter().enumerate();
        values
            .map(|(n, v)| {
                let held = n > 0 && sampled(n) == sampled(n - 1);
                if held { f64::NAN } else { *v }
            })
            .collect()
    }
}

/// The errors of all judged axes.
pub(super) fn of_axes(source: &Source<'_>) -> Vec<Series> {
    let inertial = inertial_share(source);
    let mut found = Vec::new();
    for channel in Channel::ALL {
        for axis in source.prediction.judged(channel) {
            let values = source.prediction.channel(channel);
            let relative = (0..source.signals.len())
                .map(|n| match values.residual(n, *axis) {
                    Some(error) => error / values.expected_sigma(n, *axis),
                    None => f64::NAN,
                })
                .collect();
            found.push(Series {
                channel,
                axis: *axis,
                relative,
                noise: noise(source, channel, inertial[axis.index()]),
            });
        }
    }
    found
}

/// Correlation of the noise at lags 1 and 2. A first difference has −1/2 at lag 1; the second difference of poses that makes an
/// acceleration has −2/3 and 1/6. Where nothing was sent, accelerations come from wider differences, with a correlation of their
/// own.
fn noise(source: &Source<'_>, channel: Channel, inertial: f64) -> Vec<f64> {
    let of_poses = source.signals.velocity == VelocityMeaning::CycleMean;
    match (channel, of_poses) {
        (Channel::ExecutedVelocity, false) => vec![0.0, 0.0],
        (Channel::ExecutedVelocity | Channel::ModelVelocity | Channel::Pose, _) => vec![-0.5, 0.0],
        (Channel::Wrench, _) if inertial > 0.0 && !source.signals.is_commanded() => {
            let of_acceleration = differences::correlation(of_poses);
            of_acceleration.map(|r| r * inertial).to_vec()
        }
        (Channel::Wrench, false) => vec![-0.5 * inertial, 0.0],
        (Channel::Wrench, true) => vec![-2.0 / 3.0 * inertial, inertial / 6.0],
    }
}

/// Share of the variance of each axis of the wrench in free flight that the noise of the acceleration contributes through the
/// tool's mass.
fn inertial_share(source: &Source<'_>) -> Six {
    let model: &Model = source.model;
    let load = LoadModel::new(model);
    if !load.inertial {
        return [0.0; 6];
    }
    let (_, acceleration_sigma) = source.signals.motion_sigma(model);
    let variance = load.inertial_variance(&acceleration_sigma);
    Axis::ALL.map(|axis| {
        let sensor = if axis.is_rotation() {
            model.noise.torque_n_m
        } else {
            model.noise.force_n
        };
        let inertial = variance[axis.index()];
        inertial / (sensor * sensor + inertial).max(f64::MIN_POSITIVE)
    })
}
