//! Effect of each kind of law on the sensor's reading over a log.

use super::{Column, Scene, Touch};
use crate::effects::formula::{ActsOn, Formula, Signals};
use crate::effects::sensor::tool::{LoadMotion, ToolState};
use crate::effects::{
    Actuator, DelayAndLag, Direction, Effect, Facing, Group, Guide, Law, Penetration, Slide,
    Values, by_id, sign,
};
use crate::model::{EffectModel, Model, WrenchMeaning};
use nalgebra::{Matrix3, Vector3};
use softdock_control::frames::{Pose, Wrench, matrix};
use softdock_control::wrench::Motion;

/// Whether the log contains what the effect acts on.
pub(super) fn acts(scene: &Scene, effect: &Effect) -> bool {
    let sensor = &scene.model.sensor;
    let live = |meaning| sensor.wrench == meaning && !sensor.at_rest;
    match effect.law {
        _ if effect.is_of_a_contact() => scene.touches_anything(),
        Law::Guide(_) | Law::Bearing(_) | Law::Spring(_) => {
            !sensor.at_rest && (0..scene.len()).any(|n| scene.along(n, 0.0) != 0.0)
        }
        Law::Friction(_) => scene.touches_anything(),
        Law::Docking(_) => scene.docked.iter().any(|wrench| *wrench != Wrench::zero()),
        Law::SensorZero(_) => {
            effect.parameters.iter().all(|p| p.search_start().is_none()) || !sensor.at_rest
        }
        Law::SensorGain(_) => sensor.wrench == WrenchMeaning::Measured,
        Law::Saturation(_) => live(WrenchMeaning::Measured),
        Law::ReadingDelay(_) => live(WrenchMeaning::Measured) && scene.wrench_changes,
        Law::ClockOffset(_) => {
            live(WrenchMeaning::Measured) && !scene.of_a_rig && scene.wrench_changes
        }
        Law::Actuator(Actuator { late, .. }) => {
            let is_seen = late.is_none() || scene.wrench_changes;
            sensor.wrench.is_commanded() && !sensor.at_rest && is_seen
        }
        Law::CommandGain(_) => live(WrenchMeaning::Unscaled),
        Law::Formula(_) => !sensor.at_rest,
        // On a bearing without a known mass, the weight is only a torque, which could as well be that of 1 kg at some lever.
        Law::Tool(_) if effect.is_centre_of_mass_alone() && scene.model.bearing().is_some() => {
            known_mass(&scene.model).is_some()
        }
        _ => true,
    }
}

/// Change of a reading by the effect; `None` for forms that exclude each other.
pub(super) fn part(
    scene: &Scene,
    reading: &Column,
    effect: &Effect,
    p: Values<'_>,
) -> Option<Column> {
    let form = |name| effect.place(name).map_or(0.0, |k| p[k]);
    Some(match effect.law {
        Law::Guide(law) | Law::Bearing(law) => guide(scene, &law, p, form("acts_at"))?,
        Law::Spring(law) => {
            let rests_at_start = form("about_start") > 0.5;
            spring(scene, rests_at_start, form("acts_at"), |d| law(p, d))
        }
        Law::Push(law) => push(scene, |at, _| law(p, at)),
        Law::Depth(law) => depth(scene, |depth, facing| law(p, depth, facing)),
        Law::Friction(law) => friction(scene, |push, sliding| law(p, push, sliding)),
        Law::Docking(law) => {
            let mut settings = scene.model.contact.docking.clone();
            settings.iter_mut().for_each(|d| law(p, &mut d.kind));
            scene.docked_change(&settings)
        }
        Law::Tool(law) => tool(scene, |tool| law(p, tool)),
        Law::SensorGain(law) => {
            let kept = if form("with_zero") > 0.5 { 0.0 } else { 1.0 };
            let zero = Wrench::of(&scene.bias.map(|b| kept * b));
            changed(scene, reading, |reading| {
                let load = *reading - zero;
                law(p, &load) + zero
            })
        }
        Law::CommandGain(law) | Law::Saturation(law) => {
            changed(scene, reading, |wrench| law(p, wrench))
        }
        Law::SensorZero(law) => Column::of(scene.len(), |n| law(p, scene.since_began(n)).get()),
        Law::ReadingDelay(law) => late(scene, reading, law(p)),
        Law::Actuator(Actuator {
            late: Some(law), ..
        }) => early(scene, reading, law(p)),
        Law::ClockOffset(law) => {
            let delay_s = law(p);
            early(
                scene,
                reading,
                DelayAndLag {
                    delay_s,
                    lag_s: 0.0,
                },
            )
        }
        Law::Formula(law) => formula(scene, law, p)?,
        Law::Sample(_) | Law::Actuator(_) | Law::Spacecraft(_) | Law::Clock(_) => return None,
    })
}

