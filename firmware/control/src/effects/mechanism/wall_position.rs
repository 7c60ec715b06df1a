//! A wall that stands elsewhere than the model says.

use crate::effects::{Effect, Group, Naming, Parameter};
use crate::range::{SettingsError, in_range};
use crate::scalar::Scalar;

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "wall_position",
    title: "Position of the walls",
    summary: "the walls stand shifted along the axis, all in the same direction",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "pen = pen_nominal + shift_m n_x, n_x: component of the wall's outward normal along the axis",
    source: "geometry (error of the measured base frame of the robot)",
    signature: "contact begins too early at one wall and too late at the other, by the same distance",
    typical: "0.1 to 2 mm after a base calibration by hand",
    parameters: &[Parameter::new("shift_m", "m", -0.01, 0.01)],
    confused_with: &["contact_deadzone", "contact_stiffness", "clock_offset"],
    tell_apart: "touch both walls: a play makes contact late at both, a shift makes it early at one; with one \
                 wall only, the two are the same",
};

/// Walls shifted along one axis.
#[derive(Clone, Copy, Debug)]
pub struct WallPosition<S: Scalar> {
    shift_m: S,
}

impl<S: Scalar> WallPosition<S> {
    /// `shift_m` within ±10 m, positive along the axis.
    pub fn new(shift_m: f64) -> Result<Self, SettingsError> {
        in_range("shift_m", shift_m, -10.0, 10.0)?;
        Ok(Self {
            shift_m: S::of(shift_m),
        })
    }

    /// Penetration (m, negative outside) of the shifted wall, from that of the nominal wall;
    /// `normal_along_axis`: component of its outward normal along the axis, −1 to 1.
    pub fn penetration(&self, nominal_m: S, normal_along_axis: S) -> S {
        nominal_m + self.shift_m * normal_along_axis
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walls at ±20 mm whose free side is between them, both shifted by +1 mm.
    #[test]
    fn later_at_the_front_and_earlier_at_the_back() {
        let walls = WallPosition::<f64>::new(0.001).unwrap();
        let front = |x: f64| walls.penetration(x - 0.020, -1.0);
        let aft = |x: f64| walls.penetration(-0.020 - x, 1.0);
        assert!(front(0.021).abs() < 1e-15 && aft(-0.019).abs() < 1e-15);
    }
}
