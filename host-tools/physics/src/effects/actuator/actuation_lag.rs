//! First-order lag: velocity approaches its command exponentially.

use super::AxisStage;
use crate::effects::{
    Actuator, DelayAndLag, Effect, Group, Kind, Law, Naming, Parameter, check_step,
};
use nalgebra::ComplexField;
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "actuation_lag",
    title: "First-order lag",
    summary: "the executed velocity approaches the command exponentially",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "extra_lag_s dv/dt = u - v; exact for a held u: v(t+h) = u + (v(t) - u) exp(-h/extra_lag_s)",
    source: "textbook (first-order lag)",
    signature: "executed velocity is late by the time constant and its edges are rounded; a pure delay keeps \
                them sharp",
    typical: "2 to 30 ms: the bandwidth of the velocity loop",
    parameters: &[Parameter::new("extra_lag_s", "s", 0.0, 10.0)
        .delay_or_lag()
        .hidden(0.012, 0.022)
        .pictured(0.03)],
    confused_with: &[
        "actuation_delay",
        "second_order_servo",
        "rate_limit",
        "ft_low_pass",
    ],
    tell_apart: "a train of velocity steps that stand out of the noise, or a chirp of 1 to 60 Hz: after a step the distance to \
                 the command decays exponentially from the first instant on, behind a delay nothing happens at first",
    law: Law::Actuator(Actuator {
        axis: Some(|p, step_s| FirstOrderLag::new(p[0], step_s).map(AxisStage::Lag)),
        late: Some(|p| DelayAndLag {
            delay_s: 0.0,
            lag_s: p[0],
        }),
    }),
    kind: Some(Kind::LateCommand),
    ..Effect::PLAIN
};

/// First-order lag of one axis, exact for an input that is constant over a step.
#[derive(Clone, Copy, Debug)]
pub struct FirstOrderLag {
    /// exp(−h/T): what is left of the distance to the input after a step.
    remaining: f64,
    /// Mean of exp(−t/T) over the step: (1 − exp(−h/T)) T/h.
    mean_remaining: f64,
    value: f64,
}

impl FirstOrderLag {
    /// At rest. `time_constant_s` 0 (passes the input through) to 10 s, `step_s` in s.
    pub fn new(time_constant_s: f64, step_s: f64) -> Result<Self, SettingsError> {
        check_step(step_s)?;
        in_range("time_constant_s", time_constant_s, 0.0, 10.0)?;
        let (remaining, mean) = if time_constant_s < 1e-9 {
            (0.0, 0.0)
        } else {
            let remaining = ComplexField::exp(-step_s / time_constant_s);
            (remaining, (1.0 - remaining) * time_constant_s / step_s)
        };
        Ok(Self {
            remaining,
            mean_remaining: mean,
            value: 0.0,
        })
    }

    /// One step with constant input; returns the mean output over the step.
    pub fn advance(&mut self, input: f64) -> f64 {
        let distance = self.value - input;
        self.value = input + distance * self.remaining;
        input + distance * self.mean_remaining
    }

    /// Output at the end of the last step.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Continues from this output.
    pub fn reset(&mut self, value: f64) {
        self.value = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit step: v = 1 − exp(−t/T), travelled = t − T (1 − exp(−t/T)).
    #[test]
    fn unit_step_is_the_exponential() {
        let (time_constant, step) = (0.032, 0.0005);
        let mut lag = FirstOrderLag::new(time_constant, step).unwrap();
        let mut travelled = 0.0;
        for k in 1..=400 {
            travelled += step * lag.advance(1.0);
            let t = step * f64::from(k);
            let end = 1.0 - (-t / time_constant).exp();
            assert!((lag.value() - end).abs() < 1e-12);
            assert!((travelled - (t - time_constant * end)).abs() < 1e-12);
        }
    }

    #[test]
    fn without_time_constant_the_input_passes() {
        let mut lag = FirstOrderLag::new(0.0, 0.004).unwrap();
        assert_eq!((lag.advance(0.7), lag.value()), (0.7, 0.7));
    }
}
