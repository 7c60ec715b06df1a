//! Tool that is heavier or lighter than the model says.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::{Wrench, vector};
use crate::range::{SettingsError, all_within, in_range};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "tool_mass_error",
    title: "Mass of the tool",
    summary: "the tool on the sensor is heavier or lighter than nominal",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "dF = mass_error_kg g, dT = com x mass_error_kg g, g in axes of S; com: nominal centre of mass",
    source: "seed paper section 3.2 (gravity of the tool)",
    signature: "an offset of the force along gravity that turns with the sensor's orientation and does not depend \
                on motion",
    typical: "10 to 200 g: a cable, a screw set, an adapter that nobody weighed",
    parameters: &[Parameter::new("mass_error_kg", "kg", -20.0, 20.0)],
    confused_with: &["ft_bias", "tool_com_error", "ft_scale", "base_tilt"],
    tell_apart: "tilt the sensor by 90 deg or more without contact: the error of the weight turns with gravity, a \
                 bias does not; without tilting the two are the same",
};

/// Weight that the model does not know.
#[derive(Clone, Copy, Debug)]
pub struct ToolMassError<S: Scalar> {
    mass_error_kg: S,
    com: Vector3<S>,
}

impl<S: Scalar> ToolMassError<S> {
    /// `mass_error_kg` within ±1000 kg; nominal `com_m` from the sensor's origin, axes of S, each
    /// within ±10 m.
    pub fn new(mass_error_kg: f64, com_m: &[f64; 3]) -> Result<Self, SettingsError> {
        in_range("mass_error_kg", mass_error_kg, -1000.0, 1000.0)?;
        all_within("com_m", com_m, 10.0)?;
        Ok(Self {
            mass_error_kg: S::of(mass_error_kg),
            com: vector(com_m),
        })
    }

    /// Additional wrench at S for gravity (m/s²) in axes of S; where the model contains the tool's
    /// inertia, gravity minus the acceleration of its centre of mass.
    pub fn wrench(&self, gravity_in_s: &Vector3<S>) -> Wrench<S> {
        let force = gravity_in_s * self.mass_error_kg;
        Wrench {
            force,
            torque: self.com.cross(&force),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::sensor::tool_gravity::ToolGravity;

    /// The difference of two tools.
    #[test]
    fn it_is_the_difference_of_two_weights() {
        let (com, gravity) = ([0.01, -0.02, 0.1], Vector3::new(1.0, 2.0, -9.6));
        let weight = |mass| {
            ToolGravity::<f64>::new(mass, &com)
                .unwrap()
                .wrench(&gravity)
        };
        let expected = (weight(2.25) - weight(2.5)).get();
        let got = ToolMassError::<f64>::new(-0.25, &com).unwrap();
        for (got, expected) in got.wrench(&gravity).get().iter().zip(expected) {
            assert!((got - expected).abs() < 1e-12);
        }
    }
}
