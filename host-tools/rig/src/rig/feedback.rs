//! How the controller measures its pose: late, noisy and rounded, as far as the settings say.

use super::checks::check;
use super::drive::Axes;
use super::settings::RigSettings;
use anyhow::Result;
use softdock_statistics::RandomStream;
use std::f64::consts::{PI, TAU};

/// Poses that the controller remembers: the longest feedback latency is one less.
const POSE_MEMORY: usize = 32;

/// How the controller measures its pose.
#[derive(Clone, Debug)]
pub(super) struct Feedback {
    poses: [Axes; POSE_MEMORY],
    latency_cycles: usize,
    noise_sigma: Axes,
    resolution: Axes,
    noise: RandomStream,
}

impl Feedback {
    pub(super) fn new(settings: &RigSettings, start: Axes, noise: RandomStream) -> Result<Self> {
        let r = &settings.robot;
        let latency_cycles = r.feedback_latency_cycles.into();
        let longest = (POSE_MEMORY - 1) as f64;
        check(
            "rig.robot.feedback_latency_cycles",
            f64::from(r.feedback_latency_cycles),
            0.0,
            longest,
        )?;
        check("rig.robot.position_noise_m", r.position_noise_m, 0.0, 0.1)?;
        check(
            "rig.robot.rotation_noise_rad",
            r.rotation_noise_rad,
            0.0,
            0.1,
        )?;
        check(
            "rig.robot.position_resolution_m",
            r.position_resolution_m,
            0.0,
            0.1,
        )?;
        check(
            "rig.robot.rotation_resolution_rad",
            r.rotation_resolution_rad,
            0.0,
            0.1,
        )?;
        let six = |linear, angular| [linear, linear, linear, angular, angular, angular];
        Ok(Self {
            poses: [start; POSE_MEMORY],
            latency_cycles,
            noise_sigma: six(r.position_noise_m, r.rotation_noise_rad),
            resolution: six(r.position_resolution_m, r.rotation_resolution_rad),
            noise,
        })
    }

    /// Remembers the pose of this cycle and measures the one that the latency lets through.
    pub(super) fn measure(&mut self, position: Axes, cycle: u64) -> Axes {
        let slot = (cycle % POSE_MEMORY as u64) as usize;
        self.poses[slot] = position;
        let mut seen = self.poses[(slot + POSE_MEMORY - self.latency_cycles) % POSE_MEMORY];
        for (axis, value) in seen.iter_mut().enumerate() {
            *value = self.noise.around(*value, self.noise_sigma[axis]);
            let resolution = self.resolution[axis];
            if resolution > 0.0 {
                *value = (*value / resolution).round() * resolution;
            }
        }
        for angle in [3, 5] {
            if seen[angle].abs() > PI {
                seen[angle] -= TAU * (seen[angle] / TAU).round();
            }
        }
        seen
    }
}
