//! Play before the spring of a contact is met.

use crate::effects::{Effect, Facing, Group, Law, Naming, Parameter};

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
    parameters: &[Parameter::new("gap_m", "m", 0.0, 0.01)
        .shape(
            &[
                5e-6, 1e-5, 2e-5, 4e-5, 7e-5, 1e-4, 1.5e-4, 2.2e-4, 3e-4, 4.5e-4, 7e-4, 1e-3,
                1.5e-3, 2.5e-3,
            ],
            0.0,
        )
        .hidden(3e-4, 8e-4)
        .pictured(0.0015)],
    confused_with: &[
        "wall_position",
        "contact_cubic",
        "contact_stiffness",
        "backlash",
    ],
    tell_apart: "touch both walls slowly and deeply: a play shifts the foot and keeps the slope, stiffening \
                 changes the slope with depth, a shifted wall is early at one side",
    law: Law::Depth(depth),
    ..Effect::PLAIN
};

/// The gap is crossed first.
fn depth(p: &[f64], nominal: f64, _: &Facing) -> f64 {
    nominal - p[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_crossed_first() {
        let facing = Facing {
            along_axis: -1.0,
            number: 1,
        };
        assert_eq!(
            [0.125, 0.75].map(|x| depth(&[0.25], x, &facing)),
            [-0.125, 0.5]
        );
    }
}
