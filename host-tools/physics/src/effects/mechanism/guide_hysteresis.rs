//! Hysteresis of a guide: friction that builds up over a distance.

use crate::effects::{Effect, Group, Guide, Kind, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_hysteresis",
    title: "Hysteresis of the guide",
    summary: "friction that builds up over a distance after each reversal",
    group: Group::Mechanism,
    naming: Naming::Shape,
    equation: "F = -force_n z, displacement_m dz/dx = 1 - |z| while z pushes against the motion, else 1 \
               (Bouc-Wen with A = 1, beta = gamma = 1/2, n = 1)",
    source: "Bouc 1967, Wen 1976 (J. Eng. Mech. 102); presliding of rolling guides",
    signature: "force against position is a loop with rounded corners; its width does not depend on speed",
    typical: "presliding over 0.01 to 0.2 mm in a rolling guide; millimetres in hoses and rubber",
    parameters: &[
        Parameter::new("force_n", "N", 0.0, 1e6)
            .hidden(0.8, 1.4)
            .pictured(5.0),
        Parameter::new("displacement_m", "m", 1e-5, 0.01)
            .shape(&[2e-5, 5e-5, 1e-4, 2e-4, 4e-4, 8e-4, 1.5e-3, 3e-3], 1e-3)
            .hidden(5e-4, 2e-3)
            .pictured(0.001),
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

/// A level against the direction that has been built up.
fn force(p: &[f64], slide: &Slide) -> f64 {
    -p[0] * slide.direction
}

fn reversal(p: &[f64]) -> Option<Reversal> {
    Some(Reversal::BoucWen(p[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_lags_behind_the_motion_by_its_length() {
        assert_eq!(reversal(&[5.0, 0.002]), Some(Reversal::BoucWen(0.002)));
        let half = Slide {
            direction: 0.5,
            ..Slide::at_velocity(-0.1)
        };
        assert_eq!(force(&[5.0, 0.002], &half), -2.5);
    }
}
