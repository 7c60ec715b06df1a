//! Effect of an import's low-pass on a load, if the motion of the log was filtered as well.
//!
//! A load that is proportional to the motion is computed from the filtered motion and is thereby filtered. A friction is not: the
//! sign of a velocity has frequencies of its own, so its force is filtered like the recorded one. A load that depends on the
//! position alone, such as the weight of a link, is split: its part that is proportional to the position over the log is of the
//! first kind, the rest of the second.

use super::{Column, Scene, laws};
use crate::effects::formula::{ActsOn, Signals};
use crate::effects::{Effect, Law, Role, Slide, Values};
use crate::model::FilterModel;
use nalgebra::Vector3;

/// The load of an effect as it appears in the log, from the `part` that is computed with the filtered motion.
pub(super) fn load(
    filter: FilterModel,
    scene: &Scene,
    effect: &Effect,
    p: Values<'_>,
    part: Column,
) -> Column {
    if matches!(effect.law, Law::Tool(_)) || is_proportional(effect, p) {
        return part;
    }
    let terms = terms(effect, p).into_iter();
    let mut filtered = Column::default();
    for term in terms.filter_map(|p| proportional_part(scene, effect, &p)) {
        filtered.add(&term.0);
    }
    let mut load = through(filter, scene.cycle_s, part.minus(&filtered));
    load.add(&filtered.0);
    load
}

fn through(filter: FilterModel, cycle_s: f64, mut part: Column) -> Column {
    for series in part.0.iter_mut().filter(|series| !series.is_empty()) {
        *series = filter.zero_phase(cycle_s, series);
    }
    part
}

/// Parameter sets of the parts that are filtered separately: for a user's hypothesis one per amount, as a search has a column for
/// each. A law of the catalogue is a single part.
fn terms(effect: &Effect, p: Values<'_>) -> Vec<Vec<f64>> {
    if !matches!(effect.law, Law::Formula(_)) {
        return vec![p.to_vec()];
    }
    let is_amount = |k: &usize| matches!(effect.parameters[*k].role, Role::Linear);
    let amounts: Vec<usize> = (0..p.len()).filter(is_amount).collect();
    let alone = |own: &usize| {
        let others = amounts.iter().filter(|k| *k != own);
        let mut term = p.to_vec();
        others.for_each(|k| term[*k] = 0.0);
        term
    };
    amounts.iter().map(alone).collect()
}

/// Three instants of an arbitrary motion: position, velocity, acceleration, time and push of the walls.
const INSTANTS: [[f64; 5]; 3] = [
    [0.7, 0.4, -3.0, 1.7, 5.0],
    [-0.3, 1.1, 2.0, 0.3, -2.0],
    [1.3, -0.6, 0.5, 2.9, 0.6],
];

/// One of these instants, with its motion multiplied by a factor.
fn instant([position, velocity, acceleration, time, force]: [f64; 5], factor: f64) -> Signals {
    let slide = Slide::at_velocity(factor * velocity);
    Signals {
        position: factor * position,
        velocity: slide.velocity,
        acceleration: factor * acceleration,
        direction: slide.direction,
        time,
        force,
        ..Signals::default()
    }
}

/// Force along a guide, or torque about a bearing, from its motion.
type Along<'a> = Box<dyn Fn(&Signals) -> f64 + 'a>;

/// Force of an effect along its guide or about its bearing; `None` if it does not act so.
fn along<'a>(effect: &Effect, p: Values<'a>) -> Option<Along<'a>> {
    let slide = |moving: &Signals| Slide {
        position: moving.position,
        velocity: moving.velocity,
        acceleration: moving.acceleration,
        direction: moving.direction,
    };
    match effect.law {
        Law::Guide(law) | Law::Bearing(law) => {
            Some(Box::new(move |moving| (law.force)(p, &slide(moving))))
        }
        Law::Spring(law) => Some(Box::new(move |moving| {
            law(p, &Vector3::x().scale(moving.position)).x
        })),
        Law::Formula(law) if law.acts_on == ActsOn::Guide => {
            Some(Box::new(move |moving| law.value(p, moving)))
        }
        _ => None,
    }
}

/// Whether an effect is proportional to the motion.
fn is_proportional(effect: &Effect, p: Values<'_>) -> bool {
    /// Factor on the motion: a negative one shows whether the effect depends on a sign.
    const FACTOR: f64 = -0.5;
    let is = |force: Along<'_>| {
        INSTANTS.iter().all(|of| {
            let (whole, part) = (force(&instant(*of, 1.0)), force(&instant(*of, FACTOR)));
            (part - FACTOR * whole).abs() <= 1e-9 * whole.abs()
        })
    };
    along(effect, p).is_some_and(is)
}

