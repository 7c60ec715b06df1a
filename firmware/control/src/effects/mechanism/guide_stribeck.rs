//! Friction of a guide that is highest at low speed.

use crate::effects::{Effect, Group, Naming, Parameter, sign};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;
use nalgebra::ComplexField;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_stribeck",
    title: "Stribeck friction of the guide",
    summary: "dry friction that is higher at low speed, until the lubricant carries",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -(coulomb_n + excess_n exp(-(v/stribeck_speed_m_s)^2)) sign(v)",
    source: "Stribeck curve; Armstrong-Helouvry, Dupont and Canudas de Wit 1994 (Automatica 30)",
    signature: "force against velocity is a step at zero whose edges stand up: slow motion is braked more",
    typical: "excess of 20 to 100 % of the dry friction, gone above 1 to 20 mm/s",
    parameters: &[
        Parameter::new("coulomb_n", "N", 0.0, 1e4),
        Parameter::new("excess_n", "N", 0.0, 1e4),
        Parameter::new("stribeck_speed_m_s", "m/s", 1e-4, 0.1),
    ],
    confused_with: &["guide_coulomb", "guide_hysteresis", "zero_cross_pause"],
    tell_apart: "creep at a tenth of the usual speed: Stribeck friction is higher there; an excess that comes out \
                 negative is something else, as a hysteresis that still builds up",
};

/// Stribeck friction along one axis.
#[derive(Clone, Copy, Debug)]
pub struct StribeckFriction<S: Scalar> {
    coulomb_n: S,
    excess_n: S,
    inverse_speed: S,
}

impl<S: Scalar> StribeckFriction<S> {
    /// `coulomb_n` and `excess_n` 0 to 1e5 N, `stribeck_speed_m_s` 1e-4 to 10 m/s.
    pub fn new(
        coulomb_n: f64,
        excess_n: f64,
        stribeck_speed_m_s: f64,
    ) -> Result<Self, SettingsError> {
        in_range("coulomb_n", coulomb_n, 0.0, 1e5)?;
        in_range("excess_n", excess_n, 0.0, 1e5)?;
        in_range("stribeck_speed_m_s", stribeck_speed_m_s, 1e-4, 10.0)?;
        Ok(Self {
            coulomb_n: S::of(coulomb_n),
            excess_n: S::of(excess_n),
            inverse_speed: S::of(1.0 / stribeck_speed_m_s),
        })
    }

    /// Force (N) at a velocity (m/s); 0 at standstill.
    pub fn force(&self, velocity: S) -> S {
        // Six Stribeck speeds away nothing is left (2e-16): the square stays small in fixed point.
        let relative = (velocity * self.inverse_speed).clamp(S::of(-6.0), S::of(6.0));
        let left = S::of(ComplexField::exp(-(relative * relative).get()));
        -(self.coulomb_n + self.excess_n * left) * sign(velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Fixed;

    fn curve<S: Scalar>(tolerance: f64) {
        let guide = StribeckFriction::<S>::new(2.0, 1.5, 0.01).unwrap();
        let at = |v: f64| guide.force(S::of(v)).get();
        assert!((at(0.01) + 2.0 + 1.5 * (-1.0_f64).exp()).abs() < tolerance);
        assert!((at(-1e-5) - 3.5).abs() < 1e-4 && (at(3.0) + 2.0).abs() < 1e-8);
        assert_eq!(at(0.0), 0.0);
    }

    #[test]
    fn known_points_of_the_curve() {
        curve::<f64>(1e-12);
        curve::<Fixed>(1e-6);
    }

    #[test]
    fn a_negative_excess_is_refused() {
        let error = StribeckFriction::<f64>::new(2.0, -3.3, 0.01).unwrap_err();
        assert_eq!((error.field, error.received), ("excess_n", -3.3));
    }
}
