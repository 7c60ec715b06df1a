//! Measured quantities: delayed and noisy poses, noisy wrenches.

use crate::Axes;
use crate::noise::Noise;
use std::collections::VecDeque;

/// Errors of the feedback.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Cycles by which the measured pose is older than the wrench.
    pub pose_latency_cycles: usize,
    /// Noise of X Y Z, standard deviation, m.
    pub position_noise_m: f64,
    /// Noise of A B C, standard deviation, rad.
    pub angle_noise_rad: f64,
    /// Noise of each force, standard deviation, N.
    pub force_noise_n: f64,
    /// Noise of each torque, standard deviation, N·m.
    pub torque_noise_n_m: f64,
}

/// The measurement system of a run.
#[derive(Clone, Debug)]
pub(crate) struct Feedback {
    settings: Measurement,
    poses: VecDeque<Axes>,
    pose_noise: Noise,
    wrench_noise: Noise,
}

impl Feedback {
    pub(crate) fn new(settings: &Measurement, start: Axes, seed: u64) -> Self {
        Self {
            settings: *settings,
            poses: std::iter::repeat_n(start, settings.pose_latency_cycles).collect(),
            pose_noise: Noise::new(seed, 1),
            wrench_noise: Noise::new(seed, 2),
        }
    }

    /// The measured pose of this cycle.
    pub(crate) fn pose(&mut self, truth: Axes) -> Axes {
        self.poses.push_back(truth);
        let late = self.poses.pop_front().unwrap_or(truth);
        let (linear, angular) = (
            self.settings.position_noise_m,
            self.settings.angle_noise_rad,
        );
        noisy(&mut self.pose_noise, late, linear, angular)
    }

    /// The measured wrench of this cycle.
    pub(crate) fn wrench(&mut self, truth: Axes) -> Axes {
        let (linear, angular) = (self.settings.force_noise_n, self.settings.torque_noise_n_m);
        noisy(&mut self.wrench_noise, truth, linear, angular)
    }
}

fn noisy(noise: &mut Noise, values: Axes, linear: f64, angular: f64) -> Axes {
    std::array::from_fn(|i| values[i] + noise.normal(if i < 3 { linear } else { angular }))
}
