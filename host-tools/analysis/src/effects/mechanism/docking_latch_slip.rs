//! Slipping latches.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_mechanism::Kind;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "docking_latch_slip",
    title: "Slipping latches",
    summary: "the latches slip at a force that they should hold",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "each latch holds up to force_n and slips on beyond it",
    source: "Coulomb's law for a clamped joint",
    signature: "after capture the force has a ceiling, and the head stays where it slipped to",
    typical: "a worn latch slips at a fraction of its rated force",
    parameters: &[Parameter::new("force_n", "N", 1e-2, 1e6)
        .shape(&[3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4], 1e6)
        .pictured(20.0)],
    confused_with: &["docking_latch_play", "ft_saturation", "docking_stiffness"],
    tell_apart: "pull the captured head harder and harder: a slipping latch keeps its force and moves",
    law: Law::Docking(law),
    ..Effect::PLAIN
};

/// Of the socket of a probe, if it does not slip earlier by itself.
fn law(p: &[f64], kind: &mut Kind) {
    if let Kind::ProbeCone(probe) = kind
        && let Some(socket) = &mut probe.socket
    {
        let held = socket.latch_slips_at_n.unwrap_or(f64::INFINITY);
        socket.latch_slips_at_n = Some(held.min(p[0]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROBE: &str = r#"{"probe_cone": {"half_angle_rad": 0.9, "mouth_radius_m": 0.25, "head_radius_m": 0.04,
        "surface": {"stiffness_n_per_m": 2e4, "friction_coefficient": 0.25},
        "socket": {"capture_depth_m": 0.006, "capture_radius_m": 0.008, "latch_stiffness_n_per_m": 5e4}}}"#;

    #[test]
    fn the_smaller_force_counts() {
        let mut kind: Kind = serde_json::from_str(PROBE).unwrap();
        for (force_n, expected) in [(30.0, 30.0), (50.0, 30.0), (20.0, 20.0)] {
            law(&[force_n], &mut kind);
            let Kind::ProbeCone(probe) = &kind else {
                panic!("another kind")
            };
            assert_eq!(
                probe.socket.and_then(|s| s.latch_slips_at_n),
                Some(expected)
            );
        }
    }
}
