//! Lightly damped structural mode between command and executed velocity.
//!
//! The equation is that of [`SecondOrderServo`], which computes it; only the plausible damping differs, and with it the cause: joints, flange and tool
//! that swing, instead of a velocity loop that responds.

use super::AxisStage;
use super::second_order_servo::SecondOrderServo;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "structural_resonance",
    title: "Structural resonance",
    summary: "a lightly damped structural mode swings between command and executed velocity",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "v'' + 2 damping_ratio w v' + w^2 v = w^2 u, w = 2 pi frequency_hz, damping_ratio < 0.5",
    source: "textbook (robot joint elasticity, flange and tool as one mode)",
    signature: "executed velocity overshoots and rings at one frequency after each change of command; its \
                spectrum has a peak where delay and lag have none",
    typical: "8 to 40 Hz with a damping ratio of 0.02 to 0.1 for an arm with a tool",
    parameters: &[
        Parameter::new("frequency_hz", "Hz", 0.05, 500.0)
            .hidden(9.0, 16.0)
            .pictured(14.0),
        Parameter::new("damping_ratio", "-", 0.005, 0.5)
            .hidden(0.02, 0.08)
            .pictured(0.06),
    ],
    confused_with: &["second_order_servo", "actuation_lag", "jerk_limit"],
    tell_apart: "a velocity step and some seconds of rest, or a chirp of 1 to 60 Hz: a mode rings on for many \
                 periods, a servo for one",
    law: Law::Actuator(Actuator {
        axis: Some(|p, step_s| SecondOrderServo::new(p[0], p[1], step_s).map(AxisStage::Servo)),
        late: None,
    }),
    ..Effect::PLAIN
};

#[cfg(test)]
mod tests {
    use crate::effects::actuator::second_order_servo::SecondOrderServo;

    /// Half a period after a step the velocity overshoots by exp(−π ζ/√(1 − ζ²)).
    #[test]
    fn overshoot_of_a_lightly_damped_mode() {
        let (frequency, zeta, step) = (10.0, 0.05_f64, 0.0005);
        let mut mode = SecondOrderServo::new(frequency, zeta, step).unwrap();
        let peak = (0..200).fold(0.0_f64, |peak, _| {
            mode.advance(1.0);
            peak.max(mode.value())
        });
        let overshoot = (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        assert!((peak - 1.0 - overshoot).abs() < 1e-3, "{peak} {overshoot}");
    }
}
