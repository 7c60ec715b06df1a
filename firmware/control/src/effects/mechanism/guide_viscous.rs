//! Viscous friction of a guide.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_viscous",
    title: "Viscous friction of the guide",
    summary: "the guide brakes in proportion to the velocity",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -damping_n_s_per_m v",
    source: "textbook (linear damper); measured on the EMPS axis (203 N s/m at 95 kg)",
    signature: "force against velocity is a straight line through zero, everywhere, not only in contact",
    typical: "10 to 300 N s/m for greased guides and seals",
    parameters: &[Parameter::new("damping_n_s_per_m", "N s/m", 0.0, 1e5)],
    confused_with: &[
        "guide_coulomb",
        "guide_stribeck",
        "manipulator_resistance",
        "contact_damping",
    ],
    tell_apart: "jogs at several speeds, far from the walls: the force grows in proportion to speed and there is \
                 none without speed; contact damping acts at the wall only",
};

/// Viscous friction along one axis.
#[derive(Clone, Copy, Debug)]
pub struct ViscousFriction<S: Scalar> {
    damping: S,
}

impl<S: Scalar> ViscousFriction<S> {
    /// `damping_n_s_per_m` 0 to 1e6 N·s/m.
    pub fn new(damping_n_s_per_m: f64) -> Result<Self, SettingsError> {
        in_range("damping_n_s_per_m", damping_n_s_per_m, 0.0, 1e6)?;
        Ok(Self {
            damping: S::of(damping_n_s_per_m),
        })
    }

    /// Force (N) at a velocity (m/s).
    pub fn force(&self, velocity: S) -> S {
        -self.damping * velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_zero() {
        let guide = ViscousFriction::<f64>::new(120.0).unwrap();
        assert_eq!(
            [-0.5, 0.0, 0.25].map(|v| guide.force(v)),
            [60.0, 0.0, -30.0]
        );
        assert!(ViscousFriction::<f64>::new(-1.0).is_err());
    }
}
