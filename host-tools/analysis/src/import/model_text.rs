//! A model as the text of a `model.toml` that a person goes on with: every value written out,
//! every value explained.

use softdock_mechanism::DockingSettings;
use softdock_physics::model::{
    ContactModel, Model, SensorModel, ToleranceModel, ToolModel, WrenchMeaning,
};
use std::fmt::Write;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table};

/// The text; `origin` says in its first line where the numbers come from. Added effects and the
/// history are left out: an imported model has none.
pub fn commented(model: &Model, origin: &str) -> String {
    let mut text = head(model, origin);
    contact(&mut text, &model.contact);
    docking(&mut text, &model.contact.docking);
    tool(&mut text, &model.tool);
    sensor(&mut text, &model.sensor);
    bodies(&mut text, model);
    noise(&mut text, model);
    tolerance(&mut text, &model.tolerance);
    text.push_str(
        "
# Effects that a rig has beyond the above; `softdock effects` lists them, `softdock add` fits and
# writes them here.
",
    );
    text
}

/// Head of the text: what it is, what applies to all of it, the axes and their actuator.
fn head(model: &Model, origin: &str) -> String {
    let axes: Vec<String> = model
        .rig
        .active_axes
        .iter()
        .map(|a| format!("{a}"))
        .collect();
    let actuator = &model.actuator;
    // A comment ends with its line, and TOML allows no control characters in it.
    let origin: String = origin.chars().filter(|c| !c.is_control()).collect();
    format!(
        "# Nominal model, from {origin}.
# SI units; the unit stands in each key's name. `#` begins a comment.
#
# Frames: C is the robot's base; M sits on the flange, on a docking rig at the centre of mass of the
# spacecraft that the robot plays; S is the force/torque sensor. Linear velocities are in C, angular ones in M.

[rig]
# Axes that move: translations x y z, rotations rx ry rz.
active_axes = {axes:?}

[actuator]
# From the start of the cycle in which a velocity is sent until the robot moves with it.
transport_delay_s = {:?}
# Time constant of the first-order lag behind the delay.
lag_s = {:?}
",
        actuator.transport_delay_s, actuator.lag_s
    )
}

fn tool(text: &mut String, tool: &ToolModel) {
    add(
        text,
        format_args!(
            "
[tool]
# Everything beyond the sensor.
mass_kg = {:?}
com_m = {:?}  # in S
inertia_kg_m2 = {:?}
# Whether the predicted wrench contains what it takes to accelerate the tool.
dynamic_compensation = {}
",
            tool.mass_kg, tool.com_m, tool.inertia_kg_m2, tool.dynamic_compensation
        ),
    );
}

/// Appends a formatted text; writing to a String cannot fail.
fn add(text: &mut String, part: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(part);
}

fn contact(text: &mut String, contact: &ContactModel) {
    if !contact.walls.is_empty() {
        text.push_str("\n# What the mechanism touches; one block for each wall.\n");
    }
    for (i, wall) in contact.walls.iter().enumerate() {
        if i > 0 {
            text.push('\n');
        }
        add(
            text,
            format_args!(
                "[[contact.walls]]
point_m = {:?}  # a point of the surface, in C
normal = {:?}  # out of the wall, in C
stiffness_n_per_m = {:?}
damping_n_s_per_m = {:?}
damping_depth_m = {:?}  # penetration at which the damping acts in full
tip_m = {:?}  # the point that touches, in M
",
                wall.point_m,
                wall.normal,
                wall.stiffness_n_per_m,
                wall.damping_n_s_per_m,
                wall.damping_depth_m,
                wall.tip_m
            ),
        );
    }
    if let Some(guide) = &contact.guide {
        add(
            text,
            format_args!(
                "
# A guide that centres the tip across an axis at all times.
[contact.guide]
axis = {:?}
point_m = {:?}
tip_m = {:?}
stiffness_n_per_m = {:?}
damping_n_s_per_m = {:?}
",
                guide.axis,
                guide.point_m,
                guide.tip_m,
                guide.stiffness_n_per_m,
                guide.damping_n_s_per_m
            ),
        );
    }
}

fn docking(text: &mut String, dockings: &[DockingSettings]) {
    for docking in dockings {
        let mut document = DocumentMut::new();
        let Ok(table) = toml_edit::ser::to_document(docking) else {
            continue;
        };
        let mut each = ArrayOfTables::new();
        each.push(table.into_table());
        document["contact"] =
            Item::Table(Table::from_iter([("docking", Item::ArrayOfTables(each))]));
        add(text, format_args!("\n# A docking mechanism.\n{document}"));
    }
}

