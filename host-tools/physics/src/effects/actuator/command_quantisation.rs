//! Resolution of the velocity command.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "command_quantisation",
    title: "Resolution of the command",
    summary: "the command is rounded to a step before it is executed",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "v = step_m_s round(u / step_m_s)",
    source: "number formats of correction telegrams (digits after the point); textbook (uniform quantiser)",
    signature: "executed velocity is a staircase; velocities below half a step are not executed at all and the \
                pose drifts away from the integral of the command",
    typical: "0.25 mm/s for corrections of 1 um per 4 ms cycle; nothing where the rounding error is carried over",
    parameters: &[Parameter::new("step_m_s", "m/s", 0.0, 0.01)
        .of_rotations(0.0, 1.0)
        .hidden(2e-3, 4e-3)
        .pictured(0.005)],
    confused_with: &["command_deadzone", "zero_cross_pause", "backlash"],
    tell_apart: "a slow ramp of the velocity through zero: the stairs stand at the same velocities each time; a \
                 pause or a play happens only where the velocity changes sign",
    law: Law::Actuator(Actuator {
        axis: Some(|p, _| CommandQuantisation::new(p[0]).map(AxisStage::Rounding)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Rounding of one axis' command.
#[derive(Clone, Copy, Debug)]
pub struct CommandQuantisation {
    step: f64,
    /// 1/step, or 0 where nothing is rounded.
    inverse_step: f64,
}

impl CommandQuantisation {
    /// `step_m_s` 0 (no effect) to 1 m/s; below 1e-7 m/s nothing is rounded, which keeps the
    /// quotient representable in fixed point.
    pub fn new(step_m_s: f64) -> Result<Self, SettingsError> {
        in_range("step_m_s", step_m_s, 0.0, 1.0)?;
        let inverse = if step_m_s < 1e-7 { 0.0 } else { 1.0 / step_m_s };
        Ok(Self {
            step: step_m_s,
            inverse_step: inverse,
        })
    }

    /// The rounded command, halves away from zero.
    pub fn apply(&self, input: f64) -> f64 {
        if self.inverse_step == 0.0 {
            return input;
        }
        (input * self.inverse_step).round() * self.step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_stand_on_stairs() {
        let axis = CommandQuantisation::new(0.25).unwrap();
        let got = [0.1, 0.13, -0.3, -0.4, 1.0].map(|u| axis.apply(u));
        assert_eq!(got, [0.0, 0.25, -0.25, -0.5, 1.0]);
        let fine = CommandQuantisation::new(0.0).unwrap();
        assert_eq!(fine.apply(0.1), 0.1);
    }
}
