//! Resistance of the manipulator that holds the simulated spacecraft.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "manipulator_resistance",
    title: "Resistance of a space manipulator",
    summary: "the rig's model moves against the spring and damper of a manipulator",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -(stiffness_n_per_m (p - p0) + damping_n_s_per_m v), added to the force on the simulated spacecraft",
    source: "seed paper section 3.2 (equivalent resistance of the space manipulator); textbook (spring and damper)",
    signature: "the rig's model decelerates without a measured force; sensor and executed velocity fit their models",
    typical: "1 to 100 N/m and N s/m for a compliant arm of some metres",
    parameters: &[
        Parameter::new("stiffness_n_per_m", "N/m", 0.0, 1e5),
        Parameter::new("damping_n_s_per_m", "N s/m", 0.0, 1e5),
    ],
    confused_with: &["guide_viscous", "cable_stiffness", "sc_mass_error"],
    tell_apart: "look at the sensor in free flight: a guide or a cable on the rig is measured there, a resistance \
                 inside the model is not",
};

/// Spring and damper between the simulated spacecraft and where it began.
#[derive(Clone, Copy, Debug)]
pub struct ManipulatorResistance<S: Scalar> {
    stiffness: S,
    damping: S,
}

impl<S: Scalar> ManipulatorResistance<S> {
    /// `stiffness_n_per_m` 0 to 1e6 N/m, `damping_n_s_per_m` 0 to 1e6 N·s/m.
    pub fn new(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Result<Self, SettingsError> {
        in_range("stiffness_n_per_m", stiffness_n_per_m, 0.0, 1e6)?;
        in_range("damping_n_s_per_m", damping_n_s_per_m, 0.0, 1e6)?;
        Ok(Self {
            stiffness: S::of(stiffness_n_per_m),
            damping: S::of(damping_n_s_per_m),
        })
    }

    /// Force (N) on the spacecraft at a displacement (m) from the start and a velocity (m/s).
    pub fn force(&self, displacement: S, velocity: S) -> S {
        -(self.stiffness * displacement + self.damping * velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spring_and_damper_add() {
        let arm = ManipulatorResistance::<f64>::new(8.0, 16.0).unwrap();
        assert_eq!(arm.force(0.5, -0.125), -2.0);
        assert!(ManipulatorResistance::<f64>::new(8.0, -1.0).is_err());
    }
}
