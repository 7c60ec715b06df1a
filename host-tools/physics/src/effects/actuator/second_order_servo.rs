//! Under-damped second-order response between command and executed velocity.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter, check_step};
use nalgebra::ComplexField;
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "second_order_servo",
    title: "Second-order servo",
    summary: "the velocity loop responds as a damped second-order system",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "v'' + 2 damping_ratio w v' + w^2 v = w^2 u, w = 2 pi frequency_hz",
    source: "textbook (second-order servo)",
    signature: "executed velocity starts with a rounded foot and overshoots each change of command a little, once",
    typical: "5 to 30 Hz with a damping ratio of 0.5 to 0.9",
    parameters: &[
        Parameter::new("frequency_hz", "Hz", 0.01, 500.0)
            .hidden(11.0, 16.0)
            .pictured(8.0),
        Parameter::new("damping_ratio", "-", 0.3, 0.999)
            .hidden(0.5, 0.7)
            .pictured(0.5),
    ],
    confused_with: &[
        "actuation_lag",
        "actuation_delay",
        "structural_resonance",
        "jerk_limit",
    ],
    tell_apart: "a train of velocity steps of two heights: the overshoot scales with the step (a limit of \
                 acceleration or jerk does not scale), and a lag never overshoots",
    law: Law::Actuator(Actuator {
        axis: Some(|p, step_s| SecondOrderServo::new(p[0], p[1], step_s).map(AxisStage::Servo)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Second-order response of one axis, exact for an input that is constant over a step.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderServo {
    /// Transition of (v − u, v'/w) over a step; the rate is scaled by w to suit fixed point.
    transition: [[f64; 2]; 2],
    /// 1/(w h) and 2 ζ/(w h), for the mean over a step.
    inverse_phase: f64,
    damping_over_phase: f64,
    value: f64,
    scaled_rate: f64,
}

impl SecondOrderServo {
    /// At rest. `frequency_hz` (undamped natural frequency) 0.01 to 2000, `damping_ratio` 0 to 0.999, `step_s` in s.
    ///
    /// A critically or over-damped servo is a lag: use the first-order effect.
    pub fn new(frequency_hz: f64, damping_ratio: f64, step_s: f64) -> Result<Self, SettingsError> {
        check_step(step_s)?;
        in_range("frequency_hz", frequency_hz, 0.01, 2000.0)?;
        in_range("damping_ratio", damping_ratio, 0.0, 0.999)?;
        let zeta = damping_ratio;
        let phase = core::f64::consts::TAU * frequency_hz * step_s; // w h
        let damped = ComplexField::sqrt(1.0 - zeta * zeta); // w_d / w
        let (sin, cos) = ComplexField::sin_cos(damped * phase);
        let decay = ComplexField::exp(-zeta * phase);
        let (along, across) = (decay * cos, decay * sin / damped);
        Ok(Self {
            transition: [
                [(along + zeta * across), across],
                [-across, (along - zeta * across)],
            ],
            inverse_phase: 1.0 / phase,
            damping_over_phase: 2.0 * zeta / phase,
            value: 0.0,
            scaled_rate: 0.0,
        })
    }

    /// One step with constant input; returns the mean output over the step.
    ///
    /// The mean follows from the equation of motion itself, integrated over the step.
    pub fn advance(&mut self, input: f64) -> f64 {
        let [[a, b], [c, d]] = self.transition;
        let distance = self.value - input;
        let value = input + a * distance + b * self.scaled_rate;
        let rate = c * distance + d * self.scaled_rate;
        let mean = input
            - (rate - self.scaled_rate) * self.inverse_phase
            - (value - self.value) * self.damping_over_phase;
        (self.value, self.scaled_rate) = (value, rate);
        mean
    }

    /// Output at the end of the last step.
    pub fn value(&self) -> f64 {
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit step: v = 1 − e^{−ζwt} (cos w_d t + ζ w/w_d sin w_d t); its integral by fine sums.
    #[test]
    fn unit_step_is_the_decaying_oscillation() {
        let (frequency, zeta, step) = (20.0, 0.1_f64, 0.0005);
        let w = core::f64::consts::TAU * frequency;
        let wd = w * (1.0 - zeta * zeta).sqrt();
        let exact = |t: f64| {
            1.0 - (-zeta * w * t).exp() * ((wd * t).cos() + zeta * w / wd * (wd * t).sin())
        };
        let mut servo = SecondOrderServo::new(frequency, zeta, step).unwrap();
        let (mut travelled, mut expected) = (0.0, 0.0);
        for k in 0..400 {
            travelled += step * servo.advance(1.0);
            let t = step * f64::from(k);
            expected += step / 6.0 * (exact(t) + 4.0 * exact(t + step / 2.0) + exact(t + step));
            assert!((servo.value() - exact(t + step)).abs() < 1e-8);
            assert!((travelled - expected).abs() < 1e-8);
        }
    }

    #[test]
    fn over_damped_is_refused() {
        let error = SecondOrderServo::new(10.0, 1.2, 0.001).unwrap_err();
        assert_eq!((error.field, error.received), ("damping_ratio", 1.2));
    }
}
