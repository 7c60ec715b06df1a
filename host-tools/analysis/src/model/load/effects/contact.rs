//! Ways in which a contact differs from a spring and damper.

use super::{LoadEffect, choice, form_size, free, positive, shape};
use crate::model::load::{Column, Scene, Touch};
use nalgebra::Vector3;

/// What an effect adds to the push of a wall per unit of its coefficient, where the tip is in the
/// wall; with the shape parameters of the effect.
type Push = fn(&[f64], &Touch, usize) -> f64;

/// The effects that add to the push, and with that can also take it away: a wall does not pull.
const PUSHES: [(&str, Push); 4] = [
    ("contact_damping", damping),
    ("hunt_crossley", hunt_crossley),
    ("contact_cubic", cubic),
    ("contact_stiffness", stiffness),
];

/// The effects.
pub(super) const EFFECTS: &[LoadEffect] = &[
    LoadEffect {
        id: "contact_damping",
        coefficients: &[positive("damping_n_s_per_m", "N·s/m")],
        shapes: &[choice("acts_at_once", "-", &[0.0, 1.0], 0.0)],
        separable: false,
        build: |scene, shapes| pushed(scene, shapes, damping),
    },
    LoadEffect {
        id: "hunt_crossley",
        coefficients: &[positive("damping_n_s_per_m2", "N·s/m^2")],
        shapes: &[choice("exponent", "-", &[1.0, 1.25, 1.5], 1.0)],
        separable: false,
        build: |scene, shapes| pushed(scene, shapes, hunt_crossley),
    },
    LoadEffect {
        id: "contact_cubic",
        coefficients: &[positive("stiffness_n_per_m3", "N/m^3")],
        shapes: &[choice("exponent", "-", &[3.0, 2.5, 2.0, 3.5], 3.0)],
        separable: false,
        build: |scene, shapes| pushed(scene, shapes, cubic),
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
        build: |scene, shapes| pushed(scene, shapes, stiffness),
    },
    LoadEffect {
        id: "wall_position",
        coefficients: &[free("shift_m", "m")],
        shapes: &[choice("wall", "-", &[0.0, 1.0, 2.0, 3.0, 4.0], 0.0)],
        separable: false,
        build: |scene, shapes| {
            let shifts = shifts(scene, shapes)?;
            touched(scene)
                .then(|| vec![scene.wall_force(|t, n| pushing(t, n) * t.stiffness * shifts(t))])
        },
    },
    LoadEffect {
        id: "contact_coulomb",
        coefficients: &[positive("friction_coefficient", "-")],
        shapes: &[form_size(
            "smoothing_speed_m_s",
            "m/s",
            &[1e-4, 3e-4, 1e-3, 3e-3, 1e-2],
            1e-3,
        )],
        separable: false,
        build: |scene, shapes| {
            let column = dry_friction(scene, shapes[0]);
            (!column.is_zero()).then(|| vec![column])
        },
    },
];

/// The column of an effect with a coefficient that is known, so that times the coefficient it is the
/// effect exactly, with lift-off and touch where they then are; None for effects whose columns do not
/// depend on it.
pub(super) fn exact(id: &str, scene: &Scene, shapes: &[f64], coefficient: f64) -> Option<Column> {
    if coefficient == 0.0 {
        return None;
    }
    let column = |force: &dyn Fn(&Touch, usize) -> f64| {
        scene.wall_force(|t, n| (force(t, n) - t.force[n]) / coefficient)
    };
    if id == "wall_position" {
        let shifts = shifts(scene, shapes)?;
        return Some(column(&|t, n| {
            push_at(t, n, t.penetration[n] + coefficient * shifts(t)).max(0.0)
        }));
    }
    let (_, push) = PUSHES.into_iter().find(|(known, _)| *known == id)?;
    Some(column(&|t, n| {
        let more = if t.penetration[n] > 0.0 {
            coefficient * push(shapes, t, n)
        } else {
            0.0
        };
        (push_at(t, n, t.penetration[n]) + more).max(0.0)
    }))
}

/// The column of an effect for small coefficients: where the wall pushes without it.
fn pushed(scene: &Scene, shapes: &[f64], push: Push) -> Option<Vec<Column>> {
    touched(scene).then(|| vec![scene.wall_force(|t, n| pushing(t, n) * push(shapes, t, n))])
}

/// Shapes: 1 if the damping acts in full as soon as the tip touches.
fn damping(shapes: &[f64], t: &Touch, n: usize) -> f64 {
    let share = if shapes[0] > 0.5 {
        1.0
    } else {
        share_of_damping(t, t.penetration[n])
    };
    share * t.rate[n]
}

/// Shapes: the exponent of the depth.
fn hunt_crossley(shapes: &[f64], t: &Touch, n: usize) -> f64 {
    depth(t, n).powf(shapes[0]) * t.rate[n]
}

/// Shapes: the exponent of the depth.
fn cubic(shapes: &[f64], t: &Touch, n: usize) -> f64 {
    depth(t, n).powf(shapes[0])
}

fn stiffness(_: &[f64], t: &Touch, n: usize) -> f64 {
    depth(t, n)
}

/// Penetration of each wall by the shift along the axis: of all walls (shape 0), or of that with
/// this number alone; None if there is no such wall.
fn shifts<'a>(scene: &'a Scene, shapes: &[f64]) -> Option<impl Fn(&Touch) -> f64 + 'a> {
    let only = match shapes[0] as usize {
        0 => None,
        number => Some(scene.touches.get(number - 1)?.normal),
    };
    Some(move |t: &Touch| match only {
        Some(normal) if normal != t.normal => 0.0,
        _ => t.normal.dot(&scene.axis),
    })
}

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

fn share_of_damping(t: &Touch, penetration: f64) -> f64 {
    if t.damping_depth > 0.0 {
        (penetration / t.damping_depth).min(1.0)
    } else {
        1.0
    }
}

/// What the nominal wall would push at a depth, and pull where it cannot.
fn push_at(t: &Touch, n: usize, depth: f64) -> f64 {
    if depth <= 0.0 {
        return 0.0;
    }
    t.stiffness * depth + t.damping * share_of_damping(t, depth) * t.rate[n]
}

/// Friction across the normal for a coefficient of 1, as
/// [`softdock_control::effects::mechanism::contact_coulomb`] has it.
fn dry_friction(scene: &Scene, smoothing_speed: f64) -> Column {
    scene.force_of_walls(|t, n| {
        if t.force[n] <= 0.0 {
            return Vector3::zeros();
        }
        let (_, velocity) = scene.point(n, &t.tip);
        let sliding = velocity - t.normal * t.normal.dot(&velocity);
        sliding * (-t.force[n] / sliding.norm().hypot(smoothing_speed))
    })
}

/// Change of the nominal force by a gap in front of the wall.
fn dead_zone(scene: &Scene, gap_m: f64) -> Column {
    scene.wall_force(|t, n| push_at(t, n, t.penetration[n] - gap_m).max(0.0) - t.force[n])
}
