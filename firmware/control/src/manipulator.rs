//! Resistance of the manipulator that holds the simulated spacecraft (seed paper section 3.2).

use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Spring and damper between the simulated spacecraft and its initial position.
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
