//! The model that a `meta.json` describes.

use super::meta::{Contact, Meta, Noise, Rotation};
use super::tolerance;
use anyhow::{bail, ensure};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use softdock_physics::model::{
    ActuatorModel, Axis, BodyModel, ContactModel, GuideModel, Model, NoiseModel, RigModel,
    SensorModel, ToolModel, TwoBodyModel, WallModel,
};

/// How far a rotation matrix may be from orthonormal: what four decimals leave.
const ORTHONORMAL: f64 = 1e-3;

/// The model; what could not be taken over is told in `notes`.
///
/// # Errors
///
/// A value out of its range, or an orientation that is none.
pub(super) fn model(meta: &Meta, notes: &mut Vec<String>) -> anyhow::Result<Model> {
    let model = Model {
        rig: RigModel {
            active_axes: active_axes(&meta.dof_mask),
        },
        actuator: ActuatorModel {
            transport_delay_s: meta.actuator.transport_delay_s,
            lag_s: meta.actuator.lag_time_constant_s,
        },
        contact: meta
            .contact
            .as_ref()
            .map(|c| contact(c, meta.geometry.r_tip_m, notes))
            .unwrap_or_default(),
        tool: ToolModel {
            mass_kg: meta.tool.mass_kg,
            com_m: meta.tool.com_m,
            inertia_kg_m2: meta.tool.inertia_kg_m2,
            dynamic_compensation: meta.tool.dynamic_compensation,
        },
        sensor: sensor(meta)?,
        bodies: TwoBodyModel {
            k: BodyModel {
                mass_kg: Some(meta.spacecraft.mass_kg),
                inertia_kg_m2: Some(meta.spacecraft.inertia_kg_m2),
                ..BodyModel::default()
            },
            q: BodyModel::default(),
        },
        noise: noise(&meta.noise_sigma),
        tolerance: match &meta.tolerance {
            Some(paths) => tolerance::tolerance(paths, notes)?,
            None => tolerance::unstated(),
        },
        ..Model::default()
    };
    model
        .validate()
        .map_err(|error| anyhow::anyhow!("meta.json, by the names of model.toml: {error}"))?;
    Ok(model)
}

fn sensor(meta: &Meta) -> anyhow::Result<SensorModel> {
    Ok(SensorModel {
        position_m: meta.geometry.r_sensor_m,
        orientation_wxyz: orientation(&meta.geometry.m_from_s)?,
        bias: meta.ft_sensor.bias,
        gravity_m_s2: meta.gravity_m_s2,
        ..SensorModel::default()
    })
}

fn noise(sigma: &Noise) -> NoiseModel {
    NoiseModel {
        force_n: sigma.force_n,
        torque_n_m: sigma.torque_n_m,
        velocity_m_s: sigma.velocity_m_s,
        rate_rad_s: sigma.rate_rad_s,
        position_m: sigma.position_m,
        angle_rad: sigma.angle_rad,
        ..NoiseModel::default()
    }
}

fn active_axes(mask: &[f64; 6]) -> Vec<Axis> {
    let axes = Axis::ALL.into_iter().zip(mask);
    axes.filter(|(_, moves)| **moves != 0.0)
        .map(|(axis, _)| axis)
        .collect()
}

/// Two walls across x, and a guide along it.
fn contact(contact: &Contact, tip_m: [f64; 3], notes: &mut Vec<String>) -> ContactModel {
    if let Some(law) = contact.law.as_deref().filter(|law| *law != "linear") {
        notes.push(format!(
            "meta.json: the contact law `{law}` is not known; the linear one is used"
        ));
    }
    let wall = |x: Option<f64>, normal_x: f64| {
        Some(WallModel {
            point_m: [x?, 0.0, 0.0],
            normal: [normal_x, 0.0, 0.0],
            stiffness_n_per_m: contact.normal_stiffness,
            damping_n_s_per_m: contact.normal_damping,
            damping_depth_m: contact.delta_c_m,
            tip_m,
        })
    };
    let (front, aft) = (wall(contact.x_front_m, -1.0), wall(contact.x_aft_m, 1.0));
    let guided = contact.lateral_stiffness != 0.0 || contact.lateral_damping != 0.0;
    ContactModel {
        walls: front.into_iter().chain(aft).collect(),
        guide: guided.then_some(GuideModel {
            axis: [1.0, 0.0, 0.0],
            point_m: [0.0; 3],
            tip_m,
            stiffness_n_per_m: contact.lateral_stiffness,
            damping_n_s_per_m: contact.lateral_damping,
        }),
        docking: Vec::new(),
    }
}

/// Orientation of S in M as a quaternion w x y z.
fn orientation(rotation: &Rotation) -> anyhow::Result<[f64; 4]> {
    const NAME: &str = "meta.json: `geometry.sensor_rotation_M_from_S`";
    match rotation {
        Rotation::Word(word) if word == "identity" => Ok([1.0, 0.0, 0.0, 0.0]),
        Rotation::Word(word) => bail!(
            "{NAME} is `{word}`; expected \"identity\", a quaternion [w, x, y, z] or three rows"
        ),
        Rotation::Quaternion(wxyz) => Ok(*wxyz),
        Rotation::Matrix(rows) => {
            let matrix = Matrix3::from_row_iterator(rows.iter().flatten().copied());
            let off = (matrix * matrix.transpose() - Matrix3::identity()).amax();
            ensure!(
                off < ORTHONORMAL && matrix.determinant() > 0.0,
                "{NAME} is not a rotation: its rows are not of unit length and at right angles"
            );
            let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
            Ok([q.w, q.i, q.j, q.k])
        }
    }
}
