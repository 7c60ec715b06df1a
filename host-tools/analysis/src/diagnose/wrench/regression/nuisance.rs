//! Nominal parameters that may move within their tolerance.

use nalgebra::Vector3;
use softdock_physics::model::load::effects::LoadEffect;
use softdock_physics::model::load::{Column, Scene};
use softdock_physics::model::{Model, WrenchMeaning, docking};
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

impl Nuisance {
    fn new(
        name: impl Into<String>,
        (value, tolerance): (f64, f64),
        change: impl Fn(&mut Model, f64) + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            value,
            tolerance,
            change: Box::new(change),
        }
    }
}

/// All nominal parameters with a tolerance on which a reading can depend. Their order is that of the columns.
pub(crate) fn all(model: &Model) -> Vec<Nuisance> {
    let mut all = of_walls(model);
    all.extend(of_guide(model));
    all.extend(of_docking(model));
    all.extend(of_tool_and_sensor(model));
    all.retain(|nuisance| nuisance.tolerance > 0.0);
    all
}

fn of_walls(model: &Model) -> Vec<Nuisance> {
    let tolerance = &model.tolerance;
    let each = model.contact.walls.iter().enumerate();
    let of_wall = each.flat_map(|(i, wall)| {
        let name = |what: &str| format!("contact.walls[{i}].{what}");
        let normal = Vector3::from(wall.normal).normalize();
        let depth = normal.dot(&Vector3::from(wall.point_m));
        let moved = move |m: &mut Model, step: f64| {
            let point = m.contact.walls[i].point_m.iter_mut();
            point.zip(&normal).for_each(|(p, n)| *p += step * n);
        };
        let stiffness = (wall.stiffness_n_per_m, tolerance.wall_stiffness(wall));
        let damping = (wall.damping_n_s_per_m, tolerance.wall_damping(wall));
        [
            Nuisance::new(name("stiffness_n_per_m"), stiffness, move |m, step| {
                m.contact.walls[i].stiffness_n_per_m += step;
            }),
            Nuisance::new(name("damping_n_s_per_m"), damping, move |m, step| {
                m.contact.walls[i].damping_n_s_per_m += step;
            }),
            Nuisance::new(
                name("point_m along its normal"),
                (depth, tolerance.wall_position_m),
                moved,
            ),
        ]
    });
    of_wall.collect()
}

fn of_guide(model: &Model) -> Vec<Nuisance> {
    let Some(guide) = &model.contact.guide else {
        return Vec::new();
    };
    let (tolerance, name) = (&model.tolerance, |what: &str| {
        format!("contact.guide.{what}")
    });
    let (stiffness, damping) = (guide.stiffness_n_per_m, guide.damping_n_s_per_m);
    let stiffness = (stiffness, tolerance.guide_stiffness(stiffness));
    let damping = (damping, tolerance.guide_damping(damping));
    let mut all = vec![
        Nuisance::new(name("stiffness_n_per_m"), stiffness, |m, step| {
            guide_of(m, |g| g.stiffness_n_per_m += step);
        }),
        Nuisance::new(name("damping_n_s_per_m"), damping, |m, step| {
            guide_of(m, |g| g.damping_n_s_per_m += step);
        }),
    ];
    all.extend((0..3).map(|i| {
        let at = (guide.point_m[i], tolerance.guide_position_m);
        Nuisance::new(name(&format!("point_m[{i}]")), at, move |m, step| {
            guide_of(m, |g| g.point_m[i] += step);
        })
    }));
    all
}

fn of_docking(model: &Model) -> Vec<Nuisance> {
    let tolerance = &model.tolerance;
    let mut all = Vec::new();
    for (i, docking) in model.contact.docking.iter().enumerate() {
        for number in docking::numbers(docking) {
            let (name, value) = (number.name(i), number.value);
            let within = (value, tolerance.docking_share * value.abs());
            all.push(Nuisance::new(name, within, move |m, step| {
                docking::set(&mut m.contact.docking[i], &number.pointer, value + step);
            }));
        }
        for axis in 0..3 {
            let name = format!("contact.docking[{i}].position_m[{axis}]");
            let within = (docking.position_m[axis], tolerance.docking_position_m);
            all.push(Nuisance::new(name, within, move |m, step| {
                m.contact.docking[i].position_m[axis] += step;
            }));
        }
    }
    all
}

fn of_tool_and_sensor(model: &Model) -> Vec<Nuisance> {
    let (tool, sensor, tolerance) = (&model.tool, &model.sensor, &model.tolerance);
    // Where nothing drives what swings, its mass and inertia are what all else is measured in.
    let known = match sensor.wrench {
        WrenchMeaning::Free => 0.0,
        _ => 1.0,
    };
    let mass = (tool.mass_kg, known * tolerance.tool_mass_kg);
    let mut all = vec![Nuisance::new("tool.mass_kg", mass, |m, step| {
        m.tool.mass_kg += step;
    })];
    for i in 0..3 {
        let moment = tool.inertia_kg_m2[i][i];
        let com = (tool.com_m[i], tolerance.tool_com_m);
        let inertia = (moment, known * tolerance.tool_inertia(moment));
        let position = (sensor.position_m[i], tolerance.sensor_position_m);
        let turn = (0.0, tolerance.sensor_orientation_rad);
        let about = ["x", "y", "z"][i];
        all.extend([
            Nuisance::new(format!("tool.com_m[{i}]"), com, move |m, step| {
                m.tool.com_m[i] += step;
            }),
            Nuisance::new(
                format!("tool.inertia_kg_m2[{i}][{i}]"),
                inertia,
                move |m, step| m.tool.inertia_kg_m2[i][i] += step,
            ),
            Nuisance::new(
                format!("sensor.position_m[{i}]"),
                position,
                move |m, step| m.sensor.position_m[i] += step,
            ),
            Nuisance::new(
                format!("sensor.orientation about {about}"),
                turn,
                move |m, step| m.turn_sensor(i, step),
            ),
        ]);
    }
    let zeros = tolerance.bias.into_iter().enumerate();
    all.extend(zeros.map(|(i, sigma)| {
        let zero = (sensor.bias[i], sigma);
        Nuisance::new(format!("sensor.bias[{i}]"), zero, move |m, step| {
            m.sensor.bias[i] += step;
        })
    }));
    all
}

/// Columns of the nuisance parameters: the change of the reading for one tolerance of each nominal parameter, then for one
/// standard deviation of each fitted coefficient. A column that is 0 on this log stays, as the parameter may have an effect on
/// another.
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

/// Columns of fitted coefficients of effects that the model has already: they may move within their intervals.
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
