//! A wall that stands elsewhere than the model says.

use crate::effects::{Effect, Facing, Group, Law, Naming, Parameter};

/// Catalogue entry.
pub const EFFECT: Effect = Effect {
    id: "wall_position",
    title: "Position of the walls",
    summary: "the walls stand shifted along the axis (of a bearing, the tip's way), all in one direction",
    group: Group::Mechanism,
    naming: Naming::Cause,
    equation: "pen = pen_nominal + shift_m n_x, n_x: component of the wall's outward normal along the axis, or along the tip's way at that instant",
    source: "geometry (error of the measured base frame of the robot)",
    signature: "contact begins too early at one wall and too late at the other, by the same distance",
    typical: "0.1 to 2 mm after a base calibration by hand",
    parameters: &[
        Parameter::new("shift_m", "m", -0.01, 0.01)
            .hidden(4e-4, 1e-3)
            .either_sign()
            .pictured(0.0015),
        // 0: all walls; else only the wall with this number.
        Parameter::new("wall", "-", 0.0, 8.0).form(&[0.0, 1.0, 2.0, 3.0, 4.0], 0.0),
    ],
    confused_with: &["contact_deadzone", "contact_stiffness", "clock_offset"],
    tell_apart: "touch both walls: a play makes contact late at both, a shift makes it early at one; with one \
                 wall only, the two are the same",
    law: Law::Depth(depth),
    ..Effect::PLAIN
};

/// A wall that is shifted along the axis is met later from behind and earlier from the front.
fn depth(p: &[f64], nominal: f64, facing: &Facing) -> f64 {
    let stands_elsewhere = p[1] == 0.0 || p[1] == facing.number as f64;
    nominal
        + if stands_elsewhere {
            p[0] * facing.along_axis
        } else {
            0.0
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walls at ±20 mm with the free space between them, both shifted by +1 mm.
    #[test]
    fn later_at_the_front_and_earlier_at_the_back() {
        let front = Facing {
            along_axis: -1.0,
            number: 1,
        };
        let back = Facing {
            along_axis: 1.0,
            number: 2,
        };
        assert_eq!(depth(&[0.001, 0.0], 0.003, &front), 0.002);
        assert_eq!(depth(&[0.001, 0.0], 0.003, &back), 0.004);
        assert_eq!(depth(&[0.001, 1.0], 0.003, &back), 0.003);
    }
}
