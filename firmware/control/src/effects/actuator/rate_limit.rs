//! Acceleration limit of an axis.

use crate::effects::{Effect, OutOfRange, Parameter, in_range, step_in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "rate_limit",
    equation: "|dv/dt| <= max_acceleration_m_s2 (rad/s2 for a rotation); v follows its input otherwise",
    source: "robot data sheets; facts on delay compensation, section 5 (slew limits)",
    signature: "executed velocity has straight flanks of one slope where the command is steeper, and is \
                exact elsewhere",
    parameters: &[Parameter {
        name: "max_acceleration_m_s2",
        unit: "m/s^2",
        low: 0.05,
        high: 50.0,
    }],
};

/// Acceleration limit of one axis.
#[derive(Clone, Copy, Debug)]
pub struct RateLimit<S: Scalar> {
    largest_change: S,
    value: S,
}

impl<S: Scalar> RateLimit<S> {
    /// At rest. `max_acceleration` in m/s² (or rad/s²), above 0 to 1e6; `step_s` in s.
    pub fn new(max_acceleration: f64, step_s: f64) -> Result<Self, OutOfRange> {
        let limit = in_range("max_acceleration_m_s2", max_acceleration, 1e-6, 1e6)?;
        Ok(Self {
            largest_change: S::of(limit * step_in_range(step_s)?),
            value: S::zero(),
        })
    }

    /// One step; returns the output.
    pub fn advance(&mut self, input: S) -> S {
        let change = (input - self.value).clamp(-self.largest_change, self.largest_change);
        self.value += change;
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    fn flank<S: Scalar>() {
        let mut axis = RateLimit::<S>::new(0.5, 0.004).unwrap();
        for k in 1..=8 {
            let expected = (0.002 * f64::from(k)).min(0.01); // slope 0.5 up to the command
            assert!((axis.advance(S::of(0.01)).get() - expected).abs() < 1e-8);
        }
        assert!((axis.advance(S::of(0.0095)).get() - 0.0095).abs() < 1e-8);
    }

    #[test]
    fn flanks_have_the_slope_of_the_limit() {
        flank::<f64>();
        flank::<Fixed>();
    }
}