/// A force along the guide on the point where it acts.
fn guide(scene: &Scene, law: &Guide, p: Values<'_>, acts_at: f64) -> Option<Column> {
    let mut direction = Direction::new((law.reversal)(p)?);
    Some(scene.guide_force(acts_at, |n| {
        let velocity = scene.along(n, acts_at);
        let slide = Slide {
            position: scene.position[n],
            velocity,
            acceleration: scene.acceleration[n],
            direction: direction.advance(velocity, scene.cycle_s),
        };
        (law.force)(p, &slide)
    }))
}

/// Load by a user's formula; `None` if it is undefined in some cycle.
fn formula(scene: &Scene, law: &Formula, p: Values<'_>) -> Option<Column> {
    let pushes = |n: usize| {
        scene
            .touches
            .iter()
            .map(move |t| t.force[n] * t.normal.dot(&scene.way_of(n, &t.tip)))
    };
    let moving = |n: usize| Signals {
        position: scene.position[n],
        velocity: scene.along(n, 0.0),
        acceleration: scene.acceleration[n],
        direction: sign(scene.along(n, 0.0)),
        force: pushes(n).sum(),
        time: scene.since_began(n),
        ..Signals::default()
    };
    let value = |n: usize| law.value(p, &moving(n));
    let column = match law.acts_on {
        ActsOn::Guide => scene.guide_force(0.0, value),
        ActsOn::Wall => scene.wall_force(|t, n| {
            let outside = Signals {
                gap: (-t.penetration[n]).max(0.0),
                rate: t.rate[n],
                ..moving(n)
            };
            law.value(p, &outside)
        }),
        ActsOn::Reading(axis) => Column::on_axis(axis, (0..scene.len()).map(value)),
        ActsOn::Contact => push(scene, |at, n| {
            let inside = Signals {
                depth: at.depth,
                rate: at.rate,
                ..moving(n)
            };
            law.value(p, &inside)
        }),
    };
    let finite = column.0.iter().flatten().all(|value| value.is_finite());
    finite.then_some(column)
}

/// A force in all directions, given the displacement in C from the origin or from the first position.
pub(super) fn spring(
    scene: &Scene,
    rests_at_start: bool,
    acts_at: f64,
    force: impl Fn(&Vector3<f64>) -> Vector3<f64>,
) -> Column {
    let displacement = displacement(scene, rests_at_start, acts_at);
    if scene.model.bearing().is_some() {
        return scene.guide_force(acts_at, |n| scene.axis.dot(&force(&displacement(n))));
    }
    let at = scene.point_of_action(acts_at);
    Column::of(scene.len(), |n| {
        scene.reading_of(n, &at, &force(&displacement(n)))
    })
}

/// Displacement of a spring in each cycle, in C; for a bearing the angle about its axis.
pub(super) fn displacement(
    scene: &Scene,
    rests_at_start: bool,
    acts_at: f64,
) -> impl Fn(usize) -> Vector3<f64> {
    let turns = scene.model.bearing().is_some();
    let at = scene.point_of_action(acts_at);
    let rest = match (rests_at_start, turns) {
        (false, _) => Vector3::zeros(),
        (true, true) => scene.axis * scene.first_angle(),
        (true, false) => scene.first_place_of(&at) - at,
    };
    move |n| match turns {
        true => scene.axis * scene.position[n] - rest,
        false => scene.pose[n].translation.vector + scene.pose[n].rotation * at - at - rest,
    }
}

/// Additional push of the walls over the nominal one, N; `more` gets the penetration of the tip and the cycle.
fn push(scene: &Scene, more: impl Fn(&Penetration, usize) -> f64) -> Column {
    scene.wall_force(|t, n| {
        let more = penetration(t, n).map_or(0.0, |at| more(&at, n));
        (t.push_at(n, t.penetration[n]) + more).max(0.0) - t.force[n]
    })
}

/// Additional push of the walls if the penetration (m) is another one than nominal.
fn depth(scene: &Scene, other: impl Fn(f64, &Facing) -> f64) -> Column {
    scene.wall_force(|t, n| {
        let facing = Facing {
            along_axis: t.normal.dot(&unit_or_zero(scene.way_of(n, &t.tip))),
            number: t.number,
        };
        t.push_at(n, other(t.penetration[n], &facing)).max(0.0) - t.force[n]
    })
}

/// The unit vector; zero for a point that does not move.
fn unit_or_zero(way: Vector3<f64>) -> Vector3<f64> {
    way.try_normalize(0.0).unwrap_or_default()
}

