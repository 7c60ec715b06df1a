//! Low-pass filter inside the sensor.

use crate::effects::actuator::actuation_lag::FirstOrderLag;
use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::Wrench;
use crate::range::SettingsError;
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_low_pass",
    title: "Low-pass filter of the sensor",
    summary: "a filter in the sensor rounds and delays the wrench",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "time_constant_s dW/dt = W_in - W; cut-off frequency 1/(2 pi time_constant_s)",
    source: "sensor manuals (first-order filter settings)",
    signature: "the wrench is late against penetration and its onset is rounded; a late robot delays the motion, \
                not the force",
    typical: "1 to 20 ms (8 to 150 Hz), set in the sensor's electronics",
    parameters: &[Parameter::new("time_constant_s", "s", 0.0, 0.1)],
    confused_with: &[
        "ft_latency",
        "contact_damping",
        "actuation_lag",
        "ft_dropout",
    ],
    tell_apart: "tap the sensor: a filter smears the tap, a latency shifts it; a damped contact is late only \
                 while it moves, a filter also after the motion has stopped",
};

/// First-order low-pass on all six axes.
#[derive(Clone, Copy, Debug)]
pub struct LowPass<S: Scalar> {
    axes: [FirstOrderLag<S>; 6],
}

impl<S: Scalar> LowPass<S> {
    /// At zero. `time_constant_s` 0 (passes the wrench through) to 10 s, `step_s` in s.
    pub fn new(time_constant_s: f64, step_s: f64) -> Result<Self, SettingsError> {
        let axis = FirstOrderLag::new(time_constant_s, step_s)?;
        Ok(Self { axes: [axis; 6] })
    }

    /// One step; returns the filtered wrench at its end.
    pub fn advance(&mut self, input: &Wrench<S>) -> Wrench<S> {
        let inputs = input.force.iter().chain(input.torque.iter());
        for (axis, value) in self.axes.iter_mut().zip(inputs) {
            axis.advance(*value);
        }
        self.value()
    }

    /// Continues as if `wrench` had been applied for a long time.
    pub fn settle(&mut self, wrench: &Wrench<S>) {
        let values = wrench.force.iter().chain(wrench.torque.iter());
        for (axis, value) in self.axes.iter_mut().zip(values) {
            axis.reset(*value);
        }
    }

    /// The filtered wrench.
    pub fn value(&self) -> Wrench<S> {
        let [a, b, c, d, e, f] = self.axes.map(|axis| axis.value());
        Wrench {
            force: [a, b, c].into(),
            torque: [d, e, f].into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_reaches_63_percent_after_the_time_constant() {
        let mut filter = LowPass::<f64>::new(0.01, 0.001).unwrap();
        let step = Wrench::of(&[1.0, 2.0, 0.0, 0.0, 0.0, -3.0]);
        for _ in 0..10 {
            filter.advance(&step);
        }
        let reached = 1.0 - (-1.0_f64).exp();
        for (got, expected) in filter.value().get().iter().zip(step.get()) {
            assert!((got - reached * expected).abs() < 1e-12);
        }
        filter.settle(&step);
        assert_eq!(filter.value(), step);
    }
}
