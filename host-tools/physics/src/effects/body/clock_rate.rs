//! Rate of the control cycle's clock.

use crate::effects::{Clock, Effect, Group, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "clock_rate",
    title: "Rate of the clock",
    summary: "a cycle lasts longer or shorter than nominal",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "t = (1 + rate_error) t_nominal",
    source: "textbook (clock rate); crystals are within 100 ppm",
    signature: "the pose moves by a wrong factor of the integrated velocity, in all axes alike, while the \
                velocities fit",
    typical: "below 1e-4; 2 % where a cycle of 4 ms is counted for 4.08 ms",
    parameters: &[Parameter::new("rate_error", "-", -0.1, 0.1)
        .hidden(0.03, 0.06)
        .either_sign()
        .pictured(0.08)],
    confused_with: &["velocity_gain", "clock_jitter", "clock_offset"],
    tell_apart: "jog over a measured distance: velocity fits and distance does not; the factor is the same for \
                 every axis, a gain may differ",
    law: Law::Clock(Clock::Rate(|p| p[0])),
    ..Effect::PLAIN
};

#[cfg(test)]
mod tests {
    use super::*;

    /// A cycle of 4 ms that is counted for 4.08 ms.
    #[test]
    fn a_second_is_longer_by_its_error() {
        let Law::Clock(Clock::Rate(law)) = EFFECT.law else {
            panic!("a rate");
        };
        assert_eq!(0.004 * (1.0 + law(&[0.02])), 0.00408);
    }
}