fn sensor(text: &mut String, sensor: &SensorModel) {
    let wrench = match sensor.wrench {
        WrenchMeaning::Measured => "measured",
        WrenchMeaning::Commanded => "commanded",
        WrenchMeaning::Unscaled => "unscaled",
        WrenchMeaning::Free => "free",
    };
    add(
        text,
        format_args!(
            "
[sensor]
position_m = {:?}  # of S in M
orientation_wxyz = {:?}
bias = {:?}  # reading without load: forces, torques
gravity_m_s2 = {:?}  # in C
# \"measured\": a sensor's reading, which may come late; also a measured motor current, with a negative scale.
# \"commanded\": a motor's force, with reversed sign, which may act late. \"unscaled\": the same, from amperes,
# volts or bar by a guess: its gain is looked for. \"free\": nothing drives; effects are in proportion to the mass or
# inertia in [tool], 1 if you do not know it.
wrench = {wrench:?}
# true: each row is a measurement of its own at rest, as the poses of a calibration are.
at_rest = {}
",
            sensor.position_m,
            sensor.orientation_wxyz,
            sensor.bias,
            sensor.gravity_m_s2,
            sensor.at_rest
        ),
    );
    if let Some(filter) = sensor.filter {
        add(
            text,
            format_args!(
                "# What was measured went through it when it was imported, forwards and backwards.
filter = {{ order = {}, cutoff_hz = {:?} }}
",
                filter.order, filter.cutoff_hz
            ),
        );
    }
}

fn bodies(text: &mut String, model: &Model) {
    for (name, about, body) in [
        ("k", "moved by the robot", &model.bodies.k),
        ("q", "the other one", &model.bodies.q),
    ] {
        let mut lines = String::new();
        if let Some(fixed) = body.fixed {
            add(&mut lines, format_args!("fixed = {fixed}\n"));
        }
        if let Some(mass) = body.mass_kg {
            add(&mut lines, format_args!("mass_kg = {mass:?}\n"));
        }
        if let Some(inertia) = body.inertia_kg_m2 {
            add(&mut lines, format_args!("inertia_kg_m2 = {inertia:?}\n"));
        }
        if let Some(value) = body.arm_acceleration_m_s2 {
            add(
                &mut lines,
                format_args!("arm_acceleration_m_s2 = {value:?}\n"),
            );
        }
        if let Some(value) = body.arm_angular_acceleration_rad_s2 {
            let key = "arm_angular_acceleration_rad_s2";
            add(&mut lines, format_args!("{key} = {value:?}\n"));
        }
        for (key, value) in [
            ("arm_stiffness_n_per_m", body.arm_stiffness_n_per_m),
            ("arm_damping_n_s_per_m", body.arm_damping_n_s_per_m),
        ] {
            if let Some(value) = value {
                add(&mut lines, format_args!("{key} = {value:?}\n"));
            }
        }
        if !lines.is_empty() {
            add(
                text,
                format_args!("\n# Simulated spacecraft, {about}.\n[bodies.{name}]\n{lines}"),
            );
        }
    }
}

fn noise(text: &mut String, model: &Model) {
    let noise = &model.noise;
    add(
        text,
        format_args!(
            "
[noise]
# One standard deviation, by data sheet or from a quiet log.
force_n = {:?}
torque_n_m = {:?}
velocity_m_s = {:?}  # counts where the velocity is measured; else the pose's noise does
rate_rad_s = {:?}
position_m = {:?}
angle_rad = {:?}
model_velocity_m_s = {:?}  # digits with which the model's velocity is logged
model_rate_rad_s = {:?}
",
            noise.force_n,
            noise.torque_n_m,
            noise.velocity_m_s,
            noise.rate_rad_s,
            noise.position_m,
            noise.angle_rad,
            noise.model_velocity_m_s,
            noise.model_rate_rad_s
        ),
    );
}

fn tolerance(text: &mut String, t: &ToleranceModel) {
    text.push_str(
        "
[tolerance]
# How far the values above may be off, one standard deviation. A diagnosis lets them move so far
# before it calls something a missing effect. 0: exact.
",
    );
    let mut line = |key: &str, value: f64| add(text, format_args!("{key} = {value:?}\n"));
    line("transport_delay_s", t.transport_delay_s);
    line("lag_s", t.lag_s);
    line("wall_position_m", t.wall_position_m);
    line("guide_position_m", t.guide_position_m);
    line("docking_share", t.docking_share);
    line("docking_position_m", t.docking_position_m);
    line("tool_mass_kg", t.tool_mass_kg);
    line("tool_com_m", t.tool_com_m);
    line("sensor_position_m", t.sensor_position_m);
    line("sensor_orientation_rad", t.sensor_orientation_rad);
    line("body_mass_kg", t.body_mass_kg);
    line("body_inertia_kg_m2", t.body_inertia_kg_m2);
    add(text, format_args!("bias = {:?}\n", t.bias));
    shares(text, t);
}

/// Tolerances that default to a share of the value.
fn shares(text: &mut String, t: &ToleranceModel) {
    for (key, value, default) in [
        (
            "wall_stiffness_n_per_m",
            t.wall_stiffness_n_per_m,
            "0.3 % of each wall's",
        ),
        (
            "wall_damping_n_s_per_m",
            t.wall_damping_n_s_per_m,
            "1 % of each wall's",
        ),
        (
            "guide_stiffness_n_per_m",
            t.guide_stiffness_n_per_m,
            "0.3 %",
        ),
        ("guide_damping_n_s_per_m", t.guide_damping_n_s_per_m, "1 %"),
        (
            "tool_inertia_kg_m2",
            t.tool_inertia_kg_m2,
            "1 % of each diagonal element",
        ),
    ] {
        match value {
            Some(value) => add(text, format_args!("{key} = {value:?}\n")),
            None => add(text, format_args!("# {key} = 0.0  # left out: {default}\n")),
        }
    }
}
