//! Contact that stiffens with penetration.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_cubic",
    title: "Stiffening contact",
    summary: "the contact stiffens with the cube of the penetration",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = nominal push + stiffness_n_per_m3 pen^3",
    source: "textbook (Duffing spring)",
    signature: "force against penetration bends upwards; deep bounces are shorter and harder than shallow ones",
    typical: "10 to 50 % more force than linear at the deepest point, in rubber stops and coil springs near block",
    parameters: &[Parameter::new("stiffness_n_per_m3", "N/m^3", 0.0, 1e12)],
    confused_with: &["contact_stiffness", "contact_deadzone", "hunt_crossley"],
    tell_apart: "bounces of two depths: linear stiffness fitted to the deep one is too stiff for the shallow one; \
                 Hunt-Crossley damping opens a loop, a spring does not",
};

/// Cubic spring in addition to a linear one.
#[derive(Clone, Copy, Debug)]
pub struct CubicSpring<S: Scalar> {
    stiffness: S,
}

impl<S: Scalar> CubicSpring<S> {
    /// `stiffness_n_per_m3` 0 to 1e15 N/m³ (fixed point saturates above 1e9).
    pub fn new(stiffness_n_per_m3: f64) -> Result<Self, SettingsError> {
        in_range("stiffness_n_per_m3", stiffness_n_per_m3, 0.0, 1e15)?;
        Ok(Self {
            stiffness: S::of(stiffness_n_per_m3),
        })
    }

    /// Push (N) in addition to the nominal one, at a penetration (m); 0 outside.
    pub fn force(&self, penetration: S) -> S {
        let depth = penetration.max(S::zero());
        // From the left: the cube of a millimetre alone would vanish in fixed point.
        self.stiffness * depth * depth * depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    fn cube<S: Scalar>() {
        let spring = CubicSpring::<S>::new(3.5e7).unwrap();
        assert!((spring.force(S::of(0.004)).get() - 2.24).abs() < 1e-3);
        assert_eq!(spring.force(S::of(-0.004)).get(), 0.0);
    }

    #[test]
    fn four_millimetres() {
        cube::<f64>();
        cube::<Fixed>();
    }
}
