//! Offset between the clocks of robot and sensor.

use crate::effects::{Effect, Group, Kind, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "clock_offset",
    title: "Offset of the clocks",
    summary: "the time stamps of wrench and motion are shifted against each other",
    group: Group::Body,
    naming: Naming::Cause,
    equation: "t_pose = t_wrench + offset_s for the same instant",
    source: "textbook (clock synchronisation)",
    signature: "wrench and pose fit after a shift in time, in the log only: the loop itself is not late",
    typical: "0.5 to 20 ms between logs of two computers",
    parameters: &[Parameter::new("offset_s", "s", -1.0, 1.0)
        // A reading that is late is a latency.
        .delay_or_lag()
        .hidden(0.006, 0.012)
        .either_sign()
        .pictured(-0.02)],
    confused_with: &["ft_latency", "actuation_delay", "clock_rate"],
    tell_apart: "log both on one clock, or, with a rig, close the loop on an elastic bounce: a latency makes the rebound \
                 faster than the approach, an offset of the log does not; an offset may be negative, a latency cannot",
    law: Law::ClockOffset(|p| p[0]),
    kind: Some(Kind::LateReading),
    ..Effect::PLAIN
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_late_by_it() {
        let Law::ClockOffset(law) = EFFECT.law else {
            panic!("two clocks");
        };
        assert_eq!(law(&[-0.25]), -0.25);
    }
}
