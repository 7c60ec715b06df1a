//! Pull of a cable bundle on the moving side.

use super::ACTS_AT;
use crate::effects::{Effect, Group, Law, Naming, Parameter};
use nalgebra::Vector3;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "cable_stiffness",
    title: "Pull of the cables",
    summary: "a cable bundle pulls the moving side back in proportion to its displacement",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -stiffness_n_per_m (p - p0), p0: position at the start",
    source: "Hooke's law; hose packages of robots",
    signature: "a force proportional to position, everywhere, not only in contact",
    typical: "10 to 200 N/m for sensor and hose bundles",
    parameters: &[
        Parameter::new("stiffness_n_per_m", "N/m", 0.0, 1e5)
            .hidden(40.0, 100.0)
            .pictured(150.0),
        Parameter::new("about_start", "-", 0.0, 1.0).form(&[0.0, 1.0], 0.0),
        ACTS_AT,
    ],
    confused_with: &[
        "manipulator_resistance",
        "guide_offset",
        "contact_stiffness",
        "ft_bias_drift",
    ],
    tell_apart: "slow jogs to several positions with a stop at each: the force follows position and not time; \
                 unplug or re-route the bundle and it changes",
    law: Law::Spring(force),
    ..Effect::PLAIN
};

/// It pulls back in all directions.
fn force(p: &[f64], displacement: &Vector3<f64>) -> Vector3<f64> {
    displacement * -p[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_pulls_back() {
        let pulled = force(&[40.0, 0.0, 0.0], &Vector3::new(-0.5, 0.0, 0.25));
        assert_eq!(pulled, Vector3::new(20.0, 0.0, -10.0));
    }
}
