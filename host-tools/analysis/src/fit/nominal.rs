//! The nominal parameters of a model, each with its tolerance.

use super::parameter_id::{ParameterId, Spacecraft};
use softdock_physics::model::docking::numbers;
use softdock_physics::model::{
    BodyModel, GuideModel, Model, SensorModel, ToleranceModel, ToolModel, WallModel,
};

/// Callback that receives place, name, unit, value and tolerance of a nominal parameter.
pub(super) type Visit<'a> = dyn FnMut(ParameterId, String, &'static str, f64, f64) + 'a;

/// Visits all nominal parameters of a model.
pub(super) fn nominal(model: &Model, visit: &mut Visit<'_>) {
    let tolerance = &model.tolerance;
    let actuator = &model.actuator;
    let mut add = |id, name: &str, unit, value, tolerance| {
        visit(id, name.to_owned(), unit, value, tolerance);
    };
    let delay_s = actuator.transport_delay_s;
    let name = "actuator.transport_delay_s";
    add(
        ParameterId::TransportDelay,
        name,
        "s",
        delay_s,
        tolerance.transport_delay_s,
    );
    add(
        ParameterId::Lag,
        "actuator.lag_s",
        "s",
        actuator.lag_s,
        tolerance.lag_s,
    );
    contact(model, visit);
    docking(model, visit);
    tool_and_sensor(model, visit);
    for (spacecraft, name, body) in [
        (Spacecraft::K, "bodies.k", &model.bodies.k),
        (Spacecraft::Q, "bodies.q", &model.bodies.q),
    ] {
        spacecraft_of(spacecraft, name, body, model, visit);
    }
}

fn contact(model: &Model, visit: &mut Visit<'_>) {
    for (i, one) in model.contact.walls.iter().enumerate() {
        wall(i, one, &model.tolerance, visit);
    }
    if let Some(one) = &model.contact.guide {
        guide(one, &model.tolerance, visit);
    }
}

fn wall(i: usize, wall: &WallModel, tolerance: &ToleranceModel, visit: &mut Visit<'_>) {
    let name = |key: &str| format!("contact.walls[{i}].{key}");
    visit(
        ParameterId::WallStiffness(i),
        name("stiffness_n_per_m"),
        "N/m",
        wall.stiffness_n_per_m,
        tolerance.wall_stiffness(wall),
    );
    visit(
        ParameterId::WallDamping(i),
        name("damping_n_s_per_m"),
        "N·s/m",
        wall.damping_n_s_per_m,
        tolerance.wall_damping(wall),
    );
    let name = name("point_m (along the normal)");
    let id = ParameterId::WallPosition(i);
    visit(id, name, "m", 0.0, tolerance.wall_position_m);
}

fn guide(guide: &GuideModel, tolerance: &ToleranceModel, visit: &mut Visit<'_>) {
    let name = |key: &str| format!("contact.guide.{key}");
    let (stiffness, damping) = (guide.stiffness_n_per_m, guide.damping_n_s_per_m);
    visit(
        ParameterId::GuideStiffness,
        name("stiffness_n_per_m"),
        "N/m",
        stiffness,
        tolerance.guide_stiffness(stiffness),
    );
    visit(
        ParameterId::GuideDamping,
        name("damping_n_s_per_m"),
        "N·s/m",
        damping,
        tolerance.guide_damping(damping),
    );
    for (i, value) in guide.point_m.into_iter().enumerate() {
        let name = name(&format!("point_m[{i}]"));
        let id = ParameterId::GuidePosition(i);
        visit(id, name, "m", value, tolerance.guide_position_m);
    }
}

fn docking(model: &Model, visit: &mut Visit<'_>) {
    let tolerance = &model.tolerance;
    for (i, docking) in model.contact.docking.iter().enumerate() {
        for number in numbers(docking) {
            let (name, value) = (number.name(i), number.value);
            let id = ParameterId::Docking(i, number.pointer);
            visit(
                id,
                name,
                number.unit,
                value,
                tolerance.docking_share * value.abs(),
            );
        }
        for (axis, value) in docking.position_m.into_iter().enumerate() {
            let name = format!("contact.docking[{i}].position_m[{axis}]");
            let id = ParameterId::DockingPosition(i, axis);
            visit(id, name, "m", value, tolerance.docking_position_m);
        }
    }
}

fn tool_and_sensor(model: &Model, visit: &mut Visit<'_>) {
    let tolerance = &model.tolerance;
    let name = "tool.mass_kg".to_owned();
    let mass_kg = model.tool.mass_kg;
    let id = ParameterId::ToolMass;
    visit(id, name, "kg", mass_kg, tolerance.tool_mass_kg);
    for i in 0..3 {
        tool_along(i, &model.tool, tolerance, visit);
        sensor_along(i, &model.sensor, tolerance, visit);
    }
    for (i, tolerance) in tolerance.bias.into_iter().enumerate() {
        let unit = if i < 3 { "N" } else { "N·m" };
        let name = format!("sensor.bias[{i}]");
        let bias = model.sensor.bias[i];
        visit(ParameterId::Bias(i), name, unit, bias, tolerance);
    }
}

/// Visits the tool's parameters along or about axis `i`.
fn tool_along(i: usize, tool: &ToolModel, tolerance: &ToleranceModel, visit: &mut Visit<'_>) {
    let name = format!("tool.com_m[{i}]");
    let id = ParameterId::ToolCom(i);
    visit(id, name, "m", tool.com_m[i], tolerance.tool_com_m);
    let moment = tool.inertia_kg_m2[i][i];
    visit(
        ParameterId::ToolInertia(i),
        format!("tool.inertia_kg_m2[{i}][{i}]"),
        "kg·m²",
        moment,
        tolerance.tool_inertia(moment),
    );
}

/// Visits the sensor's parameters along or about axis `i`.
fn sensor_along(i: usize, sensor: &SensorModel, tolerance: &ToleranceModel, visit: &mut Visit<'_>) {
    let name = format!("sensor.position_m[{i}]");
    let position_m = sensor.position_m[i];
    let id = ParameterId::SensorPosition(i);
    visit(id, name, "m", position_m, tolerance.sensor_position_m);
    let name = format!("sensor.orientation_wxyz (about {})", ["x", "y", "z"][i]);
    let turn_rad = tolerance.sensor_orientation_rad;
    let id = ParameterId::SensorOrientation(i);
    visit(id, name, "rad", 0.0, turn_rad);
}

fn spacecraft_of(
    spacecraft: Spacecraft,
    name: &str,
    body: &BodyModel,
    model: &Model,
    visit: &mut Visit<'_>,
) {
    let tolerance = &model.tolerance;
    if let Some(mass) = body.mass_kg {
        let name = format!("{name}.mass_kg");
        visit(
            ParameterId::BodyMass(spacecraft),
            name,
            "kg",
            mass,
            tolerance.body_mass_kg,
        );
    }
    for (i, row) in body.inertia_kg_m2.iter().flatten().enumerate() {
        let name = format!("{name}.inertia_kg_m2[{i}][{i}]");
        let id = ParameterId::BodyInertia(spacecraft, i);
        visit(id, name, "kg·m²", row[i], tolerance.body_inertia_kg_m2);
    }
}
