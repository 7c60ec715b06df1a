//! Jerk limit of an axis: its acceleration changes no faster than this.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter, check_step};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "jerk_limit",
    title: "Jerk limit",
    summary: "the rate of change of the acceleration is limited",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "|d^2v/dt^2| <= max_jerk_m_s3; v approaches its input along the switching curve \
               dv/dt = sign(u - v) sqrt(2 max_jerk_m_s3 |u - v|), so that it arrives without overshoot",
    source: "textbook (time-optimal approach of a double integrator), as in jerk-limited interpolators",
    signature: "flanks of the executed velocity are S-shaped, and their time grows with the root of the height",
    typical: "10 to 200 m/s^3 at the flange; data sheets of joints say up to 12,500 rad/s^3",
    parameters: &[Parameter::new("max_jerk_m_s3", "m/s^3", 0.5, 1e4)
        .of_rotations(0.5, 1e5)
        .hidden(15.0, 30.0)
        .pictured(10.0)],
    confused_with: &[
        "rate_limit",
        "second_order_servo",
        "actuation_lag",
        "actuation_delay",
    ],
    tell_apart: "velocity steps of two heights, one four times the other: a jerk limit takes twice the time, an \
                 acceleration limit four times, a lag or a servo the same",
    law: Law::Actuator(Actuator {
        axis: Some(|p, step_s| JerkLimit::new(p[0], step_s).map(AxisStage::Jerk)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Jerk limit of one axis.
///
/// With a constant input, the axis reaches it in the shortest time that the limit allows.
#[derive(Clone, Copy, Debug)]
pub struct JerkLimit {
    /// Largest change of the acceleration in a step.
    largest_change: f64,
    twice_jerk: f64,
    step: f64,
    inverse_step: f64,
    /// Change of velocity that one step covers without having to brake.
    near: f64,
    value: f64,
    acceleration: f64,
}

impl JerkLimit {
    /// At rest. `max_jerk` in m/s³ (or rad/s³), 1e-3 to 1e6; `step_s` in s.
    pub fn new(max_jerk: f64, step_s: f64) -> Result<Self, SettingsError> {
        in_range("max_jerk_m_s3", max_jerk, 1e-3, 1e6)?;
        check_step(step_s)?;
        Ok(Self {
            largest_change: max_jerk * step_s,
            twice_jerk: 2.0 * max_jerk,
            step: step_s,
            inverse_step: 1.0 / step_s,
            near: max_jerk * step_s * step_s,
            value: 0.0,
            acceleration: 0.0,
        })
    }

    /// One step; returns the output.
    pub fn advance(&mut self, input: f64) -> f64 {
        let wanted = self.braking_acceleration(input - self.value);
        let change = wanted - self.acceleration;
        self.acceleration += change.clamp(-self.largest_change, self.largest_change);
        self.value += self.acceleration * self.step;
        self.value
    }

    /// The acceleration from which the velocity, with the largest change of acceleration in each step, ends without acceleration
    /// after a change of `missing`: a = n j h with n (n + 1)/2 j h² = |missing|.
    fn braking_acceleration(&self, missing: f64) -> f64 {
        let size = missing.abs();
        if size <= self.near {
            return missing * self.inverse_step;
        }
        let half = self.largest_change * 0.5;
        ((half * half + self.twice_jerk * size).sqrt() - half).copysign(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From rest to u in 2 √(u/j), half of it after half of that time, without overshoot.
    #[test]
    fn a_step_becomes_an_s_curve() {
        let (jerk, target, step) = (20.0, 0.02, 0.0001);
        let mut axis = JerkLimit::new(jerk, step).unwrap();
        let half_time = (target / jerk).sqrt();
        let steps = (half_time / step).round() as usize;
        let (mut last, mut rate) = (0.0, 0.0);
        for k in 1..=2 * steps + 2 {
            let v = axis.advance(target);
            let new_rate = (v - last) / step;
            assert!((new_rate - rate).abs() <= jerk * step * 1.01, "step {k}");
            assert!(v <= target + 1e-4, "step {k}: {v}");
            if k == steps {
                assert!((v - target / 2.0).abs() < 0.02 * target, "{v}");
            }
            (last, rate) = (v, new_rate);
        }
        assert!((last - target).abs() < 1e-4, "{last}");
    }
}
