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

/// Changes the socket of a probe, unless it slips already at a smaller force.
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
    use super::super::tests::probe;
    use super::*;

    #[test]
    fn the_smaller_force_counts() {
        for (forces_n, expected) in [
            (&[30.0][..], 30.0),
            (&[30.0, 50.0], 30.0),
            (&[30.0, 20.0], 20.0),
        ] {
            let probe = probe(|kind| forces_n.iter().for_each(|f| law(&[*f], kind)));
            let slips_at_n = probe.socket.and_then(|s| s.latch_slips_at_n);
            assert_eq!(slips_at_n, Some(expected));
        }
    }
}
