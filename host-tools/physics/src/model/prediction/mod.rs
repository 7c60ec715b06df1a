//! One-step-ahead predictions: what each cycle of a recording should have measured, given everything else that was recorded.
//!
//! | channel | predicted from | by |
//! |---|---|---|
//! | executed_velocity | velocities sent | nominal actuator ([`executed`]) |
//! | wrench | measured pose and velocity | contact, tool, zero ([`wrench`]) |
//! | model_velocity | measured, compensated wrench | two-body dynamics ([`bodies`]) |
//! | pose | last pose, executed velocity | kinematics ([`pose`]) |
//!
//! Because each prediction starts from measurements, an error stays in the channel that causes it: a late robot affects
//! executed_velocity alone, a wall that is too soft only the wrench.

pub mod bodies;
pub mod differences;
pub mod executed;
pub mod pose;
pub mod retimed;
pub mod robot_axes;
pub mod signals;
#[cfg(test)]
mod tests;
pub mod wrench;

use super::load::Scene;
use super::load::loaded::{LoadOfEach, add_known};
use super::log::{Log, is_measured};
use super::{Axis, Channel, Model, clock};
use crate::effects::body::clock_jitter::{self, Scatter};
use signals::Signals;
use softdock_control::frames::{Pose, Twist};
use softdock_control::wrench::Motion;
use softdock_io::recording::Recording;
use softdock_report::number;

pub use crate::effects::law::Six;

/// Measured and predicted values of one channel.
#[derive(Clone, Debug)]
pub struct ChannelPrediction {
    /// Which channel.
    pub channel: Channel,
    /// Measured values of each cycle.
    pub measured: Vec<Six>,
    /// Predicted values; `None` where nothing can be predicted.
    pub predicted: Vec<Option<Six>>,
    /// Noise of the measurement by data sheet, one standard deviation.
    pub sigma: Six,
    /// Noise of measured minus predicted in each cycle, one standard deviation, including the noise of the measurements that the
    /// prediction uses; empty where it is `sigma` in all cycles.
    pub expected_sigma: Vec<Six>,
}

impl ChannelPrediction {
    /// Measured minus predicted.
    pub fn residual(&self, cycle: usize, axis: Axis) -> Option<f64> {
        let predicted = (*self.predicted.get(cycle)?)?;
        residual(self.measured.get(cycle)?, &predicted, axis)
    }

    /// Number of rows over which its error is a mean: all, but for a wrench only those that are predicted, as a drive's delay
    /// leaves a part of its log without prediction.
    pub fn rows_that_count(&self) -> usize {
        match self.channel {
            Channel::Wrench => self.predicted.iter().flatten().count(),
            _ => self.measured.len(),
        }
    }

    /// Axes on which anything was measured: one of six in the log of a joint, those that it has for a load cell.
    fn measured_axes(&self) -> Vec<Axis> {
        let of_axis = |axis: &Axis| is_measured(self.measured.iter().map(|row| row[axis.index()]));
        Axis::ALL.into_iter().filter(of_axis).collect()
    }

    /// Expected noise of the residual, one standard deviation.
    pub fn expected_sigma(&self, cycle: usize, axis: Axis) -> f64 {
        self.expected_sigma.get(cycle).unwrap_or(&self.sigma)[axis.index()]
    }
}

/// Measured minus predicted on an axis; `None` where either is not finite.
pub fn residual(measured: &Six, predicted: &Six, axis: Axis) -> Option<f64> {
    let residual = measured[axis.index()] - predicted[axis.index()];
    residual.is_finite().then_some(residual)
}

/// All predictions for a recording.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Time of each cycle, s.
    pub time_s: Vec<f64>,
    /// Cycle time, s.
    pub cycle_s: f64,
    /// The channels, in the order of [`Channel::ALL`].
    pub channels: [ChannelPrediction; 4],
    /// Axes that are judged, per channel: the active ones, and of the wrench those that were measured.
    pub judged: [Vec<Axis>; 4],
    /// Sentences that say what could not be predicted, and why.
    pub notes: Vec<String>,
}

impl Prediction {
    /// A channel's values.
    pub fn channel(&self, channel: Channel) -> &ChannelPrediction {
        &self.channels[channel as usize]
    }

    /// A channel's judged axes.
    pub fn judged(&self, channel: Channel) -> &[Axis] {
        &self.judged[channel as usize]
    }
}

/// Predicts all channels of a recording.
///
/// # Errors
///
/// A recording with fewer than two cycles, settings in it that cannot be read, or a cycle time
/// that cannot be found.
pub fn predict(model: &Model, recording: &Recording) -> anyhow::Result<Prediction> {
    Ok(predict_signals(model, &Signals::new(recording)?))
}

