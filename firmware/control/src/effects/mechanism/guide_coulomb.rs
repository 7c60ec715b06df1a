//! Dry friction of a guide.

use crate::effects::{Effect, Group, Naming, Parameter, sign};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_coulomb",
    title: "Dry friction of the guide",
    summary: "the guide brakes with a constant force against the motion",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -force_n sign(v)",
    source: "Coulomb's law; measured on the EMPS axis (20.4 N at 95 kg)",
    signature: "force against velocity is a step at zero: two levels, the same at every speed and without contact",
    typical: "0.3 to 20 N, 2 % of the moved weight on ball guides",
    parameters: &[Parameter::new("force_n", "N", 0.0, 1e4)],
    confused_with: &[
        "guide_stribeck",
        "guide_asymmetry",
        "guide_viscous",
        "guide_hysteresis",
    ],
    tell_apart: "jogs at several speeds in both directions: dry friction stays the same, viscous friction grows \
                 with speed, Stribeck friction falls with it, hysteresis needs a distance to build up",
};

/// Dry friction along one axis.
#[derive(Clone, Copy, Debug)]
pub struct DryFriction<S: Scalar> {
    force_n: S,
}

impl<S: Scalar> DryFriction<S> {
    /// `force_n` 0 to 1e5 N.
    pub fn new(force_n: f64) -> Result<Self, SettingsError> {
        in_range("force_n", force_n, 0.0, 1e5)?;
        Ok(Self {
            force_n: S::of(force_n),
        })
    }

    /// Force (N) at a velocity (m/s); 0 at standstill, where friction is undetermined.
    pub fn force(&self, velocity: S) -> S {
        -self.force_n * sign(velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_levels() {
        let guide = DryFriction::<f64>::new(2.0).unwrap();
        assert_eq!([-0.1, 0.0, 1e-9].map(|v| guide.force(v)), [2.0, 0.0, -2.0]);
        assert_eq!(DryFriction::<f64>::new(-2.0).unwrap_err().field, "force_n");
    }
}
