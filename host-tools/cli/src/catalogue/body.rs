//! Pictures of the simulated spacecraft's effects and of the clock's.

use super::excitation::{
    BOUNCE_S, CYCLE_S, Excitation, JOG_S, PUSH_S, STEP_S, bounce, instants, push, steady_jog,
    wall_push,
};
use super::picture::{Curve, Picture};
use super::size::Size;
use anyhow::{Result, bail};
use nalgebra::Vector3;
use softdock_physics::effects::body::clock_jitter::ClockJitter;
use softdock_physics::effects::body::clock_offset::ClockOffset;
use softdock_physics::effects::body::clock_rate::ClockRate;
use softdock_physics::effects::body::sc_inertia_error::InertiaError;
use softdock_physics::effects::body::sc_mass_error::MassError;
use softdock_statistics::RandomStream;

/// Nominal mass of the spacecraft, kg.
const SPACECRAFT_KG: f64 = 100.0;
/// Nominal inertia of the spacecraft, kg·m².
const INERTIA_KG_M2: [[f64; 3]; 3] = [[60.0, 0.0, 0.0], [0.0, 60.0, 0.0], [0.0, 0.0, 60.0]];

pub(super) fn picture(id: &str, size: &Size) -> Result<Picture> {
    match id {
        "sc_mass_error" => mass(size),
        "sc_inertia_error" => inertia(size),
        "clock_jitter" => jitter(size),
        "clock_offset" => offset(size),
        "clock_rate" => rate(size),
        other => bail!("the body's effect `{other}` has no picture"),
    }
}

/// The sum of an acceleration under [`push`].
fn floating(acceleration: impl Fn(f64) -> f64) -> Curve {
    let mut velocity = 0.0;
    let step = |t: f64| {
        velocity += STEP_S * acceleration(push(t));
        (t, velocity)
    };
    instants(PUSH_S).map(step).collect()
}

fn mass(size: &Size) -> Result<Picture> {
    let under = |spacecraft: MassError| {
        floating(move |force| spacecraft.acceleration(&Vector3::new(force, 0.0, 0.0)).x)
    };
    let spacecraft = MassError::new(SPACECRAFT_KG, size.get("mass_error_kg"))?;
    Ok(Picture::new(
        Excitation::Push,
        size,
        ["time [s]", "velocity of the rig's model [m/s]"],
        [
            under(MassError::new(SPACECRAFT_KG, 0.0)?),
            under(spacecraft),
        ],
    ))
}

fn inertia(size: &Size) -> Result<Picture> {
    let under = |spacecraft: InertiaError| {
        floating(move |torque| {
            let torque = Vector3::new(0.0, 0.0, torque);
            spacecraft
                .angular_acceleration(&torque, &Vector3::zeros())
                .z
        })
    };
    let error = size.all(["ixx_kg_m2", "iyy_kg_m2", "izz_kg_m2"]);
    let spacecraft = InertiaError::new(&INERTIA_KG_M2, &error)?;
    Ok(Picture::new(
        Excitation::Push,
        size,
        ["time [s]", "rate of the rig's model [rad/s]"],
        [
            under(InertiaError::new(&INERTIA_KG_M2, &[0.0; 3])?),
            under(spacecraft),
        ],
    ))
}

/// Increments of the position from cycle to cycle.
fn jitter(size: &Size) -> Result<Picture> {
    let increments = |clock: ClockJitter| -> Curve {
        let mut noise = RandomStream::new(1, 0);
        let cycles = (JOG_S / CYCLE_S) as u32;
        let mut last = 0.0;
        let cycle = |n: u32| {
            let nominal = f64::from(n) * CYCLE_S;
            let now = clock.instant(nominal, noise.normal());
            let increment = steady_jog(nominal) * (now - last);
            last = now;
            (nominal, increment)
        };
        (1..=cycles).map(cycle).collect()
    };
    let clock = ClockJitter::new(size.get("jitter_s"))?;
    Ok(Picture::new(
        Excitation::SteadyJog,
        size,
        ["time [s]", "position increment per cycle [m]"],
        [increments(ClockJitter::new(0.0)?), increments(clock)],
    ))
}

/// Force over the penetration that the log pairs with it.
fn offset(size: &Size) -> Result<Picture> {
    let paired = |clock: ClockOffset| -> Curve {
        instants(BOUNCE_S)
            .map(|t| {
                // The log's row at t holds the pose that was stamped t.
                let pose_instant = t - (clock.pose_time(t) - t);
                let force = wall_push(bounce(t).position);
                (bounce(pose_instant).position, force)
            })
            .collect()
    };
    let clock = ClockOffset::new(size.get("offset_s"))?;
    Ok(Picture::new(
        Excitation::Bounce,
        size,
        ["penetration [m]", "force [N]"],
        [paired(ClockOffset::new(0.0)?), paired(clock)],
    ))
}

/// Position, integrated with the real length of the cycles.
fn rate(size: &Size) -> Result<Picture> {
    let travelled = |clock: ClockRate| -> Curve {
        let mut position = 0.0;
        let step = |t: f64| {
            let real_step = clock.real_time(t + STEP_S) - clock.real_time(t);
            position += steady_jog(t) * real_step;
            (t, position)
        };
        instants(JOG_S).map(step).collect()
    };
    let clock = ClockRate::new(size.get("rate_error"))?;
    Ok(Picture::new(
        Excitation::SteadyJog,
        size,
        ["time [s]", "position [m]"],
        [travelled(ClockRate::new(0.0)?), travelled(clock)],
    ))
}
