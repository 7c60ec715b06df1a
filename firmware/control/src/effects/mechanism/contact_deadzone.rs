//! Play before the spring of a contact is met.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "contact_deadzone",
    title: "Play before the contact",
    summary: "the mechanism moves by a play before its spring is met",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "pen = max(0, pen_nominal - gap_m)",
    source: "textbook (dead zone)",
    signature: "force against penetration keeps its slope, but its foot is shifted into the wall; it shows at \
                every wall",
    typical: "0.05 to 1 mm in latches and bolted joints",
    parameters: &[Parameter::new("gap_m", "m", 0.0, 0.01)],
    confused_with: &[
        "wall_position",
        "contact_cubic",
        "contact_stiffness",
        "backlash",
    ],
    tell_apart: "touch both walls slowly and deeply: a play shifts the foot and keeps the slope, stiffening \
                 changes the slope with depth, a shifted wall is early at one side",
};

/// Play in front of a spring.
#[derive(Clone, Copy, Debug)]
pub struct DeadZone<S: Scalar> {
    gap_m: S,
}

impl<S: Scalar> DeadZone<S> {
    /// `gap_m` 0 to 10 m.
    pub fn new(gap_m: f64) -> Result<Self, SettingsError> {
        in_range("gap_m", gap_m, 0.0, 10.0)?;
        Ok(Self {
            gap_m: S::of(gap_m),
        })
    }

    /// Penetration of the spring (m, not negative) from that into the surface.
    pub fn penetration(&self, nominal_m: S) -> S {
        (nominal_m - self.gap_m).max(S::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_crossed_first() {
        let play = DeadZone::<f64>::new(0.25).unwrap();
        assert_eq!(
            [-1.0, 0.125, 0.75].map(|p| play.penetration(p)),
            [0.0, 0.0, 0.5]
        );
    }
}
