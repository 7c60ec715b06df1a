//! Gain of the sensor's axes.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::Wrench;
use crate::range::{SettingsError, all_within};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "ft_scale",
    title: "Gain of the sensor",
    summary: "each axis of the wrench reads too much or too little by a factor",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W_i = (1 + i) W_nominal,i for i = fx fy fz tx ty tz",
    source: "strain-gauge data sheets (error of full scale)",
    signature: "the error of an axis is proportional to what it reads, in contact as in tilting",
    typical: "0.5 to 2 %; a wrong calibration file is off by 10 % and more",
    parameters: &[
        Parameter::new("fx", "-", -0.3, 0.3),
        Parameter::new("fy", "-", -0.3, 0.3),
        Parameter::new("fz", "-", -0.3, 0.3),
        Parameter::new("tx", "-", -0.3, 0.3),
        Parameter::new("ty", "-", -0.3, 0.3),
        Parameter::new("tz", "-", -0.3, 0.3),
    ],
    confused_with: &[
        "contact_stiffness",
        "tool_mass_error",
        "ft_crosstalk",
        "ft_saturation",
    ],
    tell_apart: "hang known weights on the sensor: a gain shows there too, a wrong stiffness only in contact; with \
                 the gain of one axis wrong the weight of the tool seems to depend on the orientation",
};

/// Gains of the axes fx fy fz tx ty tz.
#[derive(Clone, Copy, Debug)]
pub struct Scale<S: Scalar> {
    gain: Wrench<S>,
}

impl<S: Scalar> Scale<S> {
    /// Relative gain errors fx fy fz tx ty tz, each −1 (reads nothing) to 1 (reads twice).
    pub fn new(gain_error: &[f64; 6]) -> Result<Self, SettingsError> {
        all_within("fx .. tz", gain_error, 1.0)?;
        Ok(Self {
            gain: Wrench::of(&gain_error.map(|error| 1.0 + error)),
        })
    }

    /// What the sensor reads of a wrench.
    pub fn apply(&self, wrench: &Wrench<S>) -> Wrench<S> {
        Wrench {
            force: wrench.force.component_mul(&self.gain.force),
            torque: wrench.torque.component_mul(&self.gain.torque),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_axis_has_its_gain() {
        let sensor = Scale::<f64>::new(&[0.5, 0.0, -0.25, 0.0, 0.0, 1.0]).unwrap();
        let got = sensor.apply(&Wrench::of(&[2.0; 6])).get();
        assert_eq!(got, [3.0, 2.0, 1.5, 2.0, 2.0, 4.0]);
    }
}
