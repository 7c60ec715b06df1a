//! Forces of guide and cables on the moving side.

use super::{Coefficient, LoadEffect, Shape, choice, form_size, free, positive, shape};
use crate::model::load::{Column, Scene};
use nalgebra::Vector3;

/// Speed over which a dry friction changes its sign, m/s.
const SMOOTHING: Shape = form_size(
    "smoothing_speed_m_s",
    "m/s",
    &[0.0, 3e-4, 8e-4, 2e-3, 5e-3],
    0.0,
);

/// The same where the speed dependence is searched as well.
const COARSE_SMOOTHING: Shape = form_size("smoothing_speed_m_s", "m/s", &[0.0, 8e-4, 5e-3], 0.0);

/// Distance over which a dry friction builds up after a reversal, m.
const PRESLIDING: Shape = form_size(
    "presliding_m",
    "m",
    &[0.0, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5],
    0.0,
);

/// Where the force acts: 0 at M, 1 at the tip, 2 at the sensor's origin (no torque).
const ACTS_AT: Shape = choice("acts_at", "-", &[0.0, 1.0, 2.0], 0.0);

const COULOMB: &[Coefficient] = &[positive("force_n", "N")];
const STRIBECK: &[Coefficient] = &[positive("coulomb_n", "N"), positive("excess_n", "N")];
const ASYMMETRY: &[Coefficient] = &[
    positive("forward_n", "N"),
    positive("backward_n", "N"),
    free("viscous_difference_n_s_per_m", "N·s/m"),
];

/// The effects.
pub(super) const EFFECTS: &[LoadEffect] = &[
    LoadEffect {
        id: "guide_coulomb",
        coefficients: COULOMB,
        shapes: &[SMOOTHING, PRESLIDING, ACTS_AT],
        separable: false,
        build: |scene, shapes| {
            let [smoothing, presliding, at] = *shapes else {
                return None;
            };
            // Either the speed rounds the reversal off, or the distance does.
            if !moving(scene) || (smoothing > 0.0 && presliding > 0.0) {
                return None;
            }
            Some(vec![match presliding > 0.0 {
                true => built_up(scene, presliding, at),
                false => friction(scene, smoothing, at, |_| 1.0),
            }])
        },
    },
    LoadEffect {
        id: "guide_viscous",
        coefficients: &[positive("damping_n_s_per_m", "N·s/m")],
        shapes: &[ACTS_AT],
        separable: false,
        build: |scene, shapes| {
            let at = shapes[0];
            moving(scene).then(|| vec![scene.guide_force(at, |n| -scene.along(n, at))])
        },
    },
    LoadEffect {
        id: "guide_stribeck",
        coefficients: STRIBECK,
        shapes: &[
            shape(
                "stribeck_speed_m_s",
                "m/s",
                &[1e-3, 2e-3, 3.5e-3, 6e-3, 1e-2, 2e-2],
                5e-3,
            ),
            COARSE_SMOOTHING,
            ACTS_AT,
        ],
        separable: false,
        build: |scene, shapes| {
            let speed = shapes[0].max(1e-6);
            moving(scene).then(|| {
                vec![
                    friction(scene, shapes[1], shapes[2], |_| 1.0),
                    friction(scene, shapes[1], shapes[2], |v| {
                        (-(v / speed).powi(2)).exp()
                    }),
                ]
            })
        },
    },
    LoadEffect {
        id: "guide_asymmetry",
        coefficients: ASYMMETRY,
        shapes: &[SMOOTHING, ACTS_AT],
        separable: true,
        build: |scene, shapes| {
            let (smoothing, at) = (shapes[0], shapes[1]);
            let forward = |v: f64| if v > 0.0 { 1.0 } else { 0.0 };
            let backward = |v: f64| if v < 0.0 { 1.0 } else { 0.0 };
            moving(scene).then(|| {
                vec![
                    friction(scene, smoothing, at, forward),
                    friction(scene, smoothing, at, backward),
                    scene.guide_force(at, |n| -scene.along(n, at).abs()),
                ]
            })
        },
    },
    LoadEffect {
        id: "cable_stiffness",
        coefficients: &[positive("stiffness_n_per_m", "N/m")],
        shapes: &[choice("about_start", "-", &[0.0, 1.0], 0.0), ACTS_AT],
        separable: false,
        build: |scene, shapes| {
            moving(scene).then(|| vec![cable(scene, shapes[0] > 0.5, shapes[1])])
        },
    },
    LoadEffect {
        id: "guide_offset",
        coefficients: &[free("force_n", "N")],
        shapes: &[ACTS_AT],
        separable: false,
        build: |scene, shapes| moving(scene).then(|| vec![scene.guide_force(shapes[0], |_| 1.0)]),
    },
    LoadEffect {
        id: "guide_hysteresis",
        coefficients: &[positive("force_n", "N")],
        shapes: &[shape(
            "displacement_m",
            "m",
            &[2e-5, 5e-5, 1e-4, 2e-4, 4e-4, 8e-4, 1.5e-3, 3e-3],
            1e-3,
        )],
        separable: false,
        build: |scene, shapes| moving(scene).then(|| vec![hysteresis(scene, shapes[0])]),
    },
];