/// A note if the inertial load of an unfiltered log is dominated by noise, which biases a regression on it; else `None`.
fn drowned(model: &Model, signals: &Signals<'_>) -> Option<String> {
    if signals.is_commanded() || model.sensor.filter.is_some() || model.sensor.at_rest {
        return None;
    }
    let (_, acceleration) = signals.motion_sigma(model);
    let inertial = inertial_sigma(model, signals.cycle_s, &acceleration);
    let sensor = six(model.noise.force_n, model.noise.torque_n_m);
    let drowned = |axis: &&Axis| inertial[axis.index()] > sensor[axis.index()];
    let axis = model.rig.active_axes.iter().find(drowned)?;
    Some(format!(
        "The noise of the motion, differentiated and times what is moved, is {} in wrench {axis}, more \
         than the sensor's {}: what follows from acceleration is not told from noise there. A [filter] \
         in the mapping of the import that keeps the motion and cuts the rest helps.",
        quantity(inertial[axis.index()], *axis),
        quantity(sensor[axis.index()], *axis),
    ))
}

/// Noise of the wrench from that of the acceleration, through all moved masses of the model including its effects: the difference
/// of two readings at one place and velocity.
fn inertial_sigma(model: &Model, cycle_s: f64, acceleration_sigma: &Six) -> Six {
    let reading = |acceleration: Six| {
        let motion = Motion {
            velocity: Twist::of(&[1.0; 6]),
            acceleration: Twist::of(&acceleration),
        };
        let pose = vec![Pose::identity()];
        let mut scene = Scene::new(model, cycle_s, vec![0.0], pose, vec![motion]);
        add_known(&mut scene, &model.effects, &LoadOfEach::default());
        scene.reading.row(0)
    };
    let without = reading([0.0; 6]);
    let mut variance = [0.0; 6];
    for (axis, sigma) in acceleration_sigma.iter().enumerate() {
        let mut acceleration = [0.0; 6];
        acceleration[axis] = *sigma;
        for (sum, (with, without)) in variance
            .iter_mut()
            .zip(reading(acceleration).iter().zip(without))
        {
            *sum += (with - without).powi(2);
        }
    }
    variance.map(f64::sqrt)
}

fn quantity(value: f64, axis: Axis) -> String {
    format!(
        "{} {}",
        number::significant(value, 2),
        Channel::Wrench.unit(axis)
    )
}

/// Predicts all channels from signals that have been read already.
pub fn predict_signals(model: &Model, signals: &Signals<'_>) -> Prediction {
    let mut notes = Vec::new();
    let intervals_s = intervals(model, signals);
    let executed = executed::predict(model, signals, &intervals_s);
    let wrench = wrench::predict(model, signals, &intervals_s, &executed);
    let channels = [
        executed,
        wrench,
        bodies::predict(model, signals, &mut notes),
        pose::predict(model, signals, &intervals_s),
    ];
    if signals.velocity == signals::VelocityMeaning::CycleMean {
        notes.push(
            "The recorded velocity is the difference of the recorded poses: pose cannot differ \
             from it, and its noise is that of the pose."
                .to_owned(),
        );
    }
    notes.extend(drowned(model, signals));
    let active = &model.rig.active_axes;
    let measured = channels[Channel::Wrench as usize].measured_axes();
    let free = model.free_axes();
    let is_loaded = |axis: &Axis| free[axis.index()] || measured.contains(axis);
    let loaded = Axis::ALL.into_iter().filter(is_loaded).collect();
    Prediction {
        time_s: signals.cycles.iter().map(|c| c.trace.time_s).collect(),
        cycle_s: signals.cycle_s,
        channels,
        judged: [active.clone(), loaded, active.clone(), active.clone()],
        notes,
    }
}

/// True durations of the cycles, if the model says that the clock jitters, or that all cycles are longer and the recorded
/// velocity does not account for that; else empty.
pub fn intervals(model: &Model, signals: &Signals<'_>) -> Vec<f64> {
    let rate = model.clock_rate_error();
    let longer = match signals.velocity {
        signals::VelocityMeaning::CycleMean => 1.0 + rate,
        signals::VelocityMeaning::Sampled => 1.0,
    };
    let mut all = jittering(model, signals);
    if longer != 1.0 {
        all.resize(signals.len(), signals.cycle_s);
        all.iter_mut().for_each(|interval| *interval *= longer);
    }
    all
}

fn jittering(model: &Model, signals: &Signals<'_>) -> Vec<f64> {
    let jitter = model
        .effects
        .iter()
        .find(|e| e.id == clock_jitter::EFFECT.id);
    let Some(jitter) = jitter.and_then(|e| Scatter::of(&e.parameters)) else {
        return Vec::new();
    };
    let Ok(log) = Log::of(signals, model) else {
        return Vec::new();
    };
    let mut all = vec![signals.cycle_s; signals.len()];
    let recovered = clock::recover(model, &log, &jitter);
    all.iter_mut()
        .skip(log.first)
        .zip(recovered)
        .for_each(|(all, recovered)| *all = recovered);
    all
}

/// Two three-vectors as six numbers.
fn six(linear: f64, angular: f64) -> Six {
    [linear, linear, linear, angular, angular, angular]
}
