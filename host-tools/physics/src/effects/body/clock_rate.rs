//! Rate of the control cycle's clock.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "clock_rate",
    title: "Rate of the clock",
    summary: "a cycle lasts longer or shorter than nominal",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "t = (1 + rate_error) t_nominal",
    source: "textbook (clock rate); crystals are within 100 ppm",
    signature: "the pose moves by a wrong factor of the integrated velocity, in all axes alike, while the \
                velocities fit",
    typical: "below 1e-4; 2 % where a cycle of 4 ms is counted for 4.08 ms",
    parameters: &[Parameter::new("rate_error", "-", -0.1, 0.1)
        .hidden(0.03, 0.06)
        .either_sign()
        .pictured(0.08)],
    confused_with: &["velocity_gain", "clock_jitter", "clock_offset"],
    tell_apart: "jog over a measured distance: velocity fits and distance does not; the factor is the same for \
                 every axis, a gain may differ",
    law: Law::Clock,
    ..Effect::PLAIN
};

/// A clock that is fast or slow.
#[derive(Clone, Copy, Debug)]
pub struct ClockRate {
    factor: f64,
}

impl ClockRate {
    /// `rate_error` within ±0.5: positive where real time runs ahead of the nominal time.
    pub fn new(rate_error: f64) -> Result<Self, SettingsError> {
        in_range("rate_error", rate_error, -0.5, 0.5)?;
        Ok(Self {
            factor: 1.0 + rate_error,
        })
    }

    /// Real time (s) since the start.
    pub fn real_time(&self, nominal_s: f64) -> f64 {
        nominal_s * self.factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_runs_ahead() {
        assert_eq!(ClockRate::new(0.25).unwrap().real_time(4.0), 5.0);
    }
}
