//! Pictures of the sensor's effects: the reading that a wrench gives.

use super::excitation::{
    BOUNCE_S, Excitation, SLIDE_S, STEP_S, bounce, instants, slide, tilts, wall_push,
};
use super::picture::{Curve, Picture};
use super::size::Size;
use anyhow::{Result, bail};
use nalgebra::{Matrix3, Rotation3, Vector3};
use softdock_control::frames::Wrench;
use softdock_physics::effects::sensor::tool::{LoadMotion, ToolState};
use softdock_physics::effects::{DelayLine, Effect, Law};
use softdock_statistics::RandomStream;

/// The tool that hangs on the sensor: mass, kg, and centre of mass, m.
const TOOL_KG: f64 = 5.0;
const TOOL_COM_M: [f64; 3] = [0.0, 0.0, 0.1];
/// Steps between two readings of a slow bus: 8 ms.
const STEPS_PER_READING: usize = 16;
/// Labels of the wrench's components.
const COMPONENTS: [&str; 6] = [
    "force fx [N]",
    "force fy [N]",
    "force fz [N]",
    "torque tx [N m]",
    "torque ty [N m]",
    "torque tz [N m]",
];
/// Lever that makes torques comparable to forces when the component to draw is chosen, m.
const LEVER_M: f64 = 0.02;

/// Wrenches without and with an effect, over the quantity on the x axis.
type Wrenches = Vec<(f64, [Wrench<f64>; 2])>;

pub(super) fn picture(effect: &Effect, size: &Size) -> Result<Picture> {
    let p = size.values();
    let in_a_bounce = |mut read: Box<dyn FnMut(Wrench<f64>) -> Wrench<f64> + '_>| {
        let at = |t: f64| (t, [contact(t), read(contact(t))]);
        shown(
            Excitation::Bounce,
            size,
            "time [s]",
            instants(BOUNCE_S).map(at).collect(),
        )
    };
    Ok(match effect.law {
        Law::Tool(law) => tool(size, |state| law(&p, state)),
        Law::SensorGain(law) | Law::CommandGain(law) => {
            in_a_bounce(Box::new(|load| law(&p, &load)))
        }
        Law::Saturation(law) => in_a_bounce(Box::new(|load| law(&p, &load))),
        Law::ReadingDelay(law) => {
            let mut late = DelayLine::new(law(&p), STEP_S, [0.0; 6]);
            in_a_bounce(Box::new(move |load| Wrench::of(&late.advance(load.get()))))
        }
        Law::Sample(law) => {
            let (mut noise, mut sent) = (RandomStream::new(1, 0), Wrench::zero());
            let mut readings = (0..STEPS_PER_READING).cycle();
            in_a_bounce(Box::new(move |load| {
                if readings.next() == Some(0) {
                    sent = (law.sent)(&p, &load, &sent, 1.0 - noise.uniform());
                }
                sent
            }))
        }
        Law::SensorZero(law) => {
            let seconds = (0..=600).map(|k| f64::from(k) * 0.1);
            let at = |t: f64| (t, [Wrench::zero(), law(&p, t)]);
            shown(
                Excitation::StillLog,
                size,
                "time [s]",
                seconds.map(at).collect(),
            )
        }
        _ => bail!("the sensor's effect `{}` has no picture", effect.id),
    })
}

/// Draws the wrench component that the effect changes most, torques divided by [`LEVER_M`].
fn shown(excitation: Excitation, size: &Size, over: &'static str, wrenches: Wrenches) -> Picture {
    let weight = |axis: usize| if axis < 3 { 1.0 } else { 1.0 / LEVER_M };
    let change = |axis: usize| -> f64 {
        let changes = wrenches.iter().map(|(_, [without, with])| {
            weight(axis) * (with.get()[axis] - without.get()[axis]).abs()
        });
        changes.fold(0.0, f64::max)
    };
    let axis = (0..6)
        .rev()
        .max_by(|a, b| change(*a).total_cmp(&change(*b)))
        .unwrap_or(0);
    let curve = |which: usize| -> Curve {
        wrenches
            .iter()
            .map(|(x, both)| (*x, both[which].get()[axis]))
            .collect()
    };
    Picture::new(
        excitation,
        size,
        [over, COMPONENTS[axis]],
        [curve(0), curve(1)],
    )
}

/// The contact's wrench in a bounce.
fn contact(time_s: f64) -> Wrench<f64> {
    Wrench::of(&[wall_push(bounce(time_s).position), 0.0, 0.0, 0.0, 0.0, 0.0])
}

/// Error of the wrench while the sensor turns slowly about its y axis. An effect that is zero at rest is shown while the
/// sensor slides.
fn tool(size: &Size, wrench: impl Fn(&ToolState) -> Wrench<f64>) -> Picture {
    let hanging = ToolState::hanging(TOOL_KG, TOOL_COM_M);
    let turned = |tilt: f64| {
        let c_from_s = Rotation3::from_axis_angle(&Vector3::y_axis(), tilt);
        let s_from_c: Matrix3<f64> = c_from_s.inverse().into_inner();
        let state = ToolState {
            s_from_c,
            ..hanging
        };
        (tilt, [Wrench::zero(), wrench(&state)])
    };
    let sweep: Wrenches = tilts().map(turned).collect();
    if sweep.iter().any(|(_, [_, error])| *error != Wrench::zero()) {
        return shown(Excitation::TiltSweep, size, "tilt about y [rad]", sweep);
    }
    let moved = |t: f64| {
        let acceleration = Vector3::new(slide(t).acceleration, 0.0, 0.0);
        let motion = LoadMotion {
            acceleration,
            ..LoadMotion::uniform()
        };
        let state = ToolState { motion, ..hanging };
        (t, [Wrench::zero(), wrench(&state)])
    };
    shown(
        Excitation::Slide,
        size,
        "time [s]",
        instants(SLIDE_S).map(moved).collect(),
    )
}
