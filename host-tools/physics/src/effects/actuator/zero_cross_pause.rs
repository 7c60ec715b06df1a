//! Pause at a zero crossing: an axis that reverses stands still for a short time.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter, check_step, sign};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "zero_cross_pause",
    title: "Pause at a zero crossing",
    summary: "an axis stands still for a short time when its velocity changes sign",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "on a sign change of v: v = 0 for pause_s, then v resumes at the current (delayed) command; \
               the position that was missed is not caught up",
    source: "seed paper section 4.2 (observed on the robot; length and resumption are left open there, 16 to \
             32 ms fits its figures)",
    signature: "executed velocity is exactly zero for the same time after each reversal and the pose keeps an \
                offset afterwards",
    typical: "16 to 32 ms on an industrial arm; brakes, gear friction and torque reversal cause it",
    parameters: &[Parameter::new("pause_s", "s", 0.0, 0.1)
        .hidden(0.02, 0.032)
        .pictured(0.03)],
    confused_with: &["backlash", "guide_coulomb", "command_quantisation"],
    tell_apart: "reversals of different acceleration: a pause keeps its time, backlash keeps its distance, and a \
                 quantised command keeps its band of velocity",
    law: Law::Actuator(Actuator {
        axis: Some(|p, step_s| ZeroCrossingPause::new(p[0], step_s).map(AxisStage::Pause)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// The pause of one axis.
#[derive(Clone, Copy, Debug)]
pub struct ZeroCrossingPause {
    /// Length in steps: whole numbers count down without rounding.
    pause_steps: f64,
    remaining_steps: f64,
    /// Sign of the motion: +1, −1, or 0 when it is free to start in either direction.
    direction: f64,
}

impl ZeroCrossingPause {
    /// At rest. `pause_s` 0 (no effect) to 1 s, `step_s` in s.
    pub fn new(pause_s: f64, step_s: f64) -> Result<Self, SettingsError> {
        in_range("pause_s", pause_s, 0.0, 1.0)?;
        check_step(step_s)?;
        Ok(Self {
            pause_steps: pause_s / step_s,
            remaining_steps: 0.0,
            direction: 0.0,
        })
    }

    /// One step with constant input; returns the mean output over the step.
    ///
    /// A reversal begins at the start of the step that brings the new sign. A pause that ends
    /// inside a step lets the input through for the rest of it.
    pub fn advance(&mut self, input: f64) -> f64 {
        let sign = sign(input);
        if self.remaining_steps <= 0.0 && sign * self.direction < 0.0 {
            self.remaining_steps = self.pause_steps;
        }
        if self.remaining_steps >= 1.0 {
            self.remaining_steps -= 1.0;
            self.direction = 0.0; // after the pause either direction is a start from rest
            return 0.0;
        }
        let moving = 1.0 - self.remaining_steps;
        self.remaining_steps = 0.0;
        if sign != 0.0 {
            self.direction = sign;
        }
        input * moving
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// cos(w t) with a pause: 0 in [T/4, T/4 + Tp), the cosine itself everywhere else.
    #[test]
    fn stands_still_then_resumes_at_the_current_command() {
        let (step, pause) = (0.0005, 0.016);
        let mut axis = ZeroCrossingPause::new(pause, step).unwrap();
        for k in 0..400 {
            let t = step * (f64::from(k) + 0.5);
            let u = (std::f64::consts::TAU * t / 0.2).cos();
            let paused = [0.05, 0.15].iter().any(|c| t > *c && t < c + pause);
            let expected = if paused { 0.0 } else { u };
            let got = axis.advance(u);
            assert!((got - expected).abs() < 1e-6, "{t}: {got} {expected}");
        }
    }

    #[test]
    fn neither_a_start_nor_a_stop_is_a_crossing() {
        let mut axis = ZeroCrossingPause::new(0.004, 0.001).unwrap();
        let out = [0.0, -1.0, 0.0, -1.0].map(|u| axis.advance(u));
        assert_eq!(out, [0.0, -1.0, 0.0, -1.0]);
        // through an exact zero it is one
        let out = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0].map(|u| axis.advance(u));
        assert_eq!(out, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_pause_that_ends_inside_a_step_lets_the_rest_pass() {
        let mut axis = ZeroCrossingPause::new(0.0015, 0.001).unwrap();
        let out = [1.0, -1.0, -1.0, -1.0].map(|u| axis.advance(u));
        assert_eq!(out[..2], [1.0, 0.0]);
        assert!((out[2] + 0.5).abs() < 1e-12 && out[3] == -1.0);
    }
}
