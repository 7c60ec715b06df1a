//! Contact damping that grows with penetration.

use crate::effects::{Effect, Group, Kind, Law, Naming, Parameter, Penetration};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "hunt_crossley",
    title: "Hunt-Crossley damping",
    summary: "the contact damps in proportion to penetration and its speed",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = max(0, nominal push + damping_n_s_per_m2 pen^exponent dpen/dt); the unit holds for exponent 1",
    source: "Hunt and Crossley 1975 (J. Appl. Mech. 42)",
    signature: "force against penetration opens to a loop that is closed at both ends: no jump at touch, no pull \
                at release",
    typical: "restitution falls by 0.1 to 0.5 per m/s; exponent 1 for flat faces, 1.5 for spheres",
    parameters: &[
        Parameter::new("damping_n_s_per_m2", "N·s/m^2", 0.0, 1e9)
            .hidden(2e4, 4e4)
            .pictured(7e4),
        Parameter::new("exponent", "-", 0.5, 2.0)
            .form(&[1.0, 1.25, 1.5], 1.0)
            .hidden(1.0, 1.0)
            .pictured(1.0),
    ],
    confused_with: &["contact_damping", "contact_cubic", "guide_viscous"],
    tell_apart: "bounces at two speeds: the restitution falls with speed; linear damping keeps it and makes the \
                 force jump at touch",
    law: Law::Push(push),
    kind: Some(Kind::ContactDamping),
    ..Effect::PLAIN
};

/// The damping grows with the depth.
fn push(p: &[f64], touch: &Penetration) -> f64 {
    p[0] * touch.depth.powf(p[1]) * touch.rate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_millimetres_deep_at_fifty_per_second() {
        let touch = Penetration {
            depth: 0.01,
            rate: 0.05,
            onset: 1.0,
        };
        for (exponent, expected) in [(1.0, 200.0), (1.5, 20.0), (2.0, 2.0)] {
            assert!((push(&[4e5, exponent], &touch) - expected).abs() < 1e-9 * expected);
        }
    }
}
