//! Nominal parameters that may move within their tolerance.

use nalgebra::Vector3;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::load::{Column, Scene};
use softdock_physics::model::{Model, docking};
use softdock_statistics::DEVIATIONS_95;

/// A nominal parameter that may move within its tolerance.
pub(crate) struct Nuisance {
    /// Place in the model file.
    pub name: String,
    /// Nominal value.
    pub value: f64,
    /// One standard deviation.
    pub tolerance: f64,
    change: Change,
}

/// Adds a step to a parameter.
type Change = Box<dyn Fn(&mut Model, f64)>;

/// All nominal parameters with a tolerance on which a reading can depend.
pub(crate) fn all(model: &Model) -> Vec<Nuisance> {
    let mut all = Vec::new();
    let mut add = |name: String, value: f64, tolerance: f64, change: Change| {
        if tolerance > 0.0 {
            all.push(Nuisance {
                name,
                value,
                tolerance,
                change,
            });
        }
    };
    let tolerance = &model.tolerance;
    for (i, wall) in model.contact.walls.iter().enumerate() {
        let name = |what: &str| format!("contact.walls[{i}].{what}");
        add(
            name("stiffness_n_per_m"),
            wall.stiffness_n_per_m,
            tolerance.wall_stiffness(wall),
            Box::new(move |m, step| m.contact.walls[i].stiffness_n_per_m += step),
        );
        add(
            name("damping_n_s_per_m"),
            wall.damping_n_s_per_m,
            tolerance.wall_damping(wall),
            Box::new(move |m, step| m.contact.walls[i].damping_n_s_per_m += step),
        );
        let normal = Vector3::from(wall.normal).normalize();
        add(
            name("point_m along its normal"),
            normal.dot(&Vector3::from(wall.point_m)),
            tolerance.wall_position_m,
            Box::new(move |m, step| {
                let point = &mut m.contact.walls[i].point_m;
                point
                    .iter_mut()
                    .zip(&normal)
                    .for_each(|(p, n)| *p += step * n);
            }),
        );
    }
    if let Some(guide) = &model.contact.guide {
        add(
            "contact.guide.stiffness_n_per_m".to_owned(),
            guide.stiffness_n_per_m,
            tolerance.guide_stiffness(guide.stiffness_n_per_m),
            Box::new(|m, step| guide_of(m, |g| g.stiffness_n_per_m += step)),
        );
        add(
            "contact.guide.damping_n_s_per_m".to_owned(),
            guide.damping_n_s_per_m,
            tolerance.guide_damping(guide.damping_n_s_per_m),
            Box::new(|m, step| guide_of(m, |g| g.damping_n_s_per_m += step)),
        );
        for i in 0..3 {
            add(
                format!("contact.guide.point_m[{i}]"),
                guide.point_m[i],
                tolerance.guide_position_m,
                Box::new(move |m, step| guide_of(m, |g| g.point_m[i] += step)),
            );
        }
    }
    for (i, docking) in model.contact.docking.iter().enumerate() {
        for number in docking::numbers(docking) {
            let (name, value) = (number.name(i), number.value);
            let moved = move |m: &mut Model, step: f64| {
                docking::set(&mut m.contact.docking[i], &number.pointer, value + step);
            };
            add(
                name,
                value,
                tolerance.docking_share * value.abs(),
                Box::new(moved),
            );
        }
        for axis in 0..3 {
            let moved = move |m: &mut Model, step| m.contact.docking[i].position_m[axis] += step;
            add(
                format!("contact.docking[{i}].position_m[{axis}]"),
                docking.position_m[axis],
                tolerance.docking_position_m,
                Box::new(moved),
            );
        }
    }
    add(
        "tool.mass_kg".to_owned(),
        model.tool.mass_kg,
        tolerance.tool_mass_kg,
        Box::new(|m, step| m.tool.mass_kg += step),
    );
    for i in 0..3 {
        add(
            format!("tool.com_m[{i}]"),
            model.tool.com_m[i],
            tolerance.tool_com_m,
            Box::new(move |m, step| m.tool.com_m[i] += step),
        );
        let moment = model.tool.inertia_kg_m2[i][i];
        add(
            format!("tool.inertia_kg_m2[{i}][{i}]"),
            moment,
            tolerance.tool_inertia(moment),
            Box::new(move |m, step| m.tool.inertia_kg_m2[i][i] += step),
        );
        add(
            format!("sensor.position_m[{i}]"),
            model.sensor.position_m[i],
            tolerance.sensor_position_m,
            Box::new(move |m, step| m.sensor.position_m[i] += step),
        );
        add(
            format!("sensor.orientation about {}", ["x", "y", "z"][i]),
            0.0,
            tolerance.sensor_orientation_rad,
            Box::new(move |m, step| m.turn_sensor(i, step)),
        );
    }
    for (i, sigma) in tolerance.bias.into_iter().enumerate() {
        add(
            format!("sensor.bias[{i}]"),
            model.sensor.bias[i],
            sigma,
            Box::new(move |m, step| m.sensor.bias[i] += step),
        );
    }
    all
}

/// Change of the reading for one tolerance of each nominal parameter, then for one standard deviation
/// of each fitted one. A parameter without any effect on this log may have one on another.
pub(crate) fn columns(model: &Model, scene: &Scene) -> Vec<Column> {
    let nominal = all(model);
    let of = |nuisance: &Nuisance| {
        let mut other = model.clone();
        (nuisance.change)(&mut other, nuisance.tolerance);
        scene.change(&other, 1.0)
    };
    let nominal = nominal.iter().map(of);
    nominal.chain(added_effects(model, scene)).collect()
}

fn guide_of(model: &mut Model, change: impl Fn(&mut softdock_physics::model::GuideModel)) {
    if let Some(guide) = &mut model.contact.guide {
        change(guide);
    }
}

/// Fitted coefficients of effects that the model has already may move within their intervals.
fn added_effects(model: &Model, scene: &Scene) -> Vec<Column> {
    let mut all = Vec::new();
    for added in &model.effects {
        let Some(effect) = LoadEffect::find(model, &added.id) else {
            continue;
        };
        for coefficient in &effect.coefficients {
            let Some([low, high]) = added.interval_95.get(coefficient.name) else {
                continue;
            };
            let sigma = 0.5 * (high - low) / DEVIATIONS_95;
            let mut alone = added.parameters.clone();
            for other in &effect.coefficients {
                alone.insert(other.name.to_owned(), 0.0);
            }
            alone.insert(coefficient.name.to_owned(), sigma);
            all.push(effect.contribution(scene, &alone));
        }
    }
    all
}
