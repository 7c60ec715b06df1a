//! Coulomb friction in the plane of a contact, smoothed around standstill.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
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
        Parameter::new("friction_coefficient", "-", 0.0, 1.5)
            .hidden(0.15, 0.3)
            .pictured(0.3),
        Parameter::new("smoothing_speed_m_s", "m/s", 1e-4, 0.1)
            .form_size(&[1e-4, 3e-4, 1e-3, 3e-3, 1e-2], 1e-3)
            .hidden(1e-3, 1e-3)
            .pictured(0.001),
    ],
    confused_with: &["ft_crosstalk", "ft_mounting", "guide_coulomb"],
    tell_apart: "slide along the wall in both directions under the same push: friction changes its sign with the \
                 direction, cross-talk and a turned sensor do not; a guide's friction is there without contact too",
    law: Law::Friction(force),
    ..Effect::PLAIN
};

/// Across the normal and against the sliding velocity; below the smoothing speed it grows linearly
/// with it.
pub fn force(p: &[f64], push: f64, sliding: &Vector3<f64>) -> Vector3<f64> {
    sliding * (-p[0] * push / sliding.norm().hypot(p[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn size_is_mu_times_normal_force_against_the_motion() {
        let friction = |v: [f64; 3]| force(&[0.3, 0.001], 100.0, &v.into());
        let fast = friction([0.0, 0.06, -0.08]);
        assert!((fast.y + 18.0).abs() < 0.01 && (fast.z - 24.0).abs() < 0.01);
        let at_smoothing_speed = friction([0.001, 0.0, 0.0]);
        assert!((at_smoothing_speed.x + 30.0 / 2.0_f64.sqrt()).abs() < 1e-9);
        assert_eq!(friction([0.0; 3]), Vector3::zeros());
    }
}
