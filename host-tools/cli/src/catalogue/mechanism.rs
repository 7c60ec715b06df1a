//! Pictures of the mechanism's effects: forces of guide, contact, cable and manipulator.

use super::excitation::{
    BOUNCE_S, Excitation, Motion, PUSH_S, SLIDE_S, STEP_S, WALL_AT_M, between_walls, bounce,
    instants, push, slide, wall_push,
};
use super::picture::{Curve, Picture};
use super::size::Size;
use anyhow::{Result, bail};
use nalgebra::Vector3;
use softdock_control::effects::mechanism::cable_stiffness::CableSpring;
use softdock_control::effects::mechanism::contact_coulomb::CoulombFriction;
use softdock_control::effects::mechanism::contact_cubic::CubicSpring;
use softdock_control::effects::mechanism::contact_damping::ContactDamping;
use softdock_control::effects::mechanism::contact_deadzone::DeadZone;
use softdock_control::effects::mechanism::contact_stiffness::StiffnessError;
use softdock_control::effects::mechanism::guide_asymmetry::AsymmetricFriction;
use softdock_control::effects::mechanism::guide_coulomb::DryFriction;
use softdock_control::effects::mechanism::guide_hysteresis::BoucWen;
use softdock_control::effects::mechanism::guide_offset::ConstantForce;
use softdock_control::effects::mechanism::guide_stribeck::StribeckFriction;
use softdock_control::effects::mechanism::guide_viscous::ViscousFriction;
use softdock_control::effects::mechanism::hunt_crossley::HuntCrossley;
use softdock_control::effects::mechanism::manipulator_resistance::ManipulatorResistance;
use softdock_control::effects::mechanism::wall_position::WallPosition;

/// Mass of the spacecraft that the manipulator holds, kg.
const SPACECRAFT_KG: f64 = 100.0;

/// From a motion to a force, N.
type Law = Box<dyn FnMut(&Motion) -> f64>;

pub(super) fn picture(id: &str, size: &Size) -> Result<Picture> {
    match id {
        "manipulator_resistance" => manipulator(size),
        "contact_coulomb" => contact_friction(size),
        "wall_position" => {
            let walls = WallPosition::new(size.get("shift_m"))?;
            Ok(both_walls(size, |nominal, normal| {
                walls.penetration(nominal, normal)
            }))
        }
        "contact_deadzone" => {
            let play = DeadZone::new(size.get("gap_m"))?;
            Ok(both_walls(size, |nominal, _| play.penetration(nominal)))
        }
        "guide_hysteresis" | "cable_stiffness" => {
            let labels = ["position [m]", "force on the moving side [N]"];
            let curves = sliding(guide(id, size)?, |motion| motion.position);
            Ok(Picture::new(Excitation::Slide, size, labels, curves))
        }
        _ if id.starts_with("guide_") => {
            let labels = ["velocity [m/s]", "force on the moving side [N]"];
            let curves = sliding(guide(id, size)?, |motion| motion.velocity);
            Ok(Picture::new(Excitation::Slide, size, labels, curves))
        }
        _ => {
            let nominal: Law = Box::new(|m| wall_push(m.position));
            let labels = ["penetration [m]", "push of the wall [N]"];
            let curves = [bouncing(nominal), bouncing(contact(id, size)?)];
            Ok(Picture::new(Excitation::Bounce, size, labels, curves))
        }
    }
}

/// No force, and that of a law, over a quantity of the sliding motion.
fn sliding(mut law: Law, over: impl Fn(&Motion) -> f64) -> [Curve; 2] {
    let motions: Vec<Motion> = instants(SLIDE_S).map(slide).collect();
    let without = motions.iter().map(|m| (over(m), 0.0));
    let with = motions.iter().map(|m| (over(m), law(m)));
    [without.collect(), with.collect()]
}

/// Force over penetration; a wall cannot pull.
fn bouncing(mut law: Law) -> Curve {
    let motions = instants(BOUNCE_S).map(bounce);
    motions.map(|m| (m.position, law(&m).max(0.0))).collect()
}

