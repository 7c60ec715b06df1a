//! Zero offset of the sensor and its drift.

use crate::effects::{Effect, Parameter};
use crate::frames::Wrench;
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_bias_drift",
    equation: "W(t) = bias + drift_per_s t",
    source: "strain-gauge data sheets (zero drift with temperature)",
    signature: "a slow ramp of the wrench that depends on neither pose nor motion",
    parameters: &[
        Parameter {
            name: "drift_n_per_s",
            unit: "N/s",
            low: -1.0,
            high: 1.0,
        },
        Parameter {
            name: "drift_nm_per_s",
            unit: "N m/s",
            low: -0.1,
            high: 0.1,
        },
    ],
};

/// Offset at time 0 and its rate of change.
#[derive(Clone, Copy, Debug)]
pub struct BiasDrift<S: Scalar> {
    bias: Wrench<S>,
    drift_per_s: Wrench<S>,
}

impl<S: Scalar> BiasDrift<S> {
    /// `bias` in N and N·m, `drift_per_s` in N/s and N·m/s.
    pub fn new(bias: Wrench<S>, drift_per_s: Wrench<S>) -> Self {
        Self { bias, drift_per_s }
    }

    /// The offset at `time_s`.
    pub fn at(&self, time_s: S) -> Wrench<S> {
        self.bias + self.drift_per_s * time_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_ramp() {
        let drift = BiasDrift::<f64>::new(
            Wrench::of(&[1.0; 6]),
            Wrench::of(&[0.5, 0.0, 0.0, 0.0, 0.0, -0.25]),
        );
        assert_eq!(drift.at(4.0).get(), [3.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
    }
}
