//! Preloaded contact.

use crate::effects::{Effect, Group, Law, Naming, Parameter, Penetration, sign};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_preload",
    title: "Preloaded contact",
    summary: "the contact holds against a preload, and a friction brake holds it either way",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = max(0, nominal push + (preload_n + brake_n sgn(dpen/dt)) min(1, pen/seat_m)) while pen > 0",
    source: "Syromiatnikov, Spacecraft Docking Devices: preloaded springs with friction hysteresis",
    signature: "the force jumps at touch; with a brake it falls by twice the brake where the motion turns, \
                whatever the depth",
    typical: "a tenth to a half of the peak force in shock absorbers of docking probes",
    parameters: &[
        Parameter::new("preload_n", "N", 0.0, 1e5)
            .hidden(4.0, 8.0)
            .pictured(10.0),
        Parameter::new("brake_n", "N", 0.0, 1e5)
            .hidden(2.0, 4.0)
            .pictured(5.0),
        Parameter::new("seat_m", "m", 1e-6, 0.01)
            .form_size(&[1e-5, 1e-4, 3e-4], 1e-4)
            .hidden(1e-4, 1e-4)
            .pictured(1e-4),
    ],
    confused_with: &["wall_position", "contact_damping", "guide_coulomb"],
    tell_apart: "bounces of two depths and speeds: preload and brake keep their size, damping grows with \
                 speed; a shifted wall is met earlier, and friction of the guide is there without contact",
    law: Law::Push(push),
    separable: true,
    ..Effect::PLAIN
};

/// Both build up over the seat.
fn push(p: &[f64], touch: &Penetration) -> f64 {
    let seated = (touch.depth / p[2]).min(1.0);
    (p[0] + p[1] * sign(touch.rate)) * seated
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_and_out_differ_by_twice_the_brake() {
        let at = |depth, rate| {
            let touch = Penetration {
                depth,
                rate,
                onset: 1.0,
            };
            push(&[10.0, 4.0, 1e-3], &touch)
        };
        assert_eq!([at(0.01, 0.1), at(0.01, -0.1)], [14.0, 6.0]);
        assert_eq!(at(0.5e-3, 0.1), 7.0);
    }
}
