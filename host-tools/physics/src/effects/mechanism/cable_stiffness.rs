//! A spring that pulls the moving side back, as a cable bundle does.

use super::{ABOUT_START, ACTS_AT};
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use nalgebra::Vector3;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "cable_stiffness",
    title: "Restoring spring, as of cables",
    summary: "a spring or cable bundle pulls the moving side back to where it rests",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -(stiffness_n_per_m + hardening_n_per_m3 |d|^2) d, d = p - p0; p0: position at the start or 0",
    source: "Hooke's law; Duffing 1918 for the cube; hose packages of robots",
    signature: "a force that follows position, everywhere, not only in contact; bent where the spring hardens",
    typical: "10 to 200 N/m for sensor and hose bundles",
    parameters: &[
        Parameter::new("stiffness_n_per_m", "N/m", 0.0, 1e7)
            .hidden(40.0, 100.0)
            .pictured(150.0),
        Parameter::new("hardening_n_per_m3", "N/m^3", 0.0, 1e12),
        ABOUT_START,
        ACTS_AT,
    ],
    confused_with: &[
        "manipulator_resistance",
        "guide_offset",
        "contact_stiffness",
        "ft_bias_drift",
    ],
    tell_apart: "slow jogs to several positions with a stop at each: the force follows position and not time; \
                 re-route what hangs on the moving part, a cable or a hose, and it changes; a weight on a turning axis follows the \
                 sine of its angle, over a wide turn",
    law: Law::Spring(force),
    // A hardening spring has a linear part as well; the cubic part alone is what many a remainder looks like.
    is_whole: |parameters, _| parameters.contains(&0),
    separable: true,
    ..Effect::PLAIN
};

/// It pulls back in all directions.
fn force(p: &[f64], displacement: &Vector3<f64>) -> Vector3<f64> {
    displacement * -(p[0] + p[1] * displacement.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_alone_is_no_spring() {
        let is_whole = |parameters: &[usize]| (EFFECT.is_whole)(parameters, &|_| true);
        assert!(is_whole(&[0]) && is_whole(&[0, 1]) && !is_whole(&[1]));
    }

    #[test]
    fn it_pulls_back() {
        let displacement = Vector3::new(-0.5, 0.0, 0.25);
        let pulled = force(&[40.0, 0.0, 0.0, 0.0], &displacement);
        assert_eq!(pulled, Vector3::new(20.0, 0.0, -10.0));
        let harder = force(&[0.0, 32.0, 0.0, 0.0], &displacement);
        assert_eq!(harder, Vector3::new(5.0, 0.0, -2.5));
    }
}