/// Whether anything moves along the guide.
fn moving(scene: &Scene) -> bool {
    !scene.model.sensor.at_rest && (0..scene.len()).any(|n| scene.along(n, 0.0) != 0.0)
}

/// Friction against the motion along the guide, with a size that depends on the speed.
fn friction(scene: &Scene, smoothing_m_s: f64, acts_at: f64, size: impl Fn(f64) -> f64) -> Column {
    scene.guide_force(acts_at, |n| {
        let v = scene.along(n, acts_at);
        let sign = if smoothing_m_s > 0.0 {
            (v / smoothing_m_s).tanh()
        } else if v == 0.0 {
            0.0
        } else {
            v.signum()
        };
        -sign * size(v)
    })
}

/// A spring in all directions on M, about the origin of C or about the first position.
fn cable(scene: &Scene, about_start: bool, acts_at: f64) -> Column {
    let at = scene.point_of_action(acts_at);
    let position = |n: usize| scene.pose[n].translation.vector + scene.pose[n].rotation * at - at;
    let rest = if about_start && !scene.is_empty() {
        position(0)
    } else {
        Vector3::zeros()
    };
    Column::of(scene.len(), |n| {
        scene.reading_of(n, &at, &(rest - position(n)))
    })
}

/// Dry friction of unit force that builds up over a distance (Dahl 1968):
/// `dz/dx = (1 − sgn(dx) z) / d`, F = −z.
fn built_up(scene: &Scene, presliding_m: f64, acts_at: f64) -> Column {
    let mut z = 0.0_f64;
    let mut last = 0.0;
    scene.guide_force(acts_at, |n| {
        let v = scene.along(n, acts_at);
        // The path of a velocity that is straight between two cycles, cut at its reversal.
        let path = |v: f64, share: f64| 0.5 * v * share * scene.cycle_s;
        let crossing = if last * v < 0.0 {
            last / (last - v)
        } else {
            1.0
        };
        let pieces = match last * v < 0.0 {
            true => [path(last, crossing), path(v, 1.0 - crossing)],
            false => [path(last + v, 1.0), 0.0],
        };
        for moved in pieces {
            let towards = moved.signum();
            z = towards + (z - towards) * (-moved.abs() / presliding_m).exp();
        }
        last = v;
        -z
    })
}

/// Bouc-Wen hysteresis with unit force: `dz/dx = (1 − sgn(dx) z) / d`, F = −z.
fn hysteresis(scene: &Scene, displacement_m: f64) -> Column {
    let mut z = 0.0_f64;
    let mut last: Option<f64> = None;
    scene.guide_force(0.0, |n| {
        let x = scene.axis.dot(&scene.pose[n].translation.vector);
        let moved = x - last.replace(x).unwrap_or(x);
        // Exact over a step in one direction.
        let towards = moved.signum();
        z = towards + (z - towards) * (-moved.abs() / displacement_m.max(1e-9)).exp();
        -z
    })
}
