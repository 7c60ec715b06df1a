//! Second stage of the contact.

use crate::effects::{Effect, Group, Law, Naming, Parameter, Penetration};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_second_stage",
    title: "Second stage of the contact",
    summary: "beyond a depth the contact has another stiffness",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = max(0, nominal push + stiffness_n_per_m max(0, pen - stage_m))",
    source: "Syromiatnikov, Spacecraft Docking Devices: springs in two stages, soft and then stiff",
    signature: "force against penetration is two straight lines with a corner",
    typical: "shock absorbers of docking probes stiffen several times over near their end",
    parameters: &[
        Parameter::new("stiffness_n_per_m", "N/m", -1e8, 1e8)
            .hidden(3e3, 6e3)
            .pictured(5e3),
        Parameter::new("stage_m", "m", 1e-5, 0.5)
            .shape(
                &[3e-4, 7e-4, 1.5e-3, 2.5e-3, 4e-3, 6e-3, 0.01, 0.02, 0.05],
                1e-3,
            )
            .hidden(2e-3, 3e-3)
            .pictured(1e-3),
    ],
    confused_with: &["contact_cubic", "contact_stiffness", "contact_deadzone"],
    tell_apart: "a slow push deeper than the corner: two straight lines; a power of the depth bends everywhere",
    law: Law::Push(push),
    ..Effect::PLAIN
};

/// The second spring beside the first.
fn push(p: &[f64], touch: &Penetration) -> f64 {
    p[0] * (touch.depth - p[1]).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_the_corner() {
        let at = |depth| {
            let touch = Penetration {
                depth,
                rate: 0.3,
                onset: 1.0,
            };
            push(&[1000.0, 0.25], &touch)
        };
        assert_eq!([at(0.125), at(0.5)], [0.0, 250.0]);
    }
}
