//! Friction of a guide that is highest at low speed.

use super::{ACTS_AT, SMOOTHING};
use crate::effects::law::decay;
use crate::effects::{Effect, Group, Guide, Kind, Law, Naming, Parameter, Reversal, Slide};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "guide_stribeck",
    title: "Stribeck friction of a guide or joint",
    summary: "dry friction that is higher at low speed, until the lubricant carries",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F = -(coulomb_n + excess_n exp(-|v/stribeck_speed_m_s|^exponent)) sign(v)",
    source: "Stribeck curve; exponent 1 (Tustin 1947) to 2 (Armstrong-Helouvry, Dupont and Canudas de Wit 1994, \
             Automatica 30)",
    signature: "force against velocity is a step at zero whose edges stand up: slow motion is braked more",
    typical: "excess of 20 to 100 % of the dry friction, gone above 1 to 20 mm/s",
    parameters: &[
        Parameter::new("coulomb_n", "N", 0.0, 1e6)
            .hidden(0.4, 0.7)
            .pictured(2.0),
        Parameter::new("excess_n", "N", 0.0, 1e6)
            .hidden(0.6, 1.0)
            .pictured(1.5),
        Parameter::new("stribeck_speed_m_s", "m/s", 1e-4, 1e3)
            .shape(&[1e-3, 2e-3, 3.5e-3, 6e-3, 1e-2, 2e-2], 5e-3)
            .hidden(0.006, 0.012)
            .pictured(0.004),
        // A coarse grid, as the speed dependence is searched as well.
        SMOOTHING.form_size(&[0.0, 8e-4, 5e-3], 0.0),
        ACTS_AT,
        Parameter::new("exponent", "-", 0.5, 4.0).form_size(&[2.0], 2.0),
    ],
    confused_with: &["guide_coulomb", "guide_hysteresis", "zero_cross_pause"],
    tell_apart: "creep at a tenth of the usual speed: Stribeck friction is higher there; an excess that comes out \
                 negative is something else, as a hysteresis that still builds up",
    law: Law::Guide(Guide { force, reversal }),
    // Without an excess it is a dry friction.
    is_whole: |parameters, _| parameters.contains(&1),
    kind: Some(Kind::DryFriction),
    ..Effect::PLAIN
};

/// The excess decays with a power of the speed. The square is computed separately, as a diagnosis evaluates it more often than
/// anything else.
fn force(p: &[f64], slide: &Slide) -> f64 {
    let ratio = slide.velocity.abs() / p[2].max(1e-6);
    let power = match p[5] {
        2.0 => ratio * ratio,
        exponent => ratio.powf(exponent),
    };
    -(p[0] + p[1] * decay(power)) * slide.direction
}

fn reversal(p: &[f64]) -> Option<Reversal> {
    Reversal::of(p[3], 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_points_of_the_curve() {
        let at = |v: f64| force(&[2.0, 1.5, 0.01, 0.0, 0.0, 2.0], &Slide::at_velocity(v));
        assert!((at(0.01) + 2.0 + 1.5 * (-1.0_f64).exp()).abs() < 1e-12);
        assert!((at(-1e-5) - 3.5).abs() < 1e-4 && (at(3.0) + 2.0).abs() < 1e-8);
        assert_eq!(at(0.0), 0.0);
    }
}
