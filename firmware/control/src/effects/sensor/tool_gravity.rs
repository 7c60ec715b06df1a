//! Weight of the tool that hangs on the sensor: `F = m g`, `T = com × m g`, axes of S.
//!
//! Not an effect by itself but a part of the nominal wrench (seed paper section 3.2; A13: with the
//! centre of gravity as reference its torque term vanishes).

use crate::frames::{Wrench, vector};
use crate::range::{SettingsError, all_within, in_range};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// A tool with mass and centre of mass.
#[derive(Clone, Copy, Debug)]
pub struct ToolGravity<S: Scalar> {
    mass_kg: S,
    com: Vector3<S>,
}

impl<S: Scalar> ToolGravity<S> {
    /// `mass_kg` 0 to 1000; `com_m` from the sensor's origin, axes of S, each within ±10 m.
    pub fn new(mass_kg: f64, com_m: &[f64; 3]) -> Result<Self, SettingsError> {
        all_within("com_m", com_m, 10.0)?;
        in_range("mass_kg", mass_kg, 0.0, 1000.0)?;
        Ok(Self {
            mass_kg: S::of(mass_kg),
            com: vector(com_m),
        })
    }

    /// Wrench at S for gravity (m/s²) in axes of S.
    pub fn wrench(&self, gravity_in_s: &Vector3<S>) -> Wrench<S> {
        let force = gravity_in_s * self.mass_kg;
        Wrench {
            force,
            torque: self.com.cross(&force),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hanging_tool_pulls_down_and_tilts() {
        let tool = ToolGravity::<f64>::new(2.0, &[0.1, 0.0, 0.05]).unwrap();
        let w = tool.wrench(&Vector3::new(0.0, 0.0, -9.81)).get();
        for (got, expected) in w.iter().zip([0.0, 0.0, -19.62, 0.0, 1.962, 0.0]) {
            assert!((got - expected).abs() < 1e-12);
        }
    }
}
