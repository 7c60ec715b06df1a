//! Pictures of the actuator's effects: executed velocity over time.

use super::excitation::{
    CYCLE_S, Excitation, REVERSAL_S, STEP_S, STEPS_PER_CYCLE, instants, reversal_command,
};
use super::picture::{Curve, Picture};
use super::size::Size;
use anyhow::{Result, bail};
use softdock_physics::effects::actuator::actuation_delay::TransportDelay;
use softdock_physics::effects::{Actuator, Effect, Law};

/// Commands that the delay line of a picture can hold.
const COMMANDS_IN_FLIGHT: usize = 64;

/// Maps the velocity commanded in a simulation step to the velocity executed in it, m/s.
type Axis = Box<dyn FnMut(f64) -> f64>;

pub(super) fn picture(effect: &Effect, size: &Size) -> Result<Picture> {
    let axis = axis(effect, size)?;
    Ok(Picture::new(
        Excitation::VelocityReversal,
        size,
        ["time [s]", "executed velocity [m/s]"],
        [executed(Box::new(|command| command)), executed(axis)],
    ))
}

/// Response of the axis to the velocity command of the excitation: executed velocity (m/s) over time (s).
fn executed(mut axis: Axis) -> Curve {
    instants(REVERSAL_S)
        .map(|t| (t, axis(reversal_command(t))))
        .collect()
}

fn axis(effect: &Effect, size: &Size) -> Result<Axis> {
    let p = size.values();
    match effect.law {
        Law::Actuator(Actuator {
            axis: Some(axis), ..
        }) => {
            let mut axis = axis(&p, STEP_S)?;
            Ok(Box::new(move |u| axis.advance(u)))
        }
        Law::Actuator(Actuator {
            late: Some(late), ..
        }) => delay(late(&p).delay_s),
        _ => bail!("the actuator's effect `{}` has no picture", effect.id),
    }
}

/// A pure delay. The delay line takes one command per cycle and is read once per simulation step.
fn delay(delay_s: f64) -> Result<Axis> {
    let mut line = TransportDelay::<1, COMMANDS_IN_FLIGHT>::new(delay_s, CYCLE_S)?;
    let mut step = 0;
    Ok(Box::new(move |u| {
        if step == 0 {
            line.push([u]);
        }
        let from = step as f64 * STEP_S;
        step = (step + 1) % STEPS_PER_CYCLE;
        let [executed] = line.mean_over(from, from + STEP_S);
        executed
    }))
}