/// The part of an effect that is proportional to the motion: all of it, or for one that depends on the position alone the part
/// proportional to that, by least squares beside a constant. `None` if there is no such part.
fn proportional_part(scene: &Scene, effect: &Effect, p: Values<'_>) -> Option<Column> {
    let force = along(effect, p)?;
    if is_proportional(effect, p) {
        return laws::part(scene, &Column::default(), effect, p);
    }
    let at_rest = |position: f64| Signals {
        position,
        ..Signals::default()
    };
    let depends_on_more = |of: &[f64; 5]| force(&at_rest(of[0])) != force(&instant(*of, 1.0));
    if INSTANTS.iter().any(depends_on_more) {
        return None;
    }
    let form = |name| effect.place(name).map_or(0.0, |k| p[k]);
    let acts_at = form("acts_at");
    if let Law::Spring(law) = effect.law {
        let rests_at_start = form("about_start") > 0.5;
        let displacement = laws::displacement(scene, rests_at_start, acts_at);
        let stretched: Vec<Vector3<f64>> = (0..scene.len()).map(displacement).collect();
        let slope = slope(&stretched, |d| law(p, d))?;
        return Some(laws::spring(scene, rests_at_start, acts_at, |d| slope * d));
    }
    let positions = scene.position.iter().map(|at| Vector3::x() * *at);
    let slope = slope(&positions.collect::<Vec<_>>(), |at| {
        Vector3::x() * force(&at_rest(at.x))
    })?;
    Some(scene.guide_force(acts_at, |n| slope * scene.position[n]))
}

/// Slope of a force over positions; `None` without a motion or if the force is undefined.
fn slope(positions: &[Vector3<f64>], force: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Option<f64> {
    let count = positions.len().max(1) as f64;
    let forces: Vec<Vector3<f64>> = positions.iter().map(force).collect();
    let mean = |all: &[Vector3<f64>]| all.iter().sum::<Vector3<f64>>() / count;
    let (at, mean_force) = (mean(positions), mean(&forces));
    let squares: f64 = positions.iter().map(|p| (p - at).norm_squared()).sum();
    let both = positions.iter().zip(&forces);
    let products: f64 = both.map(|(p, f)| (p - at).dot(&(f - mean_force))).sum();
    Some(products / squares).filter(|slope| slope.is_finite())
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
        swinging_with("", hz)
    }

    fn swinging_with(hypothesis: &str, hz: f64) -> Scene {
        let text = format!(
            "[rig]\nactive_axes = [\"rx\"]\n[sensor]\nfilter = {{ order = 4, cutoff_hz = 10.0 }}\n{hypothesis}"
        );
        let model = Model::from_toml(&text, "model.toml").unwrap();
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

    /// Rms in the middle of a log.
    fn rms(column: &Column) -> f64 {
        softdock_statistics::rms(&column.0[3][500..1500])
    }

    fn loaded(scene: &Scene, id: &str, name: &str, value: f64) -> Column {
        let effect = LoadEffect::find(&scene.model, id).unwrap();
        let parameters = [(name.to_owned(), value)].into();
        effect.contribution(scene, &parameters)
    }

    /// Over a small angle a weight is a spring, at any frequency: it is not filtered again.
    #[test]
    fn a_weight_is_filtered_as_a_spring_is() {
        for hz in [2.0, 9.0, 12.0] {
            let scene = swinging(hz);
            let spring = loaded(&scene, "cable_stiffness", "stiffness_n_m_per_rad", 100.0);
            let weight = loaded(&scene, "bearing_gravity", "sine_n_m", 100.0);
            let left = rms(&spring.clone().minus(&weight)) / rms(&spring);
            assert!(left < 1e-4, "{left} at {hz} Hz");
        }
    }

    /// The load by a user's hypothesis about the bearing.
    fn own(formula: &str, parameters: [(&str, &str, f64); 3]) -> Column {
        let declared = parameters.map(|(name, unit, _)| {
            format!("{name} = {{ unit = \"{unit}\", low = 0, high = 99 }}\n")
        });
        let text = format!(
            "[[hypothesis]]\nid = \"mine\"\nacts_on = \"guide\"\nformula = \"{formula}\"\n[hypothesis.parameters]\n{}",
            declared.concat()
        );
        let scene = swinging_with(&text, 9.0);
        let effect = LoadEffect::find(&scene.model, "mine").unwrap();
        let values = parameters.map(|(name, _, value)| (name.to_owned(), value));
        effect.contribution(&scene, &values.into())
    }

    /// A sine and a cosine of time, which do not depend on the motion, are both filtered: to half at the cutoff.
    #[test]
    fn what_follows_the_time_is_filtered() {
        let formula = "a * sin(2 * PI * f * time) + b * cos(2 * PI * f * time)";
        let parameters = [("a", "N·m", 2.0), ("b", "N·m", 2.0), ("f", "Hz", 10.0)];
        let left = rms(&own(formula, parameters));
        assert!((left - 1.0).abs() < 0.01, "{left}");
    }

    /// A search has a column for each amount, and a prediction the sum of both.
    #[test]
    fn amounts_of_a_hypothesis_are_filtered_each_by_itself() {
        let of = |a, b| {
            let parameters = [("a", "N·m", a), ("b", "N·m·s/rad", b), ("p", "rad", 0.02)];
            own("a * sin(position / p) + b * velocity", parameters)
        };
        let mut apart = of(2.0, 0.0);
        apart.add(&of(0.0, 3.0).0);
        let both = of(2.0, 3.0);
        let left = rms(&both.clone().minus(&apart)) / rms(&both);
        assert!(left < 1e-9, "{left}");
    }

    /// A sharp friction has harmonics, which the filter removes.
    #[test]
    fn a_friction_is_filtered_as_it_was_recorded() {
        let friction = loaded(&swinging(9.0), "guide_coulomb", "torque_n_m", 1.0);
        let fundamental = 4.0 / std::f64::consts::PI / std::f64::consts::SQRT_2;
        let passes = 1.0 / (1.0 + 0.9_f64.powi(8));
        assert!((rms(&friction) / (fundamental * passes) - 1.0).abs() < 0.02);
    }
}
