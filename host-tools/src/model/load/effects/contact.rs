//! Ways in which a contact differs from a spring and damper.

use super::{LoadEffect, choice, free, positive, shape};
use crate::model::load::{Scene, Touch};

/// The effects.
pub(super) const EFFECTS: &[LoadEffect] = &[
    LoadEffect {
        id: "contact_damping",
        coefficients: &[positive("damping_n_s_per_m", "N·s/m")],
        shapes: &[choice("acts_at_once", "-", &[0.0, 1.0], 0.0)],
        separable: false,
        build: |scene, shapes| {
            let at_once = shapes[0] > 0.5;
            touched(scene).then(|| {
                vec![scene.wall_force(|t, n| {
                    let share = if at_once || t.damping_depth <= 0.0 {
                        1.0
                    } else {
                        (t.penetration[n] / t.damping_depth).min(1.0)
                    };
                    pushing(t, n) * share * t.rate[n]
                })]
            })
        },
    },
    LoadEffect {
        id: "hunt_crossley",
        coefficients: &[positive("damping_n_s_per_m2", "N·s/m^2")],
        shapes: &[choice("exponent", "-", &[1.0, 1.25, 1.5], 1.0)],
        separable: false,
        build: |scene, shapes| {
            touched(scene).then(|| {
                vec![
                    scene
                        .wall_force(|t, n| pushing(t, n) * depth(t, n).powf(shapes[0]) * t.rate[n]),
                ]
            })
        },
    },
    LoadEffect {
        id: "contact_cubic",
        coefficients: &[positive("stiffness_n_per_m3", "N/m^3")],
        shapes: &[choice("exponent", "-", &[3.0, 2.5, 2.0, 3.5], 3.0)],
        separable: false,
        build: |scene, shapes| {
            touched(scene).then(|| vec![scene.wall_force(|t, n| depth(t, n).powf(shapes[0]))])
        },
    },
    LoadEffect {
        id: "contact_deadzone",
        coefficients: &[],
        shapes: &[shape(
            "gap_m",
            "m",
            &[
                5e-6, 1e-5, 2e-5, 4e-5, 7e-5, 1e-4, 1.5e-4, 2.2e-4, 3e-4, 4.5e-4, 7e-4, 1e-3,
                1.5e-3, 2.5e-3,
            ],
            0.0,
        )],
        separable: false,
        build: |scene, shapes| touched(scene).then(|| vec![dead_zone(scene, shapes[0])]),
    },
    LoadEffect {
        id: "contact_stiffness",
        coefficients: &[free("stiffness_error_n_per_m", "N/m")],
        shapes: &[],
        separable: false,
        build: |scene, _| {
            touched(scene).then(|| vec![scene.wall_force(|t, n| pushing(t, n) * depth(t, n))])
        },
    },
    LoadEffect {
        id: "wall_position",
        coefficients: &[free("shift_m", "m")],
        shapes: &[choice("wall", "-", &[0.0, 1.0, 2.0, 3.0], 0.0)],
        separable: false,
        build: |scene, shapes| {
            let chosen = shapes[0] as usize;
            let normal = scene.touches.get(chosen)?.normal;
            touched(scene).then(|| {
                vec![scene.wall_force(|t, n| {
                    if t.normal == normal {
                        pushing(t, n) * t.stiffness
                    } else {
                        0.0
                    }
                })]
            })
        },
    },
];

fn touched(scene: &Scene) -> bool {
    scene
        .touches
        .iter()
        .any(|t| t.penetration.iter().any(|p| *p > 0.0))
}

fn depth(t: &Touch, n: usize) -> f64 {
    t.penetration[n].max(0.0)
}

/// 1 where the wall pushes, 0 where it does not touch or would have to pull.
fn pushing(t: &Touch, n: usize) -> f64 {
    if t.force[n] > 0.0 { 1.0 } else { 0.0 }
}

/// Change of the nominal force by a gap in front of the wall.
fn dead_zone(scene: &Scene, gap_m: f64) -> crate::model::load::Column {
    scene.wall_force(|t, n| {
        let deep = t.penetration[n] - gap_m;
        let share = if t.damping_depth > 0.0 {
            (deep / t.damping_depth).min(1.0)
        } else {
            1.0
        };
        let force = if deep > 0.0 {
            (t.stiffness * deep + t.damping * share * t.rate[n]).max(0.0)
        } else {
            0.0
        };
        force - t.force[n]
    })
}
