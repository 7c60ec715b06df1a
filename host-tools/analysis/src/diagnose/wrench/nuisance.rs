//! Nominal parameters that may move within their tolerance.

use crate::model::Model;
use crate::model::load::effects::LoadEffect;
use crate::model::load::{Column, Scene};
use nalgebra::Vector3;

/// Change of the reading for one tolerance of each parameter that has one.
pub(crate) fn columns(model: &Model, scene: &Scene) -> Vec<Column> {
    let mut all = Vec::new();
    let mut add = |step: f64, change: &dyn Fn(&mut Model, f64)| {
        if step > 0.0 {
            let mut other = model.clone();
            change(&mut other, step);
            let column = scene.change(&other, 1.0);
            if !column.is_zero() {
                all.push(column);
            }
        }
    };
    let tolerance = &model.tolerance;
    for (i, wall) in model.contact.walls.iter().enumerate() {
        add(tolerance.wall_stiffness(wall), &|m, step| {
            m.contact.walls[i].stiffness_n_per_m += step;
        });
        add(tolerance.wall_damping(wall), &|m, step| {
            m.contact.walls[i].damping_n_s_per_m += step;
        });
        add(tolerance.wall_position_m, &|m, step| {
            let wall = &mut m.contact.walls[i];
            let shift = Vector3::from(wall.normal).normalize() * step;
            wall.point_m
                .iter_mut()
                .zip(&shift)
                .for_each(|(p, s)| *p += s);
        });
    }
    if let Some(guide) = &model.contact.guide {
        add(
            tolerance.guide_stiffness(guide.stiffness_n_per_m),
            &|m, step| {
                guide_of(m, |g| g.stiffness_n_per_m += step);
            },
        );
        add(
            tolerance.guide_damping(guide.damping_n_s_per_m),
            &|m, step| {
                guide_of(m, |g| g.damping_n_s_per_m += step);
            },
        );
        for i in 0..3 {
            add(tolerance.guide_position_m, &|m, step| {
                guide_of(m, |g| g.point_m[i] += step)
            });
        }
    }
    add(tolerance.tool_mass_kg, &|m, step| m.tool.mass_kg += step);
    for i in 0..3 {
        add(tolerance.tool_com_m, &|m, step| m.tool.com_m[i] += step);
        let moment = model.tool.inertia_kg_m2[i][i];
        add(tolerance.tool_inertia(moment), &|m, step| {
            m.tool.inertia_kg_m2[i][i] += step
        });
        add(tolerance.sensor_position_m, &|m, step| {
            m.sensor.position_m[i] += step
        });
        add(tolerance.sensor_orientation_rad, &|m, step| {
            crate::model::load::effects::turn(m, i, step);
        });
    }
    for (i, sigma) in tolerance.bias.into_iter().enumerate() {
        add(sigma, &|m, step| m.sensor.bias[i] += step);
    }
    all.extend(added_effects(model, scene));
    all
}

fn guide_of(model: &mut Model, change: impl Fn(&mut crate::model::GuideModel)) {
    if let Some(guide) = &mut model.contact.guide {
        change(guide);
    }
}

/// Fitted coefficients of effects that the model has already may move within their intervals.
fn added_effects(model: &Model, scene: &Scene) -> Vec<Column> {
    /// Half of a 95 % interval in standard deviations.
    const HALF_OF_95: f64 = 1.96;
    let mut all = Vec::new();
    for added in &model.effects {
        let Some(effect) = LoadEffect::find(&added.id) else {
            continue;
        };
        for coefficient in effect.coefficients {
            let Some([low, high]) = added.interval_95.get(coefficient.name) else {
                continue;
            };
            let sigma = 0.5 * (high - low) / HALF_OF_95;
            let mut alone = added.parameters.clone();
            for other in effect.coefficients {
                alone.insert(other.name.to_owned(), 0.0);
            }
            alone.insert(coefficient.name.to_owned(), sigma);
            let part = effect.contribution(scene, &alone);
            all.push(Column::of(scene.len(), |n| {
                std::array::from_fn(|axis| part[axis][n])
            }));
        }
    }
    all
}
