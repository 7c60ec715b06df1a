//! Low-pass filter inside the sensor.

use crate::effects::actuator::first_order_lag::FirstOrderLag;
use crate::effects::{Effect, OutOfRange, Parameter, in_range};
use crate::frames::Wrench;
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_low_pass",
    equation: "dW/dt = 2 pi cutoff_hz (W_in - W)",
    source: "sensor manuals (first-order filter settings)",
    signature: "the wrench is late against penetration by 1/(2 pi cutoff_hz) and its onset is rounded; \
                a late robot delays the motion, not the force",
    parameters: &[Parameter {
        name: "cutoff_hz",
        unit: "Hz",
        low: 2.0,
        high: 1000.0,
    }],
};

/// First-order low-pass on all six axes.
#[derive(Clone, Copy, Debug)]
pub struct LowPass<S: Scalar> {
    axes: [FirstOrderLag<S>; 6],
}

impl<S: Scalar> LowPass<S> {
    /// At zero. `cutoff_hz` 0.1 to 1e5, `step_s` in s.
    pub fn new(cutoff_hz: f64, step_s: f64) -> Result<Self, OutOfRange> {
        let cutoff = in_range("cutoff_hz", cutoff_hz, 0.1, 1e5)?;
        let axis = FirstOrderLag::new(1.0 / (core::f64::consts::TAU * cutoff), step_s)?;
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
        let mut filter = LowPass::<f64>::new(1.0 / (std::f64::consts::TAU * 0.01), 0.001).unwrap();
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
