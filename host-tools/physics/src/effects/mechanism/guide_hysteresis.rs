//! Hysteresis of a guide: friction that builds up over a distance.

use crate::effects::{Effect, Group, Guide, Kind, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_hysteresis",
    title: "Hysteresis of a guide or joint",
    summary: "friction that builds up over a distance after each reversal",
    group: Group::Mechanism,
    naming: Naming::Shape,
    equation: "F = -force_n z, displacement_m dz/dx = 1 - |z| while z pushes against the motion, else 1 \
               (Bouc-Wen with A = 1, beta = gamma = 1/2, n = 1), or 1 - sgn(dx) z throughout (Dahl)",
    source: "Bouc 1967, Wen 1976 (J. Eng. Mech. 102); Dahl 1968; presliding of rolling guides",
    signature: "force against position is a loop with rounded corners; its width does not depend on speed",
    typical: "presliding over 0.01 to 0.2 mm in a rolling guide; millimetres in hoses and rubber, centimetres in what is stretched",
    parameters: &[
        Parameter::new("force_n", "N", 0.0, 1e6)
            .hidden(0.8, 1.4)
            .pictured(5.0),
        Parameter::new("displacement_m", "m", 1e-5, 0.1)
            .shape(&[2e-5, 5e-5, 1e-4, 2e-4, 4e-4, 8e-4, 1.5e-3, 3e-3], 1e-3)
            // Presliding ends within a millimetre in guides, within a few in hoses and rubber.
            .searched_to(0.01)
            .hidden(5e-4, 2e-3)
            .pictured(0.001),
        Parameter::choice(
            "unloads",
            &[
                "linearly down to 0 (Bouc-Wen)",
                "the faster the more it holds (Dahl)",
            ],
        ),
    ],
    confused_with: &[
        "guide_coulomb",
        "guide_stribeck",
        "cable_stiffness",
        "backlash",
    ],
    tell_apart: "small jogs of growing length: dry friction switches at once, hysteresis needs the same distance \
                 after each reversal; which mechanism lies behind the loop only a look at the rig can tell",
    law: Law::Guide(Guide { force, reversal }),
    kind: Some(Kind::DryFriction),
    ..Effect::PLAIN
};

/// The level, times the built-up state, against the motion.
fn force(p: &[f64], slide: &Slide) -> f64 {
    -p[0] * slide.direction
}

fn reversal(p: &[f64]) -> Option<Reversal> {
    Some(match p[2] > 0.5 {
        true => Reversal::OverDistance(p[1]),
        false => Reversal::BoucWen(p[1]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_lags_behind_the_motion_by_its_length() {
        let of = |unloads| reversal(&[5.0, 0.002, unloads]);
        assert_eq!(of(0.0), Some(Reversal::BoucWen(0.002)));
        assert_eq!(of(1.0), Some(Reversal::OverDistance(0.002)));
        let half = Slide {
            direction: 0.5,
            ..Slide::at_velocity(-0.1)
        };
        assert_eq!(force(&[5.0, 0.002, 0.0], &half), -2.5);
    }
}