/// A force of walls across their normals, given their push (N) and the sliding velocity (m/s).
fn friction(scene: &Scene, force: impl Fn(f64, &Vector3<f64>) -> Vector3<f64>) -> Column {
    scene.force_of_walls(|t, n| {
        let (_, velocity) = scene.point(n, &t.tip);
        let sliding = velocity - t.normal * t.normal.dot(&velocity);
        match t.force[n] > 0.0 {
            true => force(t.force[n], &sliding),
            false => Vector3::zeros(),
        }
    })
}

/// A wrench at S of the nominal tool in its motion.
fn tool(scene: &Scene, wrench: impl Fn(&ToolState) -> Wrench<f64>) -> Column {
    let tool = nominal_tool(&scene.model);
    Column::of(scene.len(), |n| {
        let s_from_c = scene.s_from_m * scene.m_from_c[n];
        let (pose, motion) = (&scene.pose[n], &scene.motion[n]);
        wrench(&in_motion(tool, s_from_c, &scene.m_from_s, pose, motion)).get()
    })
}

/// The penetration of the tip in a wall; `None` outside.
fn penetration(t: &Touch, n: usize) -> Option<Penetration> {
    let depth = t.penetration[n];
    (depth > 0.0).then(|| Penetration {
        depth,
        rate: t.rate[n],
        onset: t.onset(depth),
    })
}

/// Change of a reading by a delay and a lag.
fn late(scene: &Scene, reading: &Column, by: DelayAndLag) -> Column {
    let late = reading.each(|series| by.delayed(series, scene.cycle_s));
    late.minus(reading)
}

/// Change of a reading that is early by a delay and a lag, such as a command before its motion; late if the delay is negative.
fn early(scene: &Scene, reading: &Column, by: DelayAndLag) -> Column {
    let DelayAndLag { delay_s, lag_s } = by;
    if delay_s < 0.0 {
        let delay_s = -delay_s;
        return late(scene, reading, DelayAndLag { delay_s, lag_s });
    }
    let early = reading.each(|series| by.anticipated(series, scene.cycle_s));
    early.minus(reading)
}

/// Change of a reading in each cycle.
fn changed(scene: &Scene, reading: &Column, read: impl Fn(&Wrench<f64>) -> Wrench<f64>) -> Column {
    Column::of(scene.len(), |n| {
        let before = Wrench::of(&reading.row(n));
        (read(&before) - before).get()
    })
}

/// The nominal tool at rest, with C as S.
pub fn nominal_tool(model: &Model) -> ToolState {
    let (tool, sensor) = (&model.tool, &model.sensor);
    ToolState {
        mass_kg: tool.mass_kg,
        hanging_kg: hanging(model),
        com: tool.com_m.into(),
        inertia: matrix(&tool.inertia_kg_m2),
        gravity: sensor.gravity_m_s2.into(),
        s_from_c: Matrix3::identity(),
        motion: LoadMotion::uniform(),
        inertial: tool.dynamic_compensation,
    }
}

/// A tool that moves with M, from the pose and motion of M in C; `s_from_c` rotates C to S.
pub fn in_motion(
    tool: ToolState,
    s_from_c: Matrix3<f64>,
    m_from_s: &Pose<f64>,
    pose: &Pose<f64>,
    motion: &Motion<f64>,
) -> ToolState {
    let (velocity, acceleration) = (&motion.velocity, &motion.acceleration);
    ToolState {
        s_from_c,
        motion: LoadMotion::of_sensor(m_from_s, &pose.rotation, velocity, acceleration),
        ..tool
    }
}

/// Known mass of the load on the sensor; 1 kg if the model does not know it, so that a fit gives the product of mass and lever.
pub(super) fn hanging(model: &Model) -> f64 {
    known_mass(model).unwrap_or(1.0)
}

/// The nominal mass of the tool; without one, that of effects on the tool in the model.
fn known_mass(model: &Model) -> Option<f64> {
    if model.tool.mass_kg > 0.0 {
        return Some(model.tool.mass_kg);
    }
    let kilograms = |effect: &EffectModel| -> f64 {
        let of_the_tool =
            by_id(&effect.id).filter(|e| matches!(e.law, Law::Tool(_)) && e.group == Group::Sensor);
        let of_mass = of_the_tool
            .into_iter()
            .flat_map(|e| e.parameters)
            .filter(|p| p.unit == "kg");
        of_mass.filter_map(|p| effect.parameters.get(p.name)).sum()
    };
    let mass = model.effects.iter().map(kilograms).sum::<f64>();
    (mass > 0.0).then_some(mass)
}
