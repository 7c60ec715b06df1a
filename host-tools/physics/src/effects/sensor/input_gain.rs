//! Gain of a drive whose commanded force is recorded.

use crate::effects::{Effect, Group, Law, Naming, Parameter};
use softdock_control::frames::Wrench;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "input_gain",
    title: "Gain of the drive's input",
    summary: "the drive needs another command than the nominal one for a force",
    group: Group::Sensor,
    naming: Naming::Cause,
    equation: "W_commanded = (1 + surplus) W; divide the mapping's scale of the command by 1 + surplus",
    source: "data sheets of motors and valves (torque constant, pressure times area)",
    signature: "the whole command is too large or too small by a factor, whatever the motion",
    typical: "5 to 10 % of a motor's torque constant; any factor where volts or counts were scaled by guess",
    parameters: &[Parameter::new("surplus", "-", -0.9, 9.0).pictured(0.25)],
    confused_with: &["tool_mass_error", "contact_stiffness", "ft_bias"],
    tell_apart: "let the drive hold a known weight or a spring of known stiffness: a gain shows there, a wrong mass \
                 only while it accelerates; without any nominal load no log can tell the gain",
    law: Law::CommandGain(commanded),
    ..Effect::PLAIN
};

/// The same factor on all axes: one drive, or several of one make.
fn commanded(p: &[f64], force: &Wrench<f64>) -> Wrench<f64> {
    *force * (1.0 + p[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 N/A are assumed and 16 are true: 4 N take 0.25 A, which count as 5 N.
    #[test]
    fn a_weaker_motor_needs_more() {
        let force = Wrench::of(&[4.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(commanded(&[0.25], &force).get()[0], 5.0);
    }
}
