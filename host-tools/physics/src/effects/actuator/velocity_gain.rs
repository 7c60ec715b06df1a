//! Gain error between commanded and executed velocity.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "velocity_gain",
    title: "Gain of the velocity",
    summary: "the executed velocity is the commanded one times a wrong factor",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "v = (1 + gain_error) u",
    source: "textbook (gain error); override and unit mistakes of a robot program act so",
    signature: "the error is proportional to the velocity at all times, without delay or distortion",
    typical: "below 1 %, except after a mistake in units or in the robot's override, or where the command is a voltage or \
              a valve's opening whose scale was guessed",
    parameters: &[Parameter::new("gain_error", "-", -0.95, 20.0)
        .hidden(0.04, 0.1)
        .either_sign()
        .pictured(-0.15)],
    confused_with: &["velocity_saturation", "gain_by_direction", "clock_rate"],
    tell_apart: "a jog over a measured distance: with a wrong gain executed and commanded velocity differ, with a \
                 wrong clock only the distance does",
    law: Law::Actuator(Actuator {
        axis: Some(|p, _| VelocityGain::new(p[0]).map(AxisStage::Gain)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Gain of one axis.
#[derive(Clone, Copy, Debug)]
pub struct VelocityGain {
    gain: f64,
}

impl VelocityGain {
    /// `gain_error` −1 (stands still) to 100.
    pub fn new(gain_error: f64) -> Result<Self, SettingsError> {
        in_range("gain_error", gain_error, -1.0, 100.0)?;
        Ok(Self {
            gain: 1.0 + gain_error,
        })
    }

    /// The executed velocity.
    pub fn apply(&self, input: f64) -> f64 {
        self.gain * input
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_percent_slow() {
        let axis = VelocityGain::new(-0.1).unwrap();
        assert!((axis.apply(0.5) - 0.45).abs() < 1e-15);
        assert_eq!(VelocityGain::new(-1.5).unwrap_err().received, -1.5);
    }
}
