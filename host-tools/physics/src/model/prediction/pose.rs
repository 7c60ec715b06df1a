//! Pose from the last pose and the executed velocity (channel K of docs/docking-rig-log-1.md).
//!
//! `p(n) = p(n−1) + Ts/2 (v(n) + v(n−1))` with sampled velocities, `p(n−1) + Ts v(n)` with means
//! over the cycle; rotations likewise with the rotation vector of `R(n−1)ᵀ R(n)`. Angles are
//! given from the first pose of the recording, axes of M; that of a bearing counts whole turns.

use super::signals::{Signals, VelocityMeaning};
use super::{ChannelPrediction, Six, six};
use crate::model::load::{count_turns, turn_between};
use crate::model::{Channel, Model};
use softdock_control::frames::{Pose, Twist};

/// Predicts the channel; `intervals_s` are the true durations of the cycles, empty if nominal.
pub fn predict(model: &Model, signals: &Signals<'_>, intervals_s: &[f64]) -> ChannelPrediction {
    let clock = ClockErrors::of(model, signals);
    let noise = &model.noise;
    let root2 = std::f64::consts::SQRT_2;
    let first = (0..signals.len()).find_map(|n| signals.pose(n));
    let mut measured: Vec<Six> = (0..signals.len())
        .map(|n| match (first, signals.pose(n)) {
            (Some(first), Some(pose)) => coordinates(&first, &pose),
            _ => [f64::NAN; 6],
        })
        .collect();
    if let Some(axis) = model.bearing() {
        let ahead = |n: usize| signals.turned_by_velocity(n)[axis.index() - 3];
        let angles = measured.iter_mut().map(|six| &mut six[axis.index()]);
        count_turns(angles.zip((0..).map(ahead)));
    }
    let predicted = (0..signals.len())
        .map(|n| {
            let error = increment_error(signals, n, intervals_s, &clock)?;
            let mut value = measured[n];
            value.iter_mut().zip(error).for_each(|(v, e)| *v -= e);
            Some(value)
        })
        .collect();
    ChannelPrediction {
        channel: Channel::Pose,
        measured,
        predicted,
        sigma: six(root2 * noise.position_m, root2 * noise.angle_rad),
        expected_sigma: expected_sigma(model, signals),
    }
}

/// Errors of the clock that the model file knows.
struct ClockErrors {
    /// Relative error of the duration of all cycles.
    rate: f64,
    /// Delay of the pose relative to the velocity, s.
    offset_s: f64,
}

impl ClockErrors {
    fn of(model: &Model, signals: &Signals<'_>) -> Self {
        let offset_s = model.clock_offset_s();
        Self {
            rate: model.clock_rate_error(),
            // For a machine that is no rig, pose and velocity have the same delay.
            offset_s: if signals.is_of_a_rig() { offset_s } else { 0.0 },
        }
    }
}

/// Measured minus predicted increment of the pose.
fn increment_error(
    signals: &Signals<'_>,
    n: usize,
    intervals_s: &[f64],
    clock: &ClockErrors,
) -> Option<Six> {
    let last = n.checked_sub(1)?;
    let said = signals.moved_by_velocity(n)?;
    let moved = increment(&signals.pose(last)?, &signals.pose(n)?, &said);
    if signals.velocity == VelocityMeaning::CycleMean {
        // The velocity is the difference of the poses, whatever the clock does.
        return Some((moved - said).get());
    }
    let interval_s = intervals_s.get(n).copied().unwrap_or(signals.cycle_s) * (1.0 + clock.rate);
    // A late pose shows the motion of an earlier time.
    let later = match clock.offset_s {
        0.0 => Twist::zero(),
        offset_s => (signals.executed(n)? - signals.executed(last)?) * offset_s,
    };
    Some((moved - said * (interval_s / signals.cycle_s) + later).get())
}

fn increment(from: &Pose<f64>, to: &Pose<f64>, said: &Twist<f64>) -> Twist<f64> {
    Twist {
        linear: to.translation.vector - from.translation.vector,
        angular: turn_between(&from.rotation, &to.rotation, &said.angular),
    }
}

/// Position in C and rotation vector from the first pose.
fn coordinates(first: &Pose<f64>, pose: &Pose<f64>) -> Six {
    let turned = (first.rotation.inverse() * pose.rotation).scaled_axis();
    Twist {
        linear: pose.translation.vector,
        angular: turned,
    }
    .get()
}

/// The increment also has the noise of two velocities, which is small compared with that of two poses.
fn expected_sigma(model: &Model, signals: &Signals<'_>) -> Vec<Six> {
    let noise = &model.noise;
    let velocity = signals.velocity_sigma(model);
    let steps = signals.noise_of_steps(model);
    let pose = six(steps * noise.position_m, steps * noise.angle_rad);
    let share = signals.cycle_s * signals.cycle_s * 0.5;
    let mut sigma = [0.0; 6];
    for i in 0..6 {
        sigma[i] = (pose[i] * pose[i] + share * velocity[i] * velocity[i]).sqrt();
    }
    vec![sigma; signals.len()]
}
