//! Gravity torque of a link about the bearing on which it turns.

use crate::effects::{Effect, Group, Guide, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "bearing_gravity",
    title: "Gravity torque of a link",
    summary: "the weight of a link turns it towards where it hangs",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "T = -sine_n_m sin(q) - cosine_n_m cos(q) = -m g l sin(q + phi)",
    source: "textbook (physical pendulum); m g l and phi are the length and the angle of (sine_n_m, cosine_n_m)",
    signature: "a torque that follows the angle like a sine, the same in both directions and at every speed",
    typical: "0.1 to 100 N m; none about a vertical axis",
    parameters: &[
        Parameter::new("sine_n_m", "N·m", -1e6, 1e6).pictured(2.0),
        Parameter::new("cosine_n_m", "N·m", -1e6, 1e6),
    ],
    confused_with: &["cable_stiffness", "guide_offset", "ft_bias"],
    tell_apart: "a slow turn over more than a quarter: a sine bends, a spring does not; turn the axis upright and it \
                 is gone",
    law: Law::Bearing(Guide {
        force: torque,
        reversal: Reversal::sharp,
    }),
    separable: true,
    ..Effect::PLAIN
};

/// Torque about the bearing from the angle, N·m.
fn torque(p: &[f64], turn: &Slide) -> f64 {
    let (sin, cos) = turn.position.sin_cos();
    -p[0] * sin - p[1] * cos
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 kg at 0.5 m, hanging at q = 30°: no torque there, all of it a quarter turn away.
    #[test]
    fn a_pendulum() {
        let (m_g_l, hangs) = (2.0 * 9.81 * 0.5, 30.0_f64.to_radians());
        let p = [m_g_l * hangs.cos(), -m_g_l * hangs.sin()];
        let at = |position: f64| {
            let turn = Slide {
                position,
                ..Slide::default()
            };
            torque(&p, &turn)
        };
        assert!(at(hangs).abs() < 1e-12);
        assert!((at(hangs + 0.5 * std::f64::consts::PI) + m_g_l).abs() < 1e-12);
    }
}
