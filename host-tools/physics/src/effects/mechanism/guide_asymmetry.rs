//! Friction of a guide that differs by direction, in its dry part, its viscous part, or both.

use super::{ACTS_AT, SMOOTHING};
use crate::effects::{Difference, Effect, Group, Guide, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_asymmetry",
    title: "Friction that differs by direction",
    summary: "the guide or joint brakes more in one direction than in the other",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -forward_n - d |v| for v > 0, +backward_n - d |v| for v < 0, with the viscous difference d",
    source: "measured on the EMPS axis (viscous friction 165 N·s/m forward, 244 N·s/m backward); textbook",
    signature: "two levels of force, as dry friction, or two slopes over the speed, but of different size",
    typical: "10 to 30 % difference of either part, from a preloaded seal, a sloping guide or a screw",
    parameters: &[
        Parameter::new("forward_n", "N", 0.0, 1e6)
            .hidden(0.9, 1.4)
            .pictured(3.0),
        Parameter::new("backward_n", "N", 0.0, 1e6)
            .hidden(0.2, 0.5)
            .pictured(1.5),
        // The amount by which viscous friction is larger forward and smaller backward than its mean, which is an effect of its
        // own.
        Parameter::new("viscous_difference_n_s_per_m", "N·s/m", -1e7, 1e7),
        SMOOTHING,
        ACTS_AT,
    ],
    confused_with: &["guide_coulomb", "guide_offset", "ft_bias"],
    tell_apart: "a pause between the jogs: at standstill an offset or a bias is still there, friction is not",
    law: Law::Guide(Guide { force, reversal }),
    separable: true,
    detail_of: &[("guide_coulomb", &[1.0, 1.0, 0.0]), ("guide_viscous", &[])],
    is_whole,
    difference_of: Some(Difference {
        place: 2,
        of: "guide_viscous",
        of_place: 0,
    }),
    ..Effect::PLAIN
};

/// Two levels, or one beside a dry friction of both directions: a single level alone says nothing of the other direction, and two
/// beside a dry friction are a second dry friction, not a difference. A viscous difference needs a viscous friction beside it.
fn is_whole(parameters: &[usize], beside: &dyn Fn(&str) -> bool) -> bool {
    let has = |place| parameters.contains(&place);
    let levels = usize::from(has(0)) + usize::from(has(1));
    let beside_a_level = beside("guide_coulomb");
    let is_difference = levels == if beside_a_level { 1 } else { 2 };
    (levels == 0 || is_difference) && (!has(2) || beside("guide_viscous"))
}

/// A level and a slope for each direction.
fn force(p: &[f64], slide: &Slide) -> f64 {
    let level = if slide.velocity > 0.0 { p[0] } else { p[1] };
    -level * slide.direction - p[2] * slide.velocity.abs()
}

fn reversal(p: &[f64]) -> Option<Reversal> {
    Reversal::of(p[3], 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_level_per_direction() {
        let at = |v: f64| force(&[3.0, 2.0, 0.0, 0.0, 0.0], &Slide::at_velocity(v));
        assert_eq!([-0.1, 0.0, 0.1].map(at), [2.0, 0.0, -3.0]);
    }

    #[test]
    fn a_difference_is_one_of_something() {
        let viscous = |id: &str| id == "guide_viscous";
        assert!(is_whole(&[0, 1], &|_| false) && is_whole(&[2], &viscous));
        let dry = |id: &str| id == "guide_coulomb";
        assert!(is_whole(&[0], &dry) && !is_whole(&[0, 1], &dry));
        assert!(!is_whole(&[0], &viscous) && !is_whole(&[0, 1, 2], &|_| false));
    }

    /// Beside a viscous friction of 200 N·s/m, −40 N·s/m make 160 forward and 240 backward.
    #[test]
    fn one_slope_per_direction() {
        let sloped = |v: f64| force(&[0.0, 0.0, -40.0, 0.0, 0.0], &Slide::at_velocity(v));
        let both = |v: f64| sloped(v) - 200.0 * v;
        assert_eq!([-0.5, 0.0, 0.5].map(both), [120.0, 0.0, -80.0]);
    }
}
