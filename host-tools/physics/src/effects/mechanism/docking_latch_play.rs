//! Play of the latches.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_mechanism::Kind;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "docking_latch_play",
    title: "Play of the latches",
    summary: "the latches leave the head of the probe more play than nominal",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "backlash of the socket = nominal backlash_m + play_m",
    source: "textbook (dead zone)",
    signature: "after capture the head moves without a force, then is stopped: the ring-down has flat pieces",
    typical: "0.1 to 2 mm in rotating latches",
    parameters: &[Parameter::new("play_m", "m", 0.0, 0.05)
        .shape(
            &[
                5e-5, 1e-4, 2e-4, 4e-4, 7e-4, 1e-3, 1.5e-3, 2.2e-3, 3.3e-3, 5e-3, 8e-3, 1.2e-2,
                2e-2,
            ],
            0.0,
        )
        .pictured(0.001)],
    confused_with: &["docking_latch_slip", "contact_deadzone", "backlash"],
    tell_apart: "move the captured head slowly to and fro: a play has ends, a slipping latch has none",
    law: Law::Docking(law),
    ..Effect::PLAIN
};

/// Changes the socket of a probe; other mechanisms have none.
fn law(p: &[f64], kind: &mut Kind) {
    if let Kind::ProbeCone(probe) = kind
        && let Some(socket) = &mut probe.socket
    {
        socket.backlash_m += p[0];
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::probe;
    use super::*;

    #[test]
    fn it_is_added() {
        let probe = probe(|kind| law(&[0.25], kind));
        assert_eq!(probe.socket.map(|socket| socket.backlash_m), Some(0.25));
    }
}
