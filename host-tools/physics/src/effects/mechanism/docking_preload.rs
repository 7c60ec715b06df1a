//! Preload and brake of the absorber.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_mechanism::Kind;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "docking_preload",
    title: "Preload and brake of the absorber",
    summary: "preload or friction brake of the two-stage absorber differ from nominal",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "F0 = max(0, nominal preload + preload_error_n), Ff = max(0, nominal brake + brake_error_n)",
    source: "Syromiatnikov, Spacecraft Docking Devices",
    signature: "the force at which the absorber begins to move is another; in and out differ by another amount",
    typical: "a spring that has set loses a tenth of its preload; a brake doubles with its temperature",
    parameters: &[
        Parameter::new("preload_error_n", "N", -1e5, 1e5).pictured(20.0),
        Parameter::new("brake_error_n", "N", -1e5, 1e5).pictured(10.0),
    ],
    confused_with: &["docking_stiffness", "contact_preload", "ft_scale"],
    tell_apart: "slow pushes in and out: the brake is half of what lies between them, the preload their mean \
                 at the start",
    law: Law::Docking(law),
    separable: true,
    ..Effect::PLAIN
};

/// Changes the two-stage absorber; other mechanisms have neither.
fn law(p: &[f64], kind: &mut Kind) {
    if let Kind::TwoStage(absorber) = kind {
        absorber.preload_n = (absorber.preload_n + p[0]).max(0.0);
        absorber.brake_n = (absorber.brake_n + p[1]).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_are_added() {
        let absorber = r#"{"two_stage": {"preload_n": 30, "stiffness_n_per_m": 5e3, "second_stage_m": 0.05,
            "second_stiffness_n_per_m": 4e4, "brake_n": 10, "seat_stiffness_n_per_m": 1e6}}"#;
        let mut kind: Kind = serde_json::from_str(absorber).unwrap();
        law(&[5.0, -20.0], &mut kind);
        let Kind::TwoStage(absorber) = kind else {
            panic!("another kind")
        };
        assert_eq!([absorber.preload_n, absorber.brake_n], [35.0, 0.0]);
    }
}
