//! Backlash: play between the drive and what it moves.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter, check_step};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "backlash",
    title: "Backlash",
    summary: "after a reversal the drive crosses a play before the axis follows",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "play operator: p = clamp(p, q - width_m/2, q + width_m/2), q = integral of the drive's velocity, \
               v = dp/dt",
    source: "textbook (play operator of a gear)",
    signature: "executed velocity is zero after each reversal until the drive has travelled the width; the pose \
                lags by half the width on either side",
    typical: "0.01 to 0.2 mm at the flange of a worn gear; 0.3 rad of a wrist that is driven by slack cables",
    parameters: &[Parameter::new("width_m", "m", 0.0, 0.02)
        .of_rotations(0.0, 1.0)
        .hidden(2e-4, 5e-4)
        .pictured(0.0005)],
    confused_with: &[
        "zero_cross_pause",
        "command_quantisation",
        "contact_deadzone",
    ],
    tell_apart: "reversals at different speed: backlash takes the same distance, a pause the same time",
    law: Law::Actuator(Actuator {
        axis: Some(|p, step_s| Backlash::new(p[0], step_s).map(AxisStage::Backlash)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Play of one axis; it begins in its middle.
#[derive(Clone, Copy, Debug)]
pub struct Backlash {
    half_width: f64,
    step: f64,
    inverse_step: f64,
    /// How far the drive is ahead of the axis, m.
    ahead: f64,
}

impl Backlash {
    /// `width_m` 0 (no effect) to 1 m or rad, `step_s` in s.
    pub fn new(width_m: f64, step_s: f64) -> Result<Self, SettingsError> {
        in_range("width_m", width_m, 0.0, 1.0)?;
        check_step(step_s)?;
        Ok(Self {
            half_width: 0.5 * width_m,
            step: step_s,
            inverse_step: 1.0 / step_s,
            ahead: 0.0,
        })
    }

    /// One step of the drive with this mean velocity; returns the mean velocity of the axis.
    pub fn advance(&mut self, input: f64) -> f64 {
        let ahead = self.ahead + input * self.step;
        self.ahead = ahead.clamp(-self.half_width, self.half_width);
        (ahead - self.ahead) * self.inverse_step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of the play is lost at the start, all of it at the reversal. Powers of two are exact.
    #[test]
    fn the_play_is_crossed_first() {
        let mut axis = Backlash::new(0.0625, 0.125).unwrap();
        let moved = [0.125, 0.25, 0.5, -0.25, -0.5, -0.5].map(|u| axis.advance(u));
        assert_eq!(moved, [0.0, 0.125, 0.5, 0.0, -0.25, -0.5]);
    }
}
