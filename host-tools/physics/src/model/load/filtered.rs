//! What the low-pass of an import has made of a load, if the motion of the log went through it, too.
//!
//! What is proportional to the motion is filtered as that is. A friction is not: the sign of a velocity has frequencies of its own,
//! so that its force is filtered as the recorded one was. Of what depends on the position alone, as the weight of a link on its angle,
//! the part that is proportional to the position over the log is of the first kind, and what it is beyond that of the second.

use super::{Column, Scene, laws};
use crate::effects::formula::{ActsOn, Signals};
use crate::effects::{Effect, Law, Slide, Values};
use crate::model::FilterModel;
use nalgebra::Vector3;

/// The load of an effect in the log, given the one that it is by the filtered motion.
pub(super) fn load(
    filter: FilterModel,
    scene: &Scene,
    effect: &Effect,
    p: Values<'_>,
    part: Column,
) -> Column {
    if is_proportional(effect, p) {
        return part;
    }
    let proportional = proportional_part(scene, effect, p);
    let beyond = match &proportional {
        Some(proportional) => part.less(proportional),
        None => part,
    };
    let mut load = through(filter, scene.cycle_s, beyond);
    if let Some(proportional) = proportional {
        load.add(&proportional.0);
    }
    load
}

fn through(filter: FilterModel, cycle_s: f64, mut part: Column) -> Column {
    for series in part.0.iter_mut().filter(|series| !series.is_empty()) {
        *series = filter.zero_phase(cycle_s, series);
    }
    part
}

/// Position, velocity and acceleration of any three instants.
const INSTANTS: [[f64; 3]; 3] = [[0.7, 0.4, -3.0], [-0.3, 1.1, 2.0], [1.3, -0.6, 0.5]];

/// Force along a guide or about a bearing, given how that moves.
type Along<'a> = Box<dyn Fn(&Slide) -> f64 + 'a>;

/// Force of an effect that acts along its guide or about its bearing.
fn along<'a>(effect: &Effect, p: Values<'a>) -> Option<Along<'a>> {
    match effect.law {
        Law::Guide(law) | Law::Bearing(law) => Some(Box::new(move |slide| (law.force)(p, slide))),
        Law::Spring(law) => Some(Box::new(move |slide| {
            law(p, &Vector3::x().scale(slide.position)).x
        })),
        Law::Formula(law) if law.acts_on == ActsOn::Guide => Some(Box::new(move |slide| {
            let moving = Signals {
                position: slide.position,
                velocity: slide.velocity,
                acceleration: slide.acceleration,
                direction: slide.direction,
                ..Signals::default()
            };
            law.value(p, &moving)
        })),
        _ => None,
    }
}

/// Whether an effect follows the motion in proportion.
fn is_proportional(effect: &Effect, p: Values<'_>) -> bool {
    /// By what a motion is multiplied: reversed, it tells what has a sign of its own.
    const FACTOR: f64 = -0.5;
    let is = |force: Along<'_>| {
        INSTANTS.iter().all(|[position, velocity, acceleration]| {
            let at = |factor: f64| {
                force(&Slide {
                    position: factor * position,
                    acceleration: factor * acceleration,
                    ..Slide::at_velocity(factor * velocity)
                })
            };
            let (whole, part) = (at(1.0), at(FACTOR));
            (part - FACTOR * whole).abs() <= 1e-9 * whole.abs()
        })
    };
    matches!(effect.law, Law::Tool(_)) || along(effect, p).is_some_and(is)
}

/// Of an effect that depends on the position alone the part that is proportional to it, by least squares beside a constant force.
fn proportional_part(scene: &Scene, effect: &Effect, p: Values<'_>) -> Option<Column> {
    let force = along(effect, p)?;
    let moves = |[position, velocity, acceleration]: &[f64; 3]| {
        let at_rest = Slide {
            position: *position,
            ..Slide::default()
        };
        let moving = Slide {
            position: *position,
            acceleration: *acceleration,
            ..Slide::at_velocity(*velocity)
        };
        force(&at_rest) != force(&moving)
    };
    if INSTANTS.iter().any(moves) {
        return None;
    }
    let form = |name| effect.place(name).map_or(0.0, |k| p[k]);
    let acts_at = form("acts_at");
    if let Law::Spring(law) = effect.law {
        let rests_at_start = form("about_start") > 0.5;
        let displacement = laws::displacement(scene, rests_at_start, acts_at);
        let stretched: Vec<Vector3<f64>> = (0..scene.len()).map(displacement).collect();
        let slope = slope(&stretched, |d| law(p, d));
        return Some(laws::spring(scene, rests_at_start, acts_at, |d| slope * d));
    }
    let positions: Vec<Vector3<f64>> = scene
        .position
        .iter()
        .map(|position| Vector3::x() * *position)
        .collect();
    let slope = slope(&positions, |at| {
        let slide = Slide {
            position: at.x,
            ..Slide::default()
        };
        Vector3::x() * force(&slide)
    });
    Some(scene.guide_force(acts_at, |n| slope * scene.position[n]))
}

