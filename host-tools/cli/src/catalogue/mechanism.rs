//! Pictures of the mechanism's effects: forces of guide, contact, cable and manipulator.

use super::body::spacecraft;
use super::docking;
use super::excitation::{
    BOUNCE_S, Excitation, Motion, SLIDE_S, STEP_S, WALL_AT_M, between_walls, bounce, instants,
    slide, wall_push,
};
use super::picture::{Curve, Picture};
use super::size::Size;
use anyhow::{Result, bail};
use nalgebra::Vector3;
use softdock_physics::effects::{
    Direction, Effect, Facing, Law, Penetration, Reversal, Slide, Values,
};

/// Angle per metre of the sliding motion, rad/m: rotations are pictured with an amplitude of 1.5 rad to each side.
const TURN_PER_M: f64 = 500.0;

pub(super) fn picture(effect: &Effect, size: &Size) -> Result<Picture> {
    let p = size.values();
    let force = "force on the moving side [N]";
    Ok(match effect.law {
        Law::Guide(law) => {
            let reversal = (law.reversal)(&p).unwrap_or(Reversal::Sharp);
            let mut direction = Direction::new(reversal);
            let along = |m: &Motion| {
                let slide = Slide {
                    position: m.position,
                    velocity: m.velocity,
                    direction: direction.advance(m.velocity, STEP_S),
                    ..Slide::default()
                };
                (law.force)(&p, &slide)
            };
            // A friction that builds up over a distance is a hysteresis loop over the position.
            match matches!(reversal, Reversal::OverDistance(_) | Reversal::BoucWen(_)) {
                true => sliding(size, ["position [m]", force], |m| m.position, along),
                false => sliding(size, ["velocity [m/s]", force], |m| m.velocity, along),
            }
        }
        Law::Bearing(law) => {
            let turn = |m: &Motion| Slide {
                position: TURN_PER_M * m.position,
                velocity: TURN_PER_M * m.velocity,
                acceleration: TURN_PER_M * m.acceleration,
                ..Slide::at_velocity(m.velocity)
            };
            let labels = ["angle [rad]", "torque on the moving side [N·m]"];
            let torque = |m: &Motion| (law.force)(&p, &turn(m));
            sliding(size, labels, |m| TURN_PER_M * m.position, torque)
        }
        Law::Spring(law) => {
            let labels = ["position [m]", force];
            let along = |m: &Motion| law(&p, &Vector3::new(m.position, 0.0, 0.0)).x;
            sliding(size, labels, |m| m.position, along)
        }
        Law::Push(law) => bouncing(size, |touch| law(&p, touch)),
        Law::Depth(law) => both_walls(size, |nominal, facing| law(&p, nominal, facing)),
        Law::Friction(law) => contact_friction(size, law, &p),
        Law::Docking(law) => docking::picture(size, |kind| law(&p, kind))?,
        Law::Spacecraft(law) => spacecraft(size, |body| law(&p, body)),
        _ => bail!("the mechanism's effect `{}` has no picture", effect.id),
    })
}

/// Force over a quantity of the sliding motion: zero without the effect, `force` with it.
fn sliding(
    size: &Size,
    labels: [&'static str; 2],
    over: impl Fn(&Motion) -> f64,
    mut force: impl FnMut(&Motion) -> f64,
) -> Picture {
    let motions: Vec<Motion> = instants(SLIDE_S).map(slide).collect();
    let without = motions.iter().map(|m| (over(m), 0.0)).collect();
    let with = motions.iter().map(|m| (over(m), force(m))).collect();
    Picture::new(Excitation::Slide, size, labels, [without, with])
}

/// Contact force over penetration, without and with an additional force; a wall cannot pull.
fn bouncing(size: &Size, further: impl Fn(&Penetration) -> f64) -> Picture {
    let curve = |further: &dyn Fn(&Penetration) -> f64| -> Curve {
        let push = |m: Motion| {
            let touch = Penetration {
                depth: m.position,
                rate: m.velocity,
                onset: 1.0,
            };
            let further = if m.position > 0.0 {
                further(&touch)
            } else {
                0.0
            };
            (m.position, (wall_push(m.position) + further).max(0.0))
        };
        instants(BOUNCE_S).map(bounce).map(push).collect()
    };
    let labels = ["penetration [m]", "push of the wall [N]"];
    let curves = [curve(&|_| 0.0), curve(&further)];
    Picture::new(Excitation::Bounce, size, labels, curves)
}

/// Force over position between two walls; `depth` computes the penetration of a wall from the nominal one.
fn both_walls(size: &Size, depth: impl Fn(f64, &Facing) -> f64) -> Picture {
    let facing = |along_axis, number| Facing { along_axis, number };
    let force = |x: f64, depth: &dyn Fn(f64, &Facing) -> f64| {
        let front = depth(x - WALL_AT_M, &facing(-1.0, 1));
        wall_push(depth(-WALL_AT_M - x, &facing(1.0, 2))) - wall_push(front)
    };
    let curve = |law: &dyn Fn(f64, &Facing) -> f64| -> Curve {
        between_walls().map(|x| (x, force(x, law))).collect()
    };
    Picture::new(
        Excitation::BothWalls,
        size,
        ["position [m]", "force of the walls [N]"],
        [curve(&|nominal, _| nominal), curve(&depth)],
    )
}

/// The tip slides along the wall during the bounce, first to one side and then to the other.
fn contact_friction(
    size: &Size,
    law: fn(Values<'_>, f64, &Vector3<f64>) -> Vector3<f64>,
    p: Values<'_>,
) -> Picture {
    let across = |t: f64| {
        let sliding = Vector3::new(0.0, slide(t).velocity, 0.0);
        law(p, wall_push(bounce(t).position), &sliding).y
    };
    Picture::new(
        Excitation::Bounce,
        size,
        ["time [s]", "force along the wall [N]"],
        [
            instants(BOUNCE_S).map(|t| (t, 0.0)).collect(),
            instants(BOUNCE_S).map(|t| (t, across(t))).collect(),
        ],
    )
}
