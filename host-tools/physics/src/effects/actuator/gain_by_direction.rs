//! Gain of the velocity that differs by direction.

use super::AxisStage;
use crate::effects::{Actuator, Effect, Group, Law, Naming, Parameter};
use softdock_control::range::{SettingsError, in_range};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "gain_by_direction",
    title: "Gain by direction",
    summary: "the same command moves an axis faster one way than the other",
    group: Group::Actuator,
    naming: Naming::Cause,
    equation: "v = (1 + asymmetry) u for u > 0, (1 - asymmetry) u for u < 0",
    source: "textbook (a hydraulic cylinder with a rod on one side has two areas, Merritt 1967, chapter 6)",
    signature: "executed over commanded velocity has one value forth and another back; after a motion to and fro the \
                pose has drifted",
    typical: "0.1 to 0.3 of a cylinder with a rod on one side, more of an arm that hangs on one; below 0.01 of a servo drive",
    parameters: &[Parameter::new("asymmetry", "-", -0.95, 0.95)
        .hidden(0.05, 0.15)
        .either_sign()
        .pictured(0.3)],
    confused_with: &["velocity_gain", "command_deadzone", "velocity_saturation"],
    tell_apart: "equal distances forth and back at two speeds: with two gains the ratio of the velocities stays, \
                 behind a dead zone it changes with the speed",
    law: Law::Actuator(Actuator {
        axis: Some(|p, _| GainByDirection::new(p[0]).map(AxisStage::Direction)),
        late: None,
    }),
    ..Effect::PLAIN
};

/// Gains of one axis, forth and back.
#[derive(Clone, Copy, Debug)]
pub struct GainByDirection {
    forth: f64,
    back: f64,
}

impl GainByDirection {
    /// `asymmetry` −1 (moves back only) to 1 (moves forth only).
    pub fn new(asymmetry: f64) -> Result<Self, SettingsError> {
        in_range("asymmetry", asymmetry, -1.0, 1.0)?;
        Ok(Self {
            forth: 1.0 + asymmetry,
            back: 1.0 - asymmetry,
        })
    }

    /// The executed velocity.
    pub fn apply(&self, input: f64) -> f64 {
        input * if input > 0.0 { self.forth } else { self.back }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_faster_forth() {
        let axis = GainByDirection::new(0.25).unwrap();
        assert_eq!(
            [0.5, 0.0, -0.5].map(|u| axis.apply(u)),
            [0.625, 0.0, -0.375]
        );
    }
}