/// Slope of a force over positions; none where nothing moves.
fn slope(positions: &[Vector3<f64>], force: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> f64 {
    let count = positions.len().max(1) as f64;
    let forces: Vec<Vector3<f64>> = positions.iter().map(force).collect();
    let mean = |all: &[Vector3<f64>]| all.iter().sum::<Vector3<f64>>() / count;
    let (at, mean_force) = (mean(positions), mean(&forces));
    let squares: f64 = positions.iter().map(|p| (p - at).norm_squared()).sum();
    let both = positions.iter().zip(&forces);
    let products: f64 = both.map(|(p, f)| (p - at).dot(&(f - mean_force))).sum();
    if squares > 0.0 {
        products / squares
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::effects::LoadEffect;
    use super::*;
    use crate::model::Model;
    use nalgebra::UnitQuaternion;
    use softdock_control::frames::{Pose, Twist};
    use softdock_control::wrench::Motion;

    const CYCLE_S: f64 = 0.004;

    /// A pendulum about x that swings by a hundredth of a radian at as many hertz.
    fn swinging(hz: f64) -> Scene {
        let model =
            "[rig]\nactive_axes = [\"rx\"]\n[sensor]\nfilter = { order = 4, cutoff_hz = 10.0 }\n";
        let model = Model::from_toml(model, "model.toml").unwrap();
        let omega = std::f64::consts::TAU * hz;
        let time_s: Vec<f64> = (0..2000).map(|n| CYCLE_S * f64::from(n)).collect();
        let pose = |t: &f64| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::x() * 0.01 * (omega * t).sin());
            Pose::from_parts(Vector3::zeros().into(), turn)
        };
        let motion = |t: &f64| {
            let rate = 0.01 * omega * (omega * t).cos();
            Motion {
                velocity: Twist::of(&[0.0, 0.0, 0.0, rate, 0.0, 0.0]),
                acceleration: Twist::zero(),
            }
        };
        let poses = time_s.iter().map(pose).collect();
        let motions = time_s.iter().map(motion).collect();
        Scene::new(&model, CYCLE_S, time_s, poses, motions)
    }

    /// Root mean square of what is left in the middle of a log.
    fn rms(column: &Column) -> f64 {
        softdock_statistics::rms(&column.0[3][500..1500])
    }

    fn loaded(scene: &Scene, id: &str, name: &str, value: f64) -> Column {
        let effect = LoadEffect::find(&scene.model, id).unwrap();
        let parameters = [(name.to_owned(), value)].into();
        effect.contribution(scene, &parameters)
    }

    /// Over a small angle a weight is a spring, at whatever frequency: what the filter has left of the angle is not filtered again.
    #[test]
    fn a_weight_is_filtered_as_a_spring_is() {
        for hz in [2.0, 9.0, 12.0] {
            let scene = swinging(hz);
            let spring = loaded(&scene, "cable_stiffness", "stiffness_n_m_per_rad", 100.0);
            let weight = loaded(&scene, "bearing_gravity", "sine_n_m", 100.0);
            let left = rms(&spring.clone().less(&weight)) / rms(&spring);
            assert!(left < 1e-4, "{left} at {hz} Hz");
        }
    }

    /// A sharp friction has harmonics, which the filter takes.
    #[test]
    fn a_friction_is_filtered_as_it_was_recorded() {
        let friction = loaded(&swinging(9.0), "guide_coulomb", "torque_n_m", 1.0);
        let fundamental = 4.0 / std::f64::consts::PI / std::f64::consts::SQRT_2;
        let passes = 1.0 / (1.0 + 0.9_f64.powi(8));
        assert!((rms(&friction) / (fundamental * passes) - 1.0).abs() < 0.02);
    }
}
