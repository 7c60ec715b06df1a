//! Friction of a guide that differs by direction, in its dry part, its viscous part, or both.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_asymmetry",
    title: "Friction that differs by direction",
    summary: "the guide brakes more in one direction than in the other",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -forward_n - d |v| for v > 0, +backward_n - d |v| for v < 0, with the viscous difference d",
    source: "measured on the EMPS axis (viscous friction 165 N·s/m forward, 244 N·s/m backward); textbook",
    signature: "two levels of force, as dry friction, or two slopes over the speed, but of different size",
    typical: "10 to 30 % difference of either part, from a preloaded seal, a sloping guide or a screw",
    parameters: &[
        Parameter::new("forward_n", "N", 0.0, 1e4),
        Parameter::new("backward_n", "N", 0.0, 1e4),
        // By how much the viscous friction of the guide is larger forward than its mean, and smaller
        // backward; a guide that brakes in both directions has a mean above its size.
        Parameter::new("viscous_difference_n_s_per_m", "N·s/m", -1e5, 1e5),
    ],
    confused_with: &["guide_coulomb", "guide_offset", "ft_bias"],
    tell_apart: "a pause between the jogs: at standstill an offset or a bias is still there, friction is not",
};

/// Dry friction with one level per direction, and the part of viscous friction that changes with
/// the direction.
#[derive(Clone, Copy, Debug)]
pub struct AsymmetricFriction<S: Scalar> {
    forward_n: S,
    backward_n: S,
    viscous_difference_n_s_per_m: S,
}

impl<S: Scalar> AsymmetricFriction<S> {
    /// `forward_n` (for positive velocity) and `backward_n`, each 0 to 1e5 N, and
    /// `viscous_difference_n_s_per_m`, −1e5 to 1e5 N·s/m: what viscous friction is larger forward,
    /// and smaller backward, than its mean, which is an effect of its own.
    pub fn new(
        forward_n: f64,
        backward_n: f64,
        viscous_difference_n_s_per_m: f64,
    ) -> Result<Self, SettingsError> {
        in_range("forward_n", forward_n, 0.0, 1e5)?;
        in_range("backward_n", backward_n, 0.0, 1e5)?;
        let difference = viscous_difference_n_s_per_m;
        in_range("viscous_difference_n_s_per_m", difference, -1e5, 1e5)?;
        Ok(Self {
            forward_n: S::of(forward_n),
            backward_n: S::of(backward_n),
            viscous_difference_n_s_per_m: S::of(difference),
        })
    }

    /// Force (N) at a velocity (m/s); 0 at standstill.
    pub fn force(&self, velocity: S) -> S {
        if velocity > S::zero() {
            -self.forward_n - self.viscous_difference_n_s_per_m * velocity
        } else if velocity < S::zero() {
            self.backward_n + self.viscous_difference_n_s_per_m * velocity
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
        let guide = AsymmetricFriction::<f64>::new(3.0, 2.0, 0.0).unwrap();
        assert_eq!([-0.1, 0.0, 0.1].map(|v| guide.force(v)), [2.0, 0.0, -3.0]);
    }

    /// Beside a viscous friction of 200 N·s/m, −40 N·s/m make 160 forward and 240 backward.
    #[test]
    fn one_slope_per_direction() {
        let guide = AsymmetricFriction::<f64>::new(0.0, 0.0, -40.0).unwrap();
        let force = |v: f64| guide.force(v) - 200.0 * v;
        assert_eq!([-0.5, 0.0, 0.5].map(force), [120.0, 0.0, -80.0]);
    }
}