fn guide(id: &str, size: &Size) -> Result<Law> {
    Ok(match id {
        "guide_coulomb" => {
            let guide = DryFriction::new(size.get("force_n"))?;
            Box::new(move |m| guide.force(m.velocity))
        }
        "guide_viscous" => {
            let guide = ViscousFriction::new(size.get("damping_n_s_per_m"))?;
            Box::new(move |m| guide.force(m.velocity))
        }
        "guide_stribeck" => {
            let [coulomb, excess, speed] =
                size.all(["coulomb_n", "excess_n", "stribeck_speed_m_s"]);
            let guide = StribeckFriction::new(coulomb, excess, speed)?;
            Box::new(move |m| guide.force(m.velocity))
        }
        "guide_asymmetry" => {
            let names = ["forward_n", "backward_n", "viscous_difference_n_s_per_m"];
            let [forward, backward, difference] = size.all(names);
            let guide = AsymmetricFriction::new(forward, backward, difference)?;
            Box::new(move |m| guide.force(m.velocity))
        }
        "guide_offset" => {
            let guide = ConstantForce::new(size.get("force_n"))?;
            Box::new(move |_| guide.force())
        }
        "guide_hysteresis" => {
            let [force, displacement] = size.all(["force_n", "displacement_m"]);
            let (mut guide, mut last) = (BoucWen::new(force, displacement)?, 0.0);
            Box::new(move |m| {
                let step = m.position - last;
                last = m.position;
                guide.advance(step)
            })
        }
        "cable_stiffness" => {
            let cable = CableSpring::new(size.get("stiffness_n_per_m"))?;
            Box::new(move |m| cable.force(m.position))
        }
        other => bail!("the guide's effect `{other}` has no picture"),
    })
}

fn contact(id: &str, size: &Size) -> Result<Law> {
    Ok(match id {
        "contact_stiffness" => {
            let spring = StiffnessError::new(size.get("stiffness_error_n_per_m"))?;
            Box::new(move |m| wall_push(m.position) + spring.force(m.position))
        }
        "contact_cubic" => {
            let spring = CubicSpring::new(size.get("stiffness_n_per_m3"))?;
            Box::new(move |m| wall_push(m.position) + spring.force(m.position))
        }
        "contact_damping" => {
            let damper = ContactDamping::new(size.get("damping_n_s_per_m"), 0.0)?;
            Box::new(move |m| wall_push(m.position) + damper.force(m.position, m.velocity))
        }
        "hunt_crossley" => {
            let [damping, exponent] = size.all(["damping_n_s_per_m2", "exponent"]);
            let damper = HuntCrossley::new(damping, exponent)?;
            Box::new(move |m| wall_push(m.position) + damper.force(m.position, m.velocity))
        }
        other => bail!("the contact's effect `{other}` has no picture"),
    })
}

/// Force over position; `penetration` makes that of a wall from the nominal one and the wall's
/// outward normal.
fn both_walls(size: &Size, penetration: impl Fn(f64, f64) -> f64) -> Picture {
    let force = |x: f64, penetration: &dyn Fn(f64, f64) -> f64| {
        let (front, aft) = (x - WALL_AT_M, -WALL_AT_M - x);
        wall_push(penetration(aft, 1.0)) - wall_push(penetration(front, -1.0))
    };
    let curve =
        |law: &dyn Fn(f64, f64) -> f64| between_walls().map(|x| (x, force(x, law))).collect();
    Picture::new(
        Excitation::BothWalls,
        size,
        ["position [m]", "force of the walls [N]"],
        [curve(&|nominal, _| nominal), curve(&penetration)],
    )
}

/// The tip slides along the wall during the bounce, first to one side and then to the other.
fn contact_friction(size: &Size) -> Result<Picture> {
    let [coefficient, smoothing] = size.all(["friction_coefficient", "smoothing_speed_m_s"]);
    let friction = CoulombFriction::new(coefficient, smoothing)?;
    let across = |t: f64| {
        let sliding = Vector3::new(0.0, slide(t).velocity, 0.0);
        friction.force(wall_push(bounce(t).position), &sliding).y
    };
    Ok(Picture::new(
        Excitation::Bounce,
        size,
        ["time [s]", "force along the wall [N]"],
        [
            instants(BOUNCE_S).map(|t| (t, 0.0)).collect(),
            instants(BOUNCE_S).map(|t| (t, across(t))).collect(),
        ],
    ))
}

fn manipulator(size: &Size) -> Result<Picture> {
    let [stiffness, damping] = size.all(["stiffness_n_per_m", "damping_n_s_per_m"]);
    let arm = ManipulatorResistance::new(stiffness, damping)?;
    let floating = |resistance: &dyn Fn(f64, f64) -> f64| -> Curve {
        let (mut position, mut velocity) = (0.0, 0.0);
        let step = |t: f64| {
            velocity += STEP_S * (push(t) + resistance(position, velocity)) / SPACECRAFT_KG;
            position += STEP_S * velocity;
            (t, velocity)
        };
        instants(PUSH_S).map(step).collect()
    };
    Ok(Picture::new(
        Excitation::Push,
        size,
        ["time [s]", "velocity of the rig's model [m/s]"],
        [floating(&|_, _| 0.0), floating(&|x, v| arm.force(x, v))],
    ))
}
