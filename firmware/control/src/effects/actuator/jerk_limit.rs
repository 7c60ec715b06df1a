//! Jerk limit of an axis: its acceleration changes no faster than this.

use crate::effects::{Effect, Group, Naming, Parameter, check_step};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

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
    typical: "10 to 200 m/s^3 at the flange",
    parameters: &[Parameter::new("max_jerk_m_s3", "m/s^3", 0.5, 1000.0)],
    confused_with: &[
        "rate_limit",
        "second_order_servo",
        "actuation_lag",
        "actuation_delay",
    ],
    tell_apart: "velocity steps of two heights, one four times the other: a jerk limit takes twice the time, an \
                 acceleration limit four times, a lag or a servo the same",
};

/// Jerk limit of one axis.
///
/// While the input stands, the axis reaches it in the shortest time that the limit allows.
#[derive(Clone, Copy, Debug)]
pub struct JerkLimit<S: Scalar> {
    /// Largest change of the acceleration in a step.
    largest_change: S,
    twice_jerk: S,
    step: S,
    inverse_step: S,
    /// Distance that is covered in one step without having to brake.
    near: S,
    value: S,
    acceleration: S,
}

impl<S: Scalar> JerkLimit<S> {
    /// At rest. `max_jerk` in m/s³ (or rad/s³), 1e-3 to 1e6; `step_s` in s.
    pub fn new(max_jerk: f64, step_s: f64) -> Result<Self, SettingsError> {
        in_range("max_jerk_m_s3", max_jerk, 1e-3, 1e6)?;
        check_step(step_s)?;
        Ok(Self {
            largest_change: S::of(max_jerk * step_s),
            twice_jerk: S::of(2.0 * max_jerk),
            step: S::of(step_s),
            inverse_step: S::of(1.0 / step_s),
            near: S::of(max_jerk * step_s * step_s),
            value: S::zero(),
            acceleration: S::zero(),
        })
    }

    /// One step; returns the output.
    pub fn advance(&mut self, input: S) -> S {
        let wanted = self.braking_acceleration(input - self.value);
        let change = wanted - self.acceleration;
        self.acceleration += change.clamp(-self.largest_change, self.largest_change);
        self.value += self.acceleration * self.step;
        self.value
    }

    /// The acceleration from which whole steps of largest change end at rest after `missing`:
    /// a = n j h with n (n + 1)/2 j h² = |missing|.
    fn braking_acceleration(&self, missing: S) -> S {
        let size = missing.abs();
        if size <= self.near {
            return missing * self.inverse_step;
        }
        let half = self.largest_change * S::of(0.5);
        ((half * half + self.twice_jerk * size).sqrt() - half).copysign(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    /// From rest to u in 2 √(u/j), half of it at half of the time, without overshoot.
    fn s_curve<S: Scalar>(tolerance: f64) {
        let (jerk, target, step) = (20.0, 0.02, 0.0001);
        let mut axis = JerkLimit::<S>::new(jerk, step).unwrap();
        let half_time = (target / jerk).sqrt();
        let steps = (half_time / step).round() as usize;
        let (mut last, mut rate) = (0.0, 0.0);
        for k in 1..=2 * steps + 2 {
            let v = axis.advance(S::of(target)).get();
            let new_rate = (v - last) / step;
            assert!((new_rate - rate).abs() <= jerk * step * 1.01, "step {k}");
            assert!(v <= target + tolerance, "step {k}: {v}");
            if k == steps {
                assert!((v - target / 2.0).abs() < 0.02 * target, "{v}");
            }
            (last, rate) = (v, new_rate);
        }
        assert!((last - target).abs() < tolerance, "{last}");
    }

    #[test]
    fn a_step_becomes_an_s_curve() {
        s_curve::<f64>(1e-4);
        s_curve::<Fixed>(1e-4);
    }
}
