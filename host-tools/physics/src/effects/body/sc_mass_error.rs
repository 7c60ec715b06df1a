//! Mass with which the rig integrates the spacecraft.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use nalgebra::Vector3;
use softdock_control::frames::saturated;
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "sc_mass_error",
    title: "Mass of the spacecraft",
    summary: "the rig integrates with another mass of the spacecraft than the model says",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "a = F / (m + mass_error_kg), m: nominal mass",
    source: "Newton's second law",
    signature: "the rig's model accelerates by a wrong factor under every force, in all directions alike",
    typical: "nothing, or the difference of two versions of a settings file",
    parameters: &[Parameter::new("mass_error_kg", "kg", -1000.0, 1000.0)
        .hidden(15.0, 35.0)
        .either_sign()
        .pictured(25.0)],
    confused_with: &[
        "ft_scale",
        "sc_inertia_error",
        "manipulator_resistance",
        "contact_stiffness",
    ],
    tell_apart: "compare the rig's model with the logged force: with a wrong mass the logged force fits the \
                 contact; with a wrong gain of the sensor it does not",
    law: Law::Spacecraft,
    ..Effect::PLAIN
};

/// Largest acceleration, m/s²: keeps a light spacecraft under a large force representable.
const LARGEST_M_S2: f64 = 1e4;

/// A spacecraft with a wrong mass.
#[derive(Clone, Copy, Debug)]
pub struct MassError {
    inverse_mass: f64,
}

impl MassError {
    /// Nominal `mass_kg` and its error; the sum has to lie in 0.1 to 1e6 kg.
    pub fn new(mass_kg: f64, mass_error_kg: f64) -> Result<Self, SettingsError> {
        in_range("mass_error_kg", mass_kg + mass_error_kg, 0.1, 1e6)?;
        Ok(Self {
            inverse_mass: 1.0 / (mass_kg + mass_error_kg),
        })
    }

    /// Acceleration (m/s²) under a force (N).
    pub fn acceleration(&self, force: &Vector3<f64>) -> Vector3<f64> {
        saturated(&(force * self.inverse_mass), LARGEST_M_S2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heavier_spacecraft_accelerates_less() {
        let spacecraft = MassError::new(60.0, 20.0).unwrap();
        let got = spacecraft.acceleration(&Vector3::new(8.0, 0.0, -16.0));
        assert!((got - Vector3::new(0.1, 0.0, -0.2)).norm() < 1e-12);
        assert!(MassError::new(60.0, -60.0).is_err());
    }
}
