//! Deviation of the robot's delay from cycle to cycle.

use super::checks::check;
use super::settings::RigSettings;
use anyhow::Result;
use softdock_statistics::RandomStream;

/// Deviation of the delay from cycle to cycle.
#[derive(Clone, Debug)]
pub(super) struct Jitter {
    probability: f64,
    size_s: f64,
    noise: RandomStream,
    /// Additional delay of the running cycle, s.
    pub(super) now_s: f64,
}

impl Jitter {
    pub(super) fn new(settings: &RigSettings, noise: RandomStream) -> Result<Self> {
        let r = &settings.robot;
        check(
            "rig.robot.delay_jitter_probability",
            r.delay_jitter_probability,
            0.0,
            0.5,
        )?;
        check(
            "rig.robot.delay_jitter_cycles",
            f64::from(r.delay_jitter_cycles),
            0.0,
            8.0,
        )?;
        Ok(Self {
            probability: r.delay_jitter_probability,
            size_s: f64::from(r.delay_jitter_cycles) * settings.cycle_s(),
            noise,
            now_s: 0.0,
        })
    }

    pub(super) fn draw(&mut self) {
        if self.probability > 0.0 {
            let drawn = self.noise.uniform();
            self.now_s = if drawn <= self.probability {
                self.size_s
            } else if drawn > 1.0 - self.probability {
                -self.size_s
            } else {
                0.0
            };
        }
    }
}
