//! Pictures of the simulated spacecraft's effects and of the clock's.

use super::excitation::{
    BOUNCE_S, CYCLE_S, Excitation, JOG_S, PUSH_S, STEP_S, bounce, instants, push, steady_jog,
    wall_push,
};
use super::picture::{Curve, Picture};
use super::size::Size;
use anyhow::{Result, bail};
use softdock_control::settings::BodySettings;
use softdock_physics::effects::{Clock, Effect, Law};
use softdock_statistics::RandomStream;

/// Nominal mass of the spacecraft, kg.
const SPACECRAFT_KG: f64 = 100.0;
/// Nominal inertia of the spacecraft, kg·m².
const INERTIA_KG_M2: [[f64; 3]; 3] = [[60.0, 0.0, 0.0], [0.0, 60.0, 0.0], [0.0, 0.0, 60.0]];

pub(super) fn picture(effect: &Effect, size: &Size) -> Result<Picture> {
    let p = size.values();
    match effect.law {
        Law::Spacecraft(law) => Ok(spacecraft(size, |body| law(&p, body))),
        Law::Clock(Clock::Scatter(law)) => Ok(jitter(size, |draw| law(&p, draw))),
        Law::Clock(Clock::Rate(law)) => Ok(rate(size, 1.0 + law(&p))),
        Law::ClockOffset(law) => Ok(offset(size, law(&p))),
        _ => bail!("the body's effect `{}` has no picture", effect.id),
    }
}

/// Velocity of the simulated spacecraft under a push. Where `change` alters the inertia, the push is a torque about z and the
/// curve is the angular rate.
pub(super) fn spacecraft(size: &Size, change: impl Fn(&mut BodySettings)) -> Picture {
    let nominal = BodySettings {
        mass_kg: SPACECRAFT_KG,
        inertia_kg_m2: INERTIA_KG_M2,
        ..BodySettings::default()
    };
    let mut changed = nominal.clone();
    change(&mut changed);
    let turns = changed.inertia_kg_m2 != nominal.inertia_kg_m2;
    let floating = |body: &BodySettings| -> Curve {
        let (stiffness, damping) = body.arm_resistance_per_kg();
        let (mut position, mut velocity) = (0.0, 0.0);
        let step = |t: f64| {
            let acceleration = match turns {
                true => push(t) / body.inertia_kg_m2[2][2],
                false => push(t) / body.mass_kg - stiffness * position - damping * velocity,
            };
            velocity += STEP_S * acceleration;
            position += STEP_S * velocity;
            (t, velocity)
        };
        instants(PUSH_S).map(step).collect()
    };
    let velocity = match turns {
        true => "rate of the rig's model [rad/s]",
        false => "velocity of the rig's model [m/s]",
    };
    Picture::new(
        Excitation::Push,
        size,
        ["time [s]", velocity],
        [floating(&nominal), floating(&changed)],
    )
}

/// Position increments from cycle to cycle, with a jitter of the sampling instants: `deviation` turns standard normal noise
/// into the error of an instant, s.
fn jitter(size: &Size, deviation: impl Fn(f64) -> f64) -> Picture {
    let increments = |deviation: &dyn Fn(f64) -> f64| -> Curve {
        let mut noise = RandomStream::new(1, 0);
        let cycles = (JOG_S / CYCLE_S) as u32;
        let mut last = 0.0;
        let cycle = |n: u32| {
            let nominal = f64::from(n) * CYCLE_S;
            let now = nominal + deviation(noise.normal());
            let increment = steady_jog(nominal) * (now - last);
            last = now;
            (nominal, increment)
        };
        (1..=cycles).map(cycle).collect()
    };
    Picture::new(
        Excitation::SteadyJog,
        size,
        ["time [s]", "position increment per cycle [m]"],
        [increments(&|_| 0.0), increments(&deviation)],
    )
}

/// Contact force over the penetration that the log pairs with it, where the penetration is older by `late_s`.
fn offset(size: &Size, late_s: f64) -> Picture {
    let paired = |late_s: f64| -> Curve {
        let row = |t: f64| (bounce(t - late_s).position, wall_push(bounce(t).position));
        instants(BOUNCE_S).map(row).collect()
    };
    Picture::new(
        Excitation::Bounce,
        size,
        ["penetration [m]", "force [N]"],
        [paired(0.0), paired(late_s)],
    )
}

/// Position over time where one nominal second really lasts `second_s`.
fn rate(size: &Size, second_s: f64) -> Picture {
    let travelled = |second_s: f64| -> Curve {
        let mut position = 0.0;
        let step = |t: f64| {
            position += steady_jog(t) * second_s * STEP_S;
            (t, position)
        };
        instants(JOG_S).map(step).collect()
    };
    Picture::new(
        Excitation::SteadyJog,
        size,
        ["time [s]", "position [m]"],
        [travelled(1.0), travelled(second_s)],
    )
}
