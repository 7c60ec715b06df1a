//! The synthetic log: 12 s of a spacecraft that moves at 10 mm/s between two stops and touches one every two seconds. The
//! robot is 32.1 ms late and pauses for 11.2 ms where its velocity changes sign.

use softdock_physics::model::prediction::{ChannelPrediction, Prediction, Six};
use softdock_physics::model::{Axis, Channel};
use std::f64::consts::PI;

/// Cycles of the log.
const CYCLES: usize = 3000;
/// Cycle time, s.
const CYCLE_S: f64 = 0.004;
/// Time from touch to touch, s.
pub(super) const PERIOD_S: f64 = 2.0;
/// First touch, s.
pub(super) const FIRST_TOUCH_S: f64 = 1.0;
/// Length of a contact, s.
pub(super) const CONTACT_S: f64 = 0.4;
/// Velocity of the flight, m/s.
const SPEED_M_S: f64 = 0.01;
/// Largest contact force, N.
const PEAK_N: f64 = 38.0;
/// Noise of the velocity, m/s and rad/s.
pub(super) const VELOCITY_SIGMA: f64 = 5e-5;
/// Noise of the wrench, N; a tenth of it in N·m.
pub(super) const FORCE_SIGMA: f64 = 0.15;
/// Noise of the pose, m and rad.
const POSE_SIGMA: f64 = 2e-5;

/// Elapsed part of the contact, from 0 to 1, and the number of the contact; None in flight.
fn contact(t: f64) -> Option<(f64, i32)> {
    let since = t - FIRST_TOUCH_S;
    let number = (since / PERIOD_S).floor();
    let part = (since - number * PERIOD_S) / CONTACT_S;
    (since >= 0.0 && part < 1.0).then_some((part, number as i32))
}

/// Commanded velocity along x, m/s.
fn velocity(t: f64) -> f64 {
    let touches = ((t - FIRST_TOUCH_S) / PERIOD_S).floor() as i32;
    let sign = |number: i32| if number % 2 == 0 { 1.0 } else { -1.0 };
    match contact(t) {
        Some((part, number)) => sign(number) * SPEED_M_S * (PI * part).cos(),
        None => sign(touches + 1) * SPEED_M_S,
    }
}

/// Velocity of a robot that is late and pauses at the turning point.
fn executed(t: f64, delay_s: f64, pause_s: f64) -> f64 {
    let turning = contact(t - delay_s).map(|(part, _)| (part - 0.5) * CONTACT_S);
    match turning {
        Some(since) if (0.0..pause_s).contains(&since) => 0.0,
        _ => velocity(t - delay_s),
    }
}

/// Contact force along x, N.
pub(super) fn force(t: f64) -> f64 {
    contact(t).map_or(0.0, |(part, number)| {
        let sign = if number % 2 == 0 { -1.0 } else { 1.0 };
        sign * PEAK_N * (PI * part).sin()
    })
}

/// Normal noise of standard deviation 1, the same in each run (sum of twelve uniform numbers).
fn noise(seed: usize) -> f64 {
    let uniform = |index: usize| {
        let mut bits = (seed * 12 + index) as u64;
        bits = (bits ^ (bits >> 30) ^ 0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (bits >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}

/// One channel: `truth` plus noise against `model`, each a function of time and axis.
fn channel(
    channel: Channel,
    sigma: Six,
    truth: impl Fn(f64, usize) -> f64,
    model: impl Fn(f64, usize) -> f64,
) -> ChannelPrediction {
    let time = |n: usize| n as f64 * CYCLE_S;
    let seed = |n: usize, axis: usize| (n * 4 + channel as usize) * 6 + axis;
    ChannelPrediction {
        channel,
        measured: (0..CYCLES)
            .map(|n| {
                std::array::from_fn(|i| {
                    // This velocity is computed by the rig, so it has no noise.
                    let noisy = channel != Channel::ModelVelocity;
                    truth(time(n), i)
                        + if noisy {
                            sigma[i] * noise(seed(n, i))
                        } else {
                            0.0
                        }
                })
            })
            .collect(),
        // There is no prediction before enough past cycles are known.
        predicted: (0..CYCLES)
            .map(|n| (n >= 12).then(|| std::array::from_fn(|i| model(time(n), i))))
            .collect(),
        sigma,
        expected_sigma: Vec::new(),
    }
}

/// Predictions by a model with this delay and pause, for a log with this torque about y.
pub(super) fn predict(delay_s: f64, pause_s: f64, torque: impl Fn(f64) -> f64) -> Prediction {
    let along_x = |axis: usize, value: f64| if axis == 0 { value } else { 0.0 };
    let loads = |t: f64, axis: usize, torque: f64| match axis {
        0 => force(t),
        4 => torque,
        _ => 0.0,
    };
    let wrench_sigma = std::array::from_fn(|i| FORCE_SIGMA * if i < 3 { 1.0 } else { 0.1 });
    let position = |t: f64, axis: usize| along_x(axis, 0.3 + 0.005 * (PI * t / PERIOD_S).sin());
    let axes = vec![Axis::X, Axis::Y, Axis::Z];
    Prediction {
        time_s: (0..CYCLES).map(|n| n as f64 * CYCLE_S).collect(),
        cycle_s: CYCLE_S,
        channels: [
            channel(
                Channel::ExecutedVelocity,
                [VELOCITY_SIGMA; 6],
                |t, i| along_x(i, executed(t, 0.0321, 0.0112)),
                |t, i| along_x(i, executed(t, delay_s, pause_s)),
            ),
            channel(
                Channel::Wrench,
                wrench_sigma,
                |t, i| loads(t, i, torque(t)),
                |t, i| loads(t, i, 0.0),
            ),
            channel(
                Channel::ModelVelocity,
                [VELOCITY_SIGMA; 6],
                |t, i| along_x(i, velocity(t)),
                |t, i| along_x(i, velocity(t)),
            ),
            channel(Channel::Pose, [POSE_SIGMA; 6], position, position),
        ],
        judged: [axes.clone(), Axis::ALL.to_vec(), axes.clone(), axes],
        notes: Vec::new(),
    }
}
