//! Eddy-current damper in the contact.

use crate::effects::{Effect, Group, Kind, Law, Naming, Parameter, Penetration};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_eddy_current",
    title: "Eddy-current damper in the contact",
    summary: "an induction brake damps the contact: most at one speed, less above it",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = max(0, nominal push + 2 largest_force_n u/(1 + u^2)), u = (dpen/dt)/critical_speed_m_s",
    source: "induction brakes (Kloss); Syromiatnikov: electromechanical dampers in place of oil",
    signature: "damping force against speed bends over: fast contacts are damped less than slow ones lead to \
                expect",
    typical: "largest at 10 to 100 mm/s, tens to hundreds of newtons",
    parameters: &[
        Parameter::new("largest_force_n", "N", 0.0, 1e5)
            .hidden(4.0, 8.0)
            .pictured(10.0),
        Parameter::new("critical_speed_m_s", "m/s", 1e-4, 1.0)
            .shape(&[1e-3, 2e-3, 4e-3, 8e-3, 0.015, 0.03, 0.06], 0.02)
            .hidden(8e-3, 0.015)
            .pictured(0.01),
    ],
    confused_with: &["contact_damping", "hunt_crossley", "contact_preload"],
    tell_apart: "bounces at speeds on both sides of the critical one: linear damping takes the same share of \
                 the energy at each, an eddy-current brake less and less",
    law: Law::Push(push),
    kind: Some(Kind::ContactDamping),
    ..Effect::PLAIN
};

/// Largest at the critical speed.
fn push(p: &[f64], touch: &Penetration) -> f64 {
    let ratio = touch.rate / p[1];
    2.0 * p[0] * ratio / (1.0 + ratio * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_at_the_critical_speed_and_against_the_motion() {
        let at = |rate| {
            let touch = Penetration {
                depth: 0.01,
                rate,
                onset: 1.0,
            };
            push(&[8.0, 0.25], &touch)
        };
        assert_eq!([at(0.25), at(-0.25), at(0.5)], [8.0, -8.0, 6.4]);
    }
}
