//! Pictures of the actuator's effects: executed velocity over time.

use super::excitation::{
    CYCLE_S, Excitation, REVERSAL_S, STEP_S, STEPS_PER_CYCLE, instants, reversal_command,
};
use super::picture::{Curve, Picture};
use super::size::Size;
use anyhow::{Result, bail};
use softdock_physics::effects::actuator::actuation_delay::TransportDelay;
use softdock_physics::effects::actuator::actuation_lag::FirstOrderLag;
use softdock_physics::effects::actuator::backlash::Backlash;
use softdock_physics::effects::actuator::command_quantisation::CommandQuantisation;
use softdock_physics::effects::actuator::jerk_limit::JerkLimit;
use softdock_physics::effects::actuator::rate_limit::RateLimit;
use softdock_physics::effects::actuator::second_order_servo::SecondOrderServo;
use softdock_physics::effects::actuator::velocity_gain::VelocityGain;
use softdock_physics::effects::actuator::velocity_saturation::VelocitySaturation;
use softdock_physics::effects::actuator::zero_cross_pause::ZeroCrossingPause;

/// Commands that the delay line of a picture can hold.
const COMMANDS_IN_FLIGHT: usize = 64;

/// From the velocity commanded in a step to the one executed.
type Axis = Box<dyn FnMut(f64) -> f64>;

pub(super) fn picture(id: &str, size: &Size) -> Result<Picture> {
    let axis = axis(id, size)?;
    Ok(Picture::new(
        Excitation::VelocityReversal,
        size,
        ["time [s]", "executed velocity [m/s]"],
        [executed(Box::new(|command| command)), executed(axis)],
    ))
}

/// What an axis makes of the command.
fn executed(mut axis: Axis) -> Curve {
    instants(REVERSAL_S)
        .map(|t| (t, axis(reversal_command(t))))
        .collect()
}

fn axis(id: &str, size: &Size) -> Result<Axis> {
    Ok(match id {
        "command_quantisation" => {
            let axis = CommandQuantisation::new(size.get("step_m_s"))?;
            Box::new(move |u| axis.apply(u))
        }
        "actuation_delay" => delay(size.get("extra_delay_s"))?,
        "actuation_lag" => {
            let mut axis = FirstOrderLag::new(size.get("extra_lag_s"), STEP_S)?;
            Box::new(move |u| axis.advance(u))
        }
        "second_order_servo" | "structural_resonance" => {
            let [frequency, damping] = size.all(["frequency_hz", "damping_ratio"]);
            let mut axis = SecondOrderServo::new(frequency, damping, STEP_S)?;
            Box::new(move |u| axis.advance(u))
        }
        "zero_cross_pause" => {
            let mut axis = ZeroCrossingPause::new(size.get("pause_s"), STEP_S)?;
            Box::new(move |u| axis.advance(u))
        }
        "rate_limit" => {
            let mut axis = RateLimit::new(size.get("max_acceleration_m_s2"), STEP_S)?;
            Box::new(move |u| axis.advance(u))
        }
        "jerk_limit" => {
            let mut axis = JerkLimit::new(size.get("max_jerk_m_s3"), STEP_S)?;
            Box::new(move |u| axis.advance(u))
        }
        "velocity_saturation" => {
            let axis = VelocitySaturation::new(size.get("max_velocity_m_s"))?;
            Box::new(move |u| axis.apply(u))
        }
        "velocity_gain" => {
            let axis = VelocityGain::new(size.get("gain_error"))?;
            Box::new(move |u| axis.apply(u))
        }
        "backlash" => {
            let mut axis = Backlash::new(size.get("width_m"), STEP_S)?;
            Box::new(move |u| axis.advance(u))
        }
        other => bail!("the actuator's effect `{other}` has no picture"),
    })
}

/// A delay line takes whole cycles, and is asked for each step of them.
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
