//! A constant force along the guide.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_offset",
    title: "Constant force along the guide",
    summary: "a constant force pulls the moving side in one direction",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = force_n, along the guide, whatever the motion",
    source: "measured on the EMPS axis (-3.2 N); a sloping guide or a counterweight acts so",
    signature: "the force along the guide is shifted by a constant at all times, also at standstill",
    typical: "some N; 1 N is a slope of 0.6 deg for 10 kg",
    parameters: &[Parameter::new("force_n", "N", -1e4, 1e4)],
    confused_with: &["ft_bias", "guide_asymmetry", "base_tilt", "cable_stiffness"],
    tell_apart: "turn the sensor: the bias stays in the sensor's axes, the force stays in the guide's; a cable \
                 pulls differently at each position",
};

/// A force that nothing changes.
#[derive(Clone, Copy, Debug)]
pub struct ConstantForce<S: Scalar> {
    force_n: S,
}

impl<S: Scalar> ConstantForce<S> {
    /// `force_n` within ±1e5 N.
    pub fn new(force_n: f64) -> Result<Self, SettingsError> {
        in_range("force_n", force_n, -1e5, 1e5)?;
        Ok(Self {
            force_n: S::of(force_n),
        })
    }

    /// Force, N.
    pub fn force(&self) -> S {
        self.force_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stands() {
        assert_eq!(ConstantForce::<f64>::new(-3.2).unwrap().force(), -3.2);
        assert!(ConstantForce::<f64>::new(f64::NAN).is_err());
    }
}
