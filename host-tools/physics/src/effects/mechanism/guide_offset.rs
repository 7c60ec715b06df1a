//! A constant force along the guide.

use super::ACTS_AT;
use crate::effects::{Effect, Group, Guide, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_offset",
    title: "Constant force along a guide, or torque of a joint",
    summary: "a constant force pulls the moving side in one direction",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = force_n, along the guide, whatever the motion",
    source: "measured on the EMPS axis (-3.2 N); a sloping guide or a counterweight acts so",
    signature: "the force along the guide is shifted by a constant at all times, also at standstill",
    typical: "some N; 1 N is a slope of 0.6 deg for 10 kg",
    parameters: &[
        Parameter::new("force_n", "N", -1e6, 1e6)
            .hidden(0.8, 1.6)
            .either_sign()
            .pictured(-3.0),
        ACTS_AT,
    ],
    confused_with: &["ft_bias", "guide_asymmetry", "base_tilt", "cable_stiffness"],
    tell_apart: "move both ways: a dry friction changes its sign; move to several positions: a cable pulls differently at each; turn the \
                 sensor: a bias stays in its axes, the force in those of the guide",
    law: Law::Guide(Guide {
        force,
        reversal: Reversal::sharp,
    }),
    ..Effect::PLAIN
};

/// The same wherever it moves.
fn force(p: &[f64], _: &Slide) -> f64 {
    p[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_does_not_ask_for_the_motion() {
        let at = |v: f64| force(&[-3.0, 0.0], &Slide::at_velocity(v));
        assert_eq!([-0.5, 0.0, 0.5].map(at), [-3.0; 3]);
    }
}
