//! Contact that stiffens with penetration.

use crate::effects::{Effect, Group, Law, Naming, Parameter, Penetration};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_cubic",
    title: "Stiffening contact",
    summary: "the contact stiffens with the cube of the penetration",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = nominal push + stiffness_n_per_m3 pen^3",
    source: "textbook (Duffing spring)",
    signature: "force against penetration bends upwards; deep bounces are shorter and harder than shallow ones",
    typical: "10 to 50 % more force than linear at the deepest point, in rubber stops and coil springs near block",
    parameters: &[
        Parameter::new("stiffness_n_per_m3", "N/m^3", 0.0, 1e12)
            .hidden(1.2e7, 2.5e7)
            .pictured(2.5e8),
        Parameter::new("exponent", "-", 1.5, 4.0).form(&[3.0, 2.5, 2.0, 3.5], 3.0),
    ],
    confused_with: &["contact_stiffness", "contact_deadzone", "hunt_crossley"],
    tell_apart: "bounces of two depths: linear stiffness fitted to the deep one is too stiff for the shallow one; \
                 Hunt-Crossley damping opens a loop, a spring does not",
    law: Law::Push(push),
    ..Effect::PLAIN
};

/// A power of the depth beside the linear spring.
fn push(p: &[f64], touch: &Penetration) -> f64 {
    p[0] * touch.depth.powf(p[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_millimetres() {
        let touch = Penetration {
            depth: 0.004,
            rate: 0.3,
            onset: 1.0,
        };
        assert!((push(&[3.5e7, 3.0], &touch) - 2.24).abs() < 1e-9);
    }
}
