//! Dry friction of a guide.

use super::{ACTS_AT, PRESLIDING, SMOOTHING};
use crate::effects::{Effect, Group, Guide, Kind, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_coulomb",
    title: "Dry friction of a guide or joint",
    summary: "the guide or joint brakes with a constant force against the motion",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -force_n sign(v)",
    source: "Coulomb's law; measured on the EMPS axis (20.4 N at 95 kg)",
    signature: "force against velocity is a step at zero: two levels, the same at every speed and without contact",
    typical: "0.3 to 20 N, 2 % of the moved weight on ball guides",
    parameters: &[
        Parameter::new("force_n", "N", 0.0, 1e6)
            .hidden(0.7, 1.4)
            .pictured(2.0),
        SMOOTHING,
        PRESLIDING,
        ACTS_AT,
    ],
    confused_with: &[
        "guide_stribeck",
        "guide_asymmetry",
        "guide_viscous",
        "guide_hysteresis",
    ],
    tell_apart: "jogs at several speeds in both directions: dry friction stays the same, viscous friction grows \
                 with speed, Stribeck friction falls with it, hysteresis needs a distance to build up",
    law: Law::Guide(Guide { force, reversal }),
    kind: Some(Kind::DryFriction),
    ..Effect::PLAIN
};

/// A level against the direction of the motion.
fn force(p: &[f64], slide: &Slide) -> f64 {
    -p[0] * slide.direction
}

/// A reversal is smoothed over a speed or over a distance.
fn reversal(p: &[f64]) -> Option<Reversal> {
    Reversal::of(p[1], p[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_for_each_direction() {
        let at = |v: f64| force(&[2.0, 0.0, 0.0, 0.0], &Slide::at_velocity(v));
        assert_eq!([-0.1, 0.0, 1e-9].map(at), [2.0, 0.0, -2.0]);
    }
}
