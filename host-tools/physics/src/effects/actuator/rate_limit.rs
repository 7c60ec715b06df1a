//! Acceleration limit of an axis.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter, check_step};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "rate_limit",
    title: "Acceleration limit",
    summary: "the acceleration of the executed velocity is limited",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "|dv/dt| <= max_acceleration_m_s2 (rad/s^2 for a rotation); v follows its input otherwise",
    source: "robot data sheets (acceleration of an axis); textbook (slew limit)",
    signature: "executed velocity has straight flanks of one slope where the command is steeper, and is exact \
                elsewhere",
    typical: "0.5 to 10 m/s^2 at the flange",
    parameters: &[
        Parameter::new("max_acceleration_m_s2", "m/s^2", 1e-3, 1000.0)
            .hidden(0.4, 0.8)
            .pictured(0.4),
    ],
    confused_with: &[
        "actuation_lag",
        "actuation_delay",
        "jerk_limit",
        "velocity_saturation",
    ],
    tell_apart: "velocity steps of two heights: the time of the flank grows with the height, that of a lag or a \
                 delay does not",
    law: Law::Actuator(Actuator {
        axis: Some(|p, step_s| RateLimit::new(p[0], step_s).map(AxisStage::Rate)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Acceleration limit of one axis.
#[derive(Clone, Copy, Debug)]
pub struct RateLimit {
    largest_change: f64,
    value: f64,
}

impl RateLimit {
    /// At rest. `max_acceleration` in m/s² (or rad/s²), above 0 to 1e6; `step_s` in s.
    pub fn new(max_acceleration: f64, step_s: f64) -> Result<Self, SettingsError> {
        in_range("max_acceleration_m_s2", max_acceleration, 1e-6, 1e6)?;
        check_step(step_s)?;
        Ok(Self {
            largest_change: max_acceleration * step_s,
            value: 0.0,
        })
    }

    /// One step; returns the output.
    pub fn advance(&mut self, input: f64) -> f64 {
        let change = (input - self.value).clamp(-self.largest_change, self.largest_change);
        self.value += change;
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flanks_have_the_slope_of_the_limit() {
        let mut axis = RateLimit::new(0.5, 0.004).unwrap();
        for k in 1..=8 {
            let expected = (0.002 * f64::from(k)).min(0.01); // slope 0.5 up to the command
            assert!((axis.advance(0.01) - expected).abs() < 1e-8);
        }
        assert!((axis.advance(0.0095) - 0.0095).abs() < 1e-8);
    }
}
