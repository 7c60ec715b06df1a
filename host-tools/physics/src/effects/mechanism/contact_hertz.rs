//! Contact of rounded bodies.

use crate::effects::{Effect, Group, Law, Naming, Parameter, Penetration};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_hertz",
    title: "Contact of rounded bodies",
    summary: "the contact pushes with depth to the power of 1.5",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = max(0, nominal push + stiffness_n_per_m15 pen^1.5); alone where the nominal wall has no \
               stiffness",
    source: "Hertz 1882: 4/3 E* sqrt(R) for spheres",
    signature: "force against penetration begins flat and bends upwards; faster bounces are shorter, as v^-0.2",
    typical: "1e8 N/m^1.5 and more between steel balls, 1e5 between rubber ones",
    parameters: &[Parameter::new("stiffness_n_per_m15", "N/m^1.5", 0.0, 1e12)
        .hidden(2e4, 4e4)
        .pictured(1e5)],
    confused_with: &["contact_cubic", "contact_stiffness", "contact_deadzone"],
    tell_apart: "bounces at two speeds: a linear spring takes the same time, a Hertzian contact less at the \
                 faster one, a cube much less",
    law: Law::Push(push),
    ..Effect::PLAIN
};

/// Beside the linear spring.
fn push(p: &[f64], touch: &Penetration) -> f64 {
    p[0] * touch.depth * touch.depth.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_times_as_deep_is_eight_times_the_force() {
        let at = |depth| {
            let touch = Penetration {
                depth,
                rate: 0.3,
                onset: 1.0,
            };
            push(&[1000.0], &touch)
        };
        assert_eq!([at(0.01), at(0.04)].map(f64::round), [1.0, 8.0]);
    }
}
