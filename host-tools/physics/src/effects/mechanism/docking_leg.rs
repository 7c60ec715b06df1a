//! One leg of the ring.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_mechanism::Kind;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "docking_leg",
    title: "One leg of the ring",
    summary: "one of the six legs of the soft-capture ring is softer or stiffer than the others",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "k of the leg with this number = (1 + stiffness_share) nominal k; numbers 1 to 6 in the order \
               of leg_factors",
    source: "statics of Stewart's platform: J^T K J",
    signature: "a push along the axis tilts the ring to one side, whose direction names the leg",
    typical: "a worn or wrongly set drive loses a few tenths of its stiffness",
    parameters: &[
        Parameter::new("stiffness_share", "-", -0.95, 10.0).pictured(-0.6),
        Parameter::new("leg", "-", 1.0, 6.0).form(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 1.0),
    ],
    confused_with: &["docking_stiffness", "docking_friction", "ft_crosstalk"],
    tell_apart: "pushes along the axis and across it in two directions: each leg has a pattern of its own",
    law: Law::Docking(law),
    ..Effect::PLAIN
};

/// Changes one leg of a soft-capture ring; other mechanisms have none.
fn law(p: &[f64], kind: &mut Kind) {
    if let Kind::SoftCapture(ring) = kind {
        let leg = (p[1].round() as usize).clamp(1, 6) - 1;
        ring.legs.leg_factors[leg] *= 1.0 + p[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RING: &str = r#"{"soft_capture": {"capture_gap_m": 0.02,
        "legs": {"base_radius_m": 0.7, "ring_radius_m": 0.65, "height_m": 0.5, "spread_rad": 0.15,
                 "stiffness_n_per_m": 2000, "damping_n_s_per_m": 800},
        "petals": {"angle_rad": 0.7, "length_m": 0.2, "clearance_m": 0.003, "edge_radius_m": 0.6},
        "surface": {"stiffness_n_per_m": 5e5}}}"#;

    #[test]
    fn the_leg_with_the_number() {
        let mut kind: Kind = serde_json::from_str(RING).unwrap();
        law(&[-0.5, 3.0], &mut kind);
        let Kind::SoftCapture(ring) = kind else {
            panic!("another kind")
        };
        assert_eq!(ring.legs.leg_factors, [1.0, 1.0, 0.5, 1.0, 1.0, 1.0]);
    }
}
