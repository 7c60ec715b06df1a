//! Friction of the docking mechanism.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_mechanism::Kind;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "docking_friction",
    title: "Friction of the docking mechanism",
    summary: "what slides in the docking mechanism is rougher or smoother than nominal",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "mu = max(0, nominal friction_coefficient + friction_error) of head on cone, or of petals and \
               face on the ring",
    source: "Coulomb's law, with the sticking spring of Cundall and Strack 1979",
    signature: "forces along the surface in proportion to those across it; the way home takes another time",
    typical: "mu 0.1 to 0.3 between metals; in vacuum and without lubricant several times as much",
    parameters: &[Parameter::new("friction_error", "-", -1.0, 1.0).pictured(0.4)],
    confused_with: &["docking_stiffness", "ft_crosstalk", "ft_mounting"],
    tell_apart: "an approach beside the axis and one on it: friction only shows where something slides",
    law: Law::Docking(law),
    ..Effect::PLAIN
};

/// Changes the friction of whichever surface the mechanism has.
fn law(p: &[f64], kind: &mut Kind) {
    let surface = match kind {
        Kind::ProbeCone(probe) => &mut probe.surface,
        Kind::SoftCapture(ring) => &mut ring.surface,
        Kind::HuntCrossley(_) | Kind::TwoStage(_) | Kind::EddyCurrent(_) => return,
    };
    surface.friction_coefficient = (surface.friction_coefficient + p[0]).max(0.0);
}

#[cfg(test)]
mod tests {
    use super::super::tests::probe;
    use super::*;

    #[test]
    fn it_is_added_and_never_negative() {
        for (error, expected) in [(0.5, 0.75), (-0.5, 0.0)] {
            let probe = probe(|kind| law(&[error], kind));
            assert_eq!(probe.surface.friction_coefficient, expected);
        }
    }
}
