//! Tool whose centre of mass lies elsewhere than the model says.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::frames::{Wrench, vector};
use crate::range::{SettingsError, all_within, in_range};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "tool_com_error",
    title: "Centre of mass of the tool",
    summary: "the tool's centre of mass lies elsewhere than nominal",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "dF = 0, dT = (com_x_m, com_y_m, com_z_m) x m g, g in axes of S; m: nominal mass",
    source: "seed paper section 3.2 (gravity of the tool)",
    signature: "torques that turn with the sensor's orientation, while the forces fit",
    typical: "0.5 to 10 mm; 1 mm at 10 kg is 0.1 N m",
    parameters: &[
        Parameter::new("com_x_m", "m", -0.2, 0.2),
        Parameter::new("com_y_m", "m", -0.2, 0.2),
        Parameter::new("com_z_m", "m", -0.2, 0.2),
    ],
    confused_with: &["tool_mass_error", "ft_crosstalk", "ft_bias", "base_tilt"],
    tell_apart: "tilt the sensor about two axes without contact: no torque about gravity, and none of the forces \
                 is touched; cross-talk follows the forces of a contact too",
};

/// Lever that the model does not know.
#[derive(Clone, Copy, Debug)]
pub struct ToolComError<S: Scalar> {
    com_error: Vector3<S>,
    mass_kg: S,
}

impl<S: Scalar> ToolComError<S> {
    /// `com_error_m` in axes of S, each within ±10 m; nominal `mass_kg` 0 to 1000.
    pub fn new(com_error_m: &[f64; 3], mass_kg: f64) -> Result<Self, SettingsError> {
        all_within("com_x_m, com_y_m, com_z_m", com_error_m, 10.0)?;
        in_range("mass_kg", mass_kg, 0.0, 1000.0)?;
        Ok(Self {
            com_error: vector(com_error_m),
            mass_kg: S::of(mass_kg),
        })
    }

    /// Additional wrench at S for gravity (m/s²) in axes of S.
    pub fn wrench(&self, gravity_in_s: &Vector3<S>) -> Wrench<S> {
        Wrench {
            force: Vector3::zeros(),
            torque: self.com_error.cross(&(gravity_in_s * self.mass_kg)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lever_of_one_millimetre() {
        let tool = ToolComError::<f64>::new(&[0.001, 0.0, 0.0], 10.0).unwrap();
        let got = tool.wrench(&Vector3::new(0.0, 0.0, -9.81)).get();
        for (got, expected) in got.iter().zip([0.0, 0.0, 0.0, 0.0, 0.0981, 0.0]) {
            assert!((got - expected).abs() < 1e-12);
        }
    }
}
