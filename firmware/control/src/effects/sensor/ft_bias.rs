//! Zero offset of the sensor.

use super::{OFFSET, offset};
use crate::effects::{Effect, Group, Naming};
use crate::frames::Wrench;
use crate::range::SettingsError;
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_bias",
    title: "Zero offset of the sensor",
    summary: "the wrench has a constant offset in the sensor's axes",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W = W_nominal + (fx_n, fy_n, fz_n, tx_n_m, ty_n_m, tz_n_m)",
    source: "strain-gauge data sheets (zero balance)",
    signature: "a constant error of the wrench from the first sample to the last, whatever pose and motion",
    typical: "0.1 to 5 N and 0.01 to 0.5 N m after a warm-up without zeroing",
    parameters: OFFSET,
    confused_with: &[
        "ft_bias_drift",
        "tool_mass_error",
        "base_tilt",
        "guide_offset",
    ],
    tell_apart: "hold the sensor in two opposite orientations without contact: the bias is the mean of the two \
                 readings, the weight half of their difference",
};

/// Constant offset.
#[derive(Clone, Copy, Debug)]
pub struct Bias<S: Scalar> {
    offset: Wrench<S>,
}

impl<S: Scalar> Bias<S> {
    /// Offset fx fy fz (N) tx ty tz (N·m), each within ±1e5.
    pub fn new(components: &[f64; 6]) -> Result<Self, SettingsError> {
        Ok(Self {
            offset: offset(components)?,
        })
    }

    /// What the sensor reads of a wrench.
    pub fn apply(&self, wrench: &Wrench<S>) -> Wrench<S> {
        *wrench + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_adds() {
        let sensor = Bias::<f64>::new(&[1.0, 0.0, 0.0, 0.0, 0.0, -2.0]).unwrap();
        let got = sensor.apply(&Wrench::of(&[0.5; 6])).get();
        assert_eq!(got, [1.5, 0.5, 0.5, 0.5, 0.5, -1.5]);
        assert!(Bias::<f64>::new(&[f64::INFINITY; 6]).is_err());
    }
}
