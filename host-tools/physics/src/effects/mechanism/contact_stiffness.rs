//! Stiffness of a contact that differs from the model.

use crate::effects::{Effect, Group, Law, Naming, Parameter, Penetration};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_stiffness",
    title: "Stiffness of the contact",
    summary: "the contact's spring is stiffer or softer than nominal",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = nominal push + stiffness_error_n_per_m pen",
    source: "Hooke's law",
    signature: "force against penetration is a straight line of another slope; contact takes another time",
    typical: "1 to 10 % of the nominal stiffness; more when the rig's own compliance is left out",
    parameters: &[Parameter::new("stiffness_error_n_per_m", "N/m", -1e8, 1e8)
        .hidden(500.0, 1200.0)
        .either_sign()
        .pictured(1500.0)],
    confused_with: &["contact_cubic", "contact_deadzone", "ft_scale"],
    tell_apart: "bounces of two depths: a wrong slope errs in proportion to depth, stiffening with its cube; a \
                 wrong gain of the sensor also shows in the weight of the tool when it is tilted",
    law: Law::Push(push),
    ..Effect::PLAIN
};

/// Another slope than the model has.
fn push(p: &[f64], touch: &Penetration) -> f64 {
    p[0] * touch.depth
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_slope() {
        let touch = Penetration {
            depth: 0.25,
            rate: 0.3,
            onset: 1.0,
        };
        assert_eq!(push(&[-400.0], &touch), -100.0);
    }
}
