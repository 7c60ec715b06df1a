//! The optional `tolerance` of `meta.json`: dotted path of a parameter -> one standard deviation.
//!
//! Where the format allows one value per component or per wall, the model file has a single one. The largest then counts, so that
//! an error within tolerance is never taken for an effect.

use anyhow::{Context, ensure};
use serde_json::{Map, Value};
use softdock_physics::model::ToleranceModel;

/// Everything exact: what `tolerance` means for parameters that it does not list.
fn exact() -> ToleranceModel {
    ToleranceModel {
        transport_delay_s: 0.0,
        lag_s: 0.0,
        wall_stiffness_n_per_m: Some(0.0),
        wall_damping_n_s_per_m: Some(0.0),
        wall_position_m: 0.0,
        guide_stiffness_n_per_m: Some(0.0),
        guide_damping_n_s_per_m: Some(0.0),
        guide_position_m: 0.0,
        docking_share: 0.0,
        docking_position_m: 0.0,
        tool_mass_kg: 0.0,
        tool_com_m: 0.0,
        tool_inertia_kg_m2: Some(0.0),
        bias: [0.0; 6],
        sensor_position_m: 0.0,
        sensor_orientation_rad: 0.0,
        body_mass_kg: 0.0,
        body_inertia_kg_m2: 0.0,
    }
}

/// Tolerances of a log that states none: a fifth of what a model file usually allows, nearly exact. It is enough for another
/// integration of the same equations.
pub(super) fn unstated() -> ToleranceModel {
    const SHARE: f64 = 0.2;
    let usual = ToleranceModel::default();
    ToleranceModel {
        transport_delay_s: SHARE * usual.transport_delay_s,
        lag_s: SHARE * usual.lag_s,
        wall_position_m: SHARE * usual.wall_position_m,
        guide_position_m: SHARE * usual.guide_position_m,
        tool_mass_kg: SHARE * usual.tool_mass_kg,
        tool_com_m: SHARE * usual.tool_com_m,
        bias: usual.bias.map(|b| SHARE * b),
        ..usual
    }
}

/// Tolerances of the model file. Paths for which it has no key are reported in `notes`.
///
/// # Errors
///
/// A value that is no number or list of numbers, or is negative.
pub(super) fn tolerance(
    paths: &Map<String, Value>,
    notes: &mut Vec<String>,
) -> anyhow::Result<ToleranceModel> {
    let mut tolerance = exact();
    for (path, value) in paths {
        let mut numbers = Vec::new();
        flatten(value, &mut numbers)
            .filter(|()| !numbers.is_empty())
            .with_context(|| {
                format!("meta.json, tolerance `{path}`: expected a number or a list, found {value}")
            })?;
        ensure!(
            numbers.iter().all(|n| n.is_finite() && *n >= 0.0),
            "meta.json, tolerance `{path}`: expected standard deviations of at least 0, found {value}"
        );
        let largest = numbers.iter().copied().fold(0.0, f64::max);
        match assign(path, &numbers, largest, &mut tolerance) {
            Target::Found { one_for_all } => {
                if one_for_all && numbers.iter().any(|n| *n != largest && *n != 0.0) {
                    notes.push(format!(
                        "meta.json, tolerance `{path}`: the model has one tolerance for all \
                         components; the largest, {largest}, is used"
                    ));
                }
            }
            Target::Unknown => notes.push(format!(
                "meta.json, tolerance `{path}`: the model has no tolerance of this name; the \
                 parameter counts as exact"
            )),
        }
    }
    Ok(tolerance)
}

/// All numbers of nested lists; None if there is anything else.
fn flatten(value: &Value, numbers: &mut Vec<f64>) -> Option<()> {
    match value {
        Value::Number(number) => numbers.push(number.as_f64()?),
        Value::Array(list) => list.iter().try_for_each(|v| flatten(v, numbers))?,
        _ => return None,
    }
    Some(())
}

enum Target {
    /// `one_for_all`: the model has one number where the path has several.
    Found {
        one_for_all: bool,
    },
    Unknown,
}

fn assign(path: &str, numbers: &[f64], largest: f64, tolerance: &mut ToleranceModel) -> Target {
    let t = tolerance;
    let component = |i: usize| numbers.get(i).copied().unwrap_or(largest);
    match path {
        "actuator.transport_delay_s" => t.transport_delay_s = largest,
        "actuator.lag_time_constant_s" => t.lag_s = largest,
        "contact.k_n_N_m" => t.wall_stiffness_n_per_m = Some(largest),
        "contact.c_n_Ns_m" => t.wall_damping_n_s_per_m = Some(largest),
        "contact.k_t_N_m" => t.guide_stiffness_n_per_m = Some(largest),
        "contact.c_t_Ns_m" => t.guide_damping_n_s_per_m = Some(largest),
        "contact.x_front_m" | "contact.x_aft_m" => {
            t.wall_position_m = t.wall_position_m.max(largest);
        }
        // A longer tip meets the wall earlier; a tip off the axis shifts the guide's centre line.
        "geometry.r_tip_m" => {
            t.wall_position_m = t.wall_position_m.hypot(component(0));
            t.guide_position_m = component(1).max(component(2));
            return Target::Found { one_for_all: false };
        }
        "geometry.r_sensor_m" => t.sensor_position_m = largest,
        "geometry.sensor_rotation_M_from_S" => t.sensor_orientation_rad = largest,
        "tool.mass_kg" => t.tool_mass_kg = largest,
        "tool.com_m" => t.tool_com_m = largest,
        "tool.inertia_kg_m2" => t.tool_inertia_kg_m2 = Some(largest),
        "ft_sensor.bias" => {
            t.bias = std::array::from_fn(component);
            return Target::Found { one_for_all: false };
        }
        "spacecraft.mass_kg" => t.body_mass_kg = largest,
        "spacecraft.inertia_kg_m2" => t.body_inertia_kg_m2 = largest,
        _ => return Target::Unknown,
    }
    Target::Found { one_for_all: true }
}
