//! Errors of the nominal parameters of tool, sensor and base.

use super::{Coefficient, LoadEffect, free};
use crate::model::Model;
use crate::model::load::{Column, Scene};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const COM: &[Coefficient] = &[
    free("com_x_m", "m"),
    free("com_y_m", "m"),
    free("com_z_m", "m"),
];
const TILT: &[Coefficient] = &[free("rx_rad", "rad"), free("ry_rad", "rad")];
const TURN: &[Coefficient] = &[
    free("rx_rad", "rad"),
    free("ry_rad", "rad"),
    free("rz_rad", "rad"),
];
const BIAS: &[Coefficient] = &[
    free("fx_n", "N"),
    free("fy_n", "N"),
    free("fz_n", "N"),
    free("tx_n_m", "N·m"),
    free("ty_n_m", "N·m"),
    free("tz_n_m", "N·m"),
];

/// The effects.
pub(super) const EFFECTS: &[LoadEffect] = &[
    LoadEffect {
        id: "tool_inertia",
        coefficients: &[super::positive("mass_kg", "kg")],
        shapes: &[],
        separable: false,
        build: |scene, _| {
            let missing = !scene.model.tool.dynamic_compensation && scene.model.tool.mass_kg > 0.0;
            // The tool's inertia as a whole grows with its mass: per kilogram that moves.
            let mass_kg = scene.model.tool.mass_kg;
            let column = changed(scene, mass_kg, |m, _| m.tool.dynamic_compensation = true);
            (missing && !column.is_zero()).then(|| vec![column])
        },
    },
    LoadEffect {
        id: "tool_mass_error",
        coefficients: &[free("mass_error_kg", "kg")],
        shapes: &[],
        separable: false,
        build: |scene, _| Some(vec![changed(scene, 0.1, |m, step| m.tool.mass_kg += step)]),
    },
    LoadEffect {
        id: "tool_com_error",
        coefficients: COM,
        shapes: &[],
        separable: true,
        build: |scene, _| {
            let mass_kg = effective_mass(&scene.model);
            Some(
                (0..3)
                    .map(|i| {
                        // The change of the lever alone, with the mass that hangs on it.
                        let mut heavy = scene.model.clone();
                        heavy.tool.mass_kg = mass_kg;
                        let mut shifted = heavy.clone();
                        shifted.tool.com_m[i] += COM_STEP_M;
                        scene.difference(&heavy, &shifted, 1.0 / COM_STEP_M)
                    })
                    .collect(),
            )
        },
    },
    LoadEffect {
        id: "base_tilt",
        coefficients: TILT,
        shapes: &[],
        separable: true,
        build: |scene, _| {
            Some(
                (0..2)
                    .map(|i| changed(scene, 1e-4, |m, step| tilt(m, i, step)))
                    .collect(),
            )
        },
    },
    LoadEffect {
        id: "ft_mounting",
        coefficients: TURN,
        shapes: &[],
        separable: true,
        build: |scene, _| {
            Some(
                (0..3)
                    .map(|i| changed(scene, 1e-4, |m, step| turn(m, i, step)))
                    .collect(),
            )
        },
    },
    LoadEffect {
        id: "ft_bias",
        coefficients: BIAS,
        shapes: &[],
        separable: true,
        build: |scene, _| {
            Some(
                (0..6)
                    .map(|i| changed(scene, 1.0, |m, step| m.sensor.bias[i] += step))
                    .collect(),
            )
        },
    },
];

/// Step of the centre of mass for its derivative, m.
const COM_STEP_M: f64 = 1e-3;

/// Mass on which a shift of the centre of mass acts: the nominal one, with an error of it that the
/// model knows; 1 kg where the model has neither, so that a fit gives the product of both.
fn effective_mass(model: &Model) -> f64 {
    let added = model.effects.iter().filter(|e| e.id == "tool_mass_error");
    let error: f64 = added
        .filter_map(|e| e.parameters.get("mass_error_kg"))
        .sum();
    match model.tool.mass_kg {
        0.0 if error <= 0.0 => 1.0,
        0.0 => error,
        nominal => nominal,
    }
}

/// Derivative of the reading by a parameter that `change` moves by `step`.
fn changed(scene: &Scene, step: f64, change: impl Fn(&mut Model, f64)) -> Column {
    let mut other = scene.model.clone();
    change(&mut other, step);
    scene.change(&other, 1.0 / step)
}

/// Turns gravity about an axis of C.
pub(crate) fn tilt(model: &mut Model, axis: usize, angle_rad: f64) {
    let turned = UnitQuaternion::from_scaled_axis(Vector3::ith(axis, angle_rad))
        * Vector3::from(model.sensor.gravity_m_s2);
    model.sensor.gravity_m_s2 = turned.into();
}

/// Turns the sensor about one of its axes.
pub(crate) fn turn(model: &mut Model, axis: usize, angle_rad: f64) {
    let [w, x, y, z] = model.sensor.orientation_wxyz;
    let turned = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
        * UnitQuaternion::from_scaled_axis(Vector3::ith(axis, angle_rad));
    model.sensor.orientation_wxyz = [turned.w, turned.i, turned.j, turned.k];
}
