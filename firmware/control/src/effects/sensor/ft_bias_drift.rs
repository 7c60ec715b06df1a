//! Drift of the sensor's zero.

use super::{OFFSET, offset};
use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::Wrench;
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;
use nalgebra::ComplexField;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_bias_drift",
    title: "Drift of the sensor's zero",
    summary: "the zero of the wrench creeps to a new value",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W(t) = W_nominal + (fx_n, .., tz_n_m) (1 - exp(-t/time_constant_s)), t from the last zeroing",
    source: "strain-gauge data sheets (drift of the zero with temperature); first-order warming",
    signature: "a slow bend of the wrench that depends on neither pose nor motion; over a short log it is a ramp",
    typical: "0.5 to 3 N over some seconds to minutes after the load or the temperature has changed",
    parameters: &[
        OFFSET[0],
        OFFSET[1],
        OFFSET[2],
        OFFSET[3],
        OFFSET[4],
        OFFSET[5],
        Parameter::new("time_constant_s", "s", 0.1, 1000.0),
    ],
    confused_with: &["ft_bias", "cable_stiffness", "tool_mass_error"],
    tell_apart: "a long log at standstill: only drift changes there; a cable needs motion",
};

/// Offset that is approached exponentially.
#[derive(Clone, Copy, Debug)]
pub struct BiasDrift<S: Scalar> {
    last: Wrench<S>,
    rate_per_s: f64,
}

impl<S: Scalar> BiasDrift<S> {
    /// `last`: offset after a long time, fx fy fz (N) tx ty tz (N·m), each within ±1e5;
    /// `time_constant_s` 1e-3 to 1e6 s.
    pub fn new(last: &[f64; 6], time_constant_s: f64) -> Result<Self, SettingsError> {
        in_range("time_constant_s", time_constant_s, 1e-3, 1e6)?;
        Ok(Self {
            last: offset(last)?,
            rate_per_s: 1.0 / time_constant_s,
        })
    }

    /// The offset `time_s` after the last zeroing; 0 before it.
    pub fn at(&self, time_s: f64) -> Wrench<S> {
        let left = ComplexField::exp(-time_s.max(0.0) * self.rate_per_s);
        self.last * S::of(1.0 - left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_creeps_to_its_last_value() {
        let last = [1.0, 0.0, 0.0, 0.0, 0.0, -2.0];
        let sensor = BiasDrift::<f64>::new(&last, 4.0).unwrap();
        assert_eq!(sensor.at(0.0).get(), [0.0; 6]);
        let reached = 1.0 - (-1.0_f64).exp();
        assert!((sensor.at(4.0).force.x - reached).abs() < 1e-12);
        assert!((sensor.at(400.0).torque.z + 2.0).abs() < 1e-12);
    }
}
