//! Stiffness of the docking mechanism.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_mechanism::Kind;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "docking_stiffness",
    title: "Stiffness of the docking mechanism",
    summary: "what the docking mechanism yields with is stiffer or softer than nominal",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "k = (1 + stiffness_share) nominal k of the rounded bodies, of both stages, of head on cone, or \
               of the six legs",
    source: "Hooke's law",
    signature: "contact takes another time, and force against depth has another slope",
    typical: "a few percent; more when the compliance of rig and adapter is left out",
    parameters: &[Parameter::new("stiffness_share", "-", -0.95, 10.0).pictured(0.4)],
    confused_with: &[
        "docking_friction",
        "docking_leg",
        "contact_stiffness",
        "ft_scale",
    ],
    tell_apart: "a slow push along the axis: the slope; one soft leg shows as a torque as well",
    law: Law::Docking(law),
    ..Effect::PLAIN
};

/// Changes the stiffness of the part that yields.
fn law(p: &[f64], kind: &mut Kind) {
    let factor = 1.0 + p[0];
    match kind {
        Kind::HuntCrossley(bodies) => bodies.stiffness_n_per_m15 *= factor,
        Kind::TwoStage(absorber) => {
            absorber.stiffness_n_per_m *= factor;
            absorber.second_stiffness_n_per_m *= factor;
        }
        Kind::ProbeCone(probe) => probe.surface.stiffness_n_per_m *= factor,
        Kind::SoftCapture(ring) => ring.legs.stiffness_n_per_m *= factor,
        Kind::EddyCurrent(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::probe;
    use super::*;

    #[test]
    fn a_share_of_the_nominal_one() {
        let probe = probe(|kind| law(&[-0.5], kind));
        assert_eq!(probe.surface.stiffness_n_per_m, 1e4);
    }
}
