//! Linear damping of a contact.

use crate::effects::{Effect, Group, Kind, Law, Naming, Parameter, Penetration};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_damping",
    title: "Damping of the contact",
    summary: "the contact damps in proportion to the speed of penetration",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = max(0, nominal push + damping_n_s_per_m min(1, pen/onset) dpen/dt) while pen > 0, onset from \
               the nominal model",
    source: "linear spring and damper (Kelvin-Voigt), clipped because a wall cannot pull",
    signature: "force against penetration opens to a loop whose area grows with speed; the rebound is slower",
    typical: "1 to 10 % of critical damping for metal springs, 10 to 30 % for rubber",
    parameters: &[
        Parameter::new("damping_n_s_per_m", "N·s/m", 0.0, 1e7)
            .hidden(60.0, 150.0)
            .pictured(100.0),
        Parameter::choice(
            "acts_at_once",
            &["builds up with the depth", "acts at once"],
        ),
    ],
    confused_with: &[
        "hunt_crossley",
        "guide_viscous",
        "actuation_delay",
        "ft_low_pass",
    ],
    tell_apart: "bounces at two speeds: with linear damping the restitution does not depend on speed, with \
                 Hunt-Crossley damping it falls with speed; a delay feeds energy in instead of taking it out",
    law: Law::Push(push),
    kind: Some(Kind::ContactDamping),
    ..Effect::PLAIN
};

/// It sets in as the nominal damping does, or at once.
fn push(p: &[f64], touch: &Penetration) -> f64 {
    let share = if p[1] > 0.5 { 1.0 } else { touch.onset };
    p[0] * share * touch.rate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_sets_in_over_the_onset() {
        let touch = Penetration {
            depth: 0.001,
            rate: 0.5,
            onset: 0.25,
        };
        assert_eq!(push(&[100.0, 0.0], &touch), 12.5);
        assert_eq!(push(&[100.0, 1.0], &touch), 50.0);
    }
}
