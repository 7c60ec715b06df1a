//! Dead zone of the velocity command: the overlap of a valve's spool.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "command_deadzone",
    title: "Dead zone of the command",
    summary: "small commands move nothing, and larger ones what they have beyond the zone",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "v = u - clamp(u, centre_m_s - width_m_s/2, centre_m_s + width_m_s/2)",
    source: "textbook (dead zone; overlap of a hydraulic valve's spool, Merritt 1967, chapter 5)",
    signature: "executed velocity is zero for small commands, and too small by half of the width for all others; the \
                pose stands still around each reversal of the command",
    typical: "5 to 30 % of the largest command of a proportional valve; nothing on an electric servo drive",
    parameters: &[
        Parameter::new("width_m_s", "m/s", 0.0, 100.0)
            .of_rotations(0.0, 100.0)
            .hidden(2e-3, 4e-3)
            .pictured(0.02),
        Parameter::new("centre_m_s", "m/s", -100.0, 100.0).of_rotations(-100.0, 100.0),
    ],
    confused_with: &["command_quantisation", "zero_cross_pause", "backlash"],
    tell_apart: "a slow ramp of the velocity through zero: behind a dead zone it begins without a jump where the \
                 command leaves the zone; rounding makes stairs, and a pause or a play comes only after a reversal",
    law: Law::Actuator(Actuator {
        axis: Some(|p, _| CommandDeadZone::new(p[0], p[1]).map(AxisStage::DeadZone)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Dead zone of one axis' command.
#[derive(Clone, Copy, Debug)]
pub struct CommandDeadZone {
    low: f64,
    high: f64,
}

impl CommandDeadZone {
    /// `width_m_s` 0 (no effect) to 100, `centre_m_s` −100 to 100; both in the unit of the axis.
    pub fn new(width_m_s: f64, centre_m_s: f64) -> Result<Self, SettingsError> {
        in_range("width_m_s", width_m_s, 0.0, 100.0)?;
        in_range("centre_m_s", centre_m_s, -100.0, 100.0)?;
        Ok(Self {
            low: centre_m_s - 0.5 * width_m_s,
            high: centre_m_s + 0.5 * width_m_s,
        })
    }

    /// The command minus its part within the zone.
    pub fn apply(&self, input: f64) -> f64 {
        input - input.clamp(self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_counts_from_the_edge_of_the_zone() {
        let axis = CommandDeadZone::new(0.5, 0.125).unwrap();
        let got = [-0.5, -0.125, 0.0, 0.375, 1.0].map(|u| axis.apply(u));
        assert_eq!(got, [-0.375, 0.0, 0.0, 0.0, 0.625]);
        let none = CommandDeadZone::new(0.0, 0.0).unwrap();
        assert_eq!(none.apply(0.1), 0.1);
    }
}
