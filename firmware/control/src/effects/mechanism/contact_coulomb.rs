//! Coulomb friction in the plane of a contact, smoothed around standstill.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_coulomb",
    title: "Friction in the contact",
    summary: "dry friction across the contact's normal, proportional to the normal force",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F_t = -friction_coefficient N v_t / sqrt(v_t^2 + smoothing_speed_m_s^2)",
    source: "Coulomb's law, regularised by a smooth sign",
    signature: "a force across the contact's normal, proportional to the normal force, against the sliding, \
                independent of speed above the smoothing speed",
    typical: "0.1 to 0.3 between metals, 0.5 and more with rubber",
    parameters: &[
        Parameter::new("friction_coefficient", "-", 0.0, 1.5),
        Parameter::new("smoothing_speed_m_s", "m/s", 1e-4, 0.01),
    ],
    confused_with: &["ft_crosstalk", "ft_mounting", "guide_coulomb"],
    tell_apart: "slide along the wall in both directions under the same push: friction changes its sign with the \
                 direction, cross-talk and a turned sensor do not; a guide's friction is there without contact too",
};

/// Dry friction of a sliding point.
#[derive(Clone, Copy, Debug)]
pub struct CoulombFriction<S: Scalar> {
    coefficient: S,
    inverse_speed: S,
}

impl<S: Scalar> CoulombFriction<S> {
    /// `coefficient` 0 to 10; `smoothing_speed_m_s` 1e-4 to 1 m/s, below which friction grows
    /// linearly with speed. The lower bound keeps 1 m/s representable in fixed point.
    pub fn new(coefficient: f64, smoothing_speed_m_s: f64) -> Result<Self, SettingsError> {
        in_range("smoothing_speed_m_s", smoothing_speed_m_s, 1e-4, 1.0)?;
        in_range("friction_coefficient", coefficient, 0.0, 10.0)?;
        Ok(Self {
            coefficient: S::of(coefficient),
            inverse_speed: S::of(1.0 / smoothing_speed_m_s),
        })
    }

    /// Friction force (N) for a normal force (N, not negative) and a tangential velocity (m/s).
    pub fn force(&self, normal_force_n: S, tangential_velocity: &Vector3<S>) -> Vector3<S> {
        let relative = tangential_velocity * self.inverse_speed;
        let smooth = (S::one() + relative.norm_squared()).sqrt();
        relative * (-self.coefficient * normal_force_n / smooth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::vector;
    use crate::scalar::Fixed;

    fn slides<S: Scalar>(tolerance: f64) {
        let friction = CoulombFriction::<S>::new(0.3, 0.001).unwrap();
        let fast = friction.force(S::of(100.0), &vector(&[0.0, 0.06, -0.08]));
        assert!((fast.y.get() + 18.0).abs() < 0.01 && (fast.z.get() - 24.0).abs() < 0.01);
        let at_smoothing_speed = friction.force(S::of(100.0), &vector(&[0.001, 0.0, 0.0]));
        assert!((at_smoothing_speed.x.get() + 30.0 / 2.0_f64.sqrt()).abs() < tolerance);
        assert_eq!(friction.force(S::of(100.0), &Vector3::zeros()).x.get(), 0.0);
    }

    #[test]
    fn size_is_mu_times_normal_force_against_the_motion() {
        slides::<f64>(1e-9);
        slides::<Fixed>(1e-4);
    }
}
