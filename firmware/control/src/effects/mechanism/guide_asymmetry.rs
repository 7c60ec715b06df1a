//! Dry friction of a guide that differs by direction.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_asymmetry",
    title: "Dry friction that differs by direction",
    summary: "the guide brakes more in one direction than in the other",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -forward_n for v > 0, +backward_n for v < 0",
    source: "measured on the EMPS axis (Coulomb friction with an offset of 3.2 N); textbook",
    signature: "two levels of force, as dry friction, but of different size",
    typical: "10 to 30 % difference, from a preloaded seal or a sloping guide",
    parameters: &[
        Parameter::new("forward_n", "N", 0.0, 100.0),
        Parameter::new("backward_n", "N", 0.0, 100.0),
    ],
    confused_with: &["guide_coulomb", "guide_offset", "ft_bias"],
    tell_apart: "a pause between the jogs: at standstill an offset or a bias is still there, friction is not",
};

/// Dry friction with one level per direction.
#[derive(Clone, Copy, Debug)]
pub struct AsymmetricFriction<S: Scalar> {
    forward_n: S,
    backward_n: S,
}

impl<S: Scalar> AsymmetricFriction<S> {
    /// `forward_n` (for positive velocity) and `backward_n`, each 0 to 1e5 N.
    pub fn new(forward_n: f64, backward_n: f64) -> Result<Self, SettingsError> {
        in_range("forward_n", forward_n, 0.0, 1e5)?;
        in_range("backward_n", backward_n, 0.0, 1e5)?;
        Ok(Self {
            forward_n: S::of(forward_n),
            backward_n: S::of(backward_n),
        })
    }

    /// Force (N) at a velocity (m/s); 0 at standstill.
    pub fn force(&self, velocity: S) -> S {
        if velocity > S::zero() {
            -self.forward_n
        } else if velocity < S::zero() {
            self.backward_n
        } else {
            S::zero()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_level_per_direction() {
        let guide = AsymmetricFriction::<f64>::new(3.0, 2.0).unwrap();
        assert_eq!([-0.1, 0.0, 0.1].map(|v| guide.force(v)), [2.0, 0.0, -3.0]);
    }
}
