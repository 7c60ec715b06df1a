//! Viscous friction of a guide.

use super::ACTS_AT;
use crate::effects::{Effect, Group, Guide, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_viscous",
    title: "Viscous friction of a guide or joint",
    summary: "the guide or joint brakes in proportion to the velocity",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -damping_n_s_per_m v",
    source: "textbook (linear damper); measured on the EMPS axis (203 N s/m at 95 kg)",
    signature: "force against velocity is a straight line through zero, everywhere, not only in contact",
    typical: "10 to 300 N s/m for greased guides and seals",
    parameters: &[
        Parameter::new("damping_n_s_per_m", "N·s/m", 0.0, 1e7)
            .hidden(20.0, 40.0)
            .pictured(120.0),
        ACTS_AT,
    ],
    confused_with: &[
        "guide_coulomb",
        "guide_stribeck",
        "manipulator_resistance",
        "contact_damping",
    ],
    tell_apart: "jogs at several speeds, without contact: the force grows in proportion to speed and there is \
                 none without speed",
    law: Law::Guide(Guide {
        force,
        reversal: Reversal::sharp,
    }),
    ..Effect::PLAIN
};

/// Proportional to the velocity.
fn force(p: &[f64], slide: &Slide) -> f64 {
    -p[0] * slide.velocity
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proportional_to_the_velocity() {
        let at = |v: f64| force(&[40.0, 0.0], &Slide::at_velocity(v));
        assert_eq!([-0.5, 0.0, 0.25].map(at), [20.0, 0.0, -10.0]);
    }
}
