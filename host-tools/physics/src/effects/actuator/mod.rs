//! From the commanded velocity of an axis to the executed one, in this order: rounding of the command, its dead zone, gain by
//! direction, transport delay; then lag, servo or structural mode; then the pause at a zero crossing; then limits of
//! acceleration, jerk and velocity; finally gain and play of the drive.

pub mod actuation_delay;
pub mod actuation_lag;
pub mod backlash;
pub mod command_deadzone;
pub mod command_quantisation;
pub mod gain_by_direction;
pub mod jerk_limit;
pub mod rate_limit;
pub mod second_order_servo;
pub mod structural_resonance;
pub mod velocity_gain;
pub mod velocity_saturation;
pub mod zero_cross_pause;

use actuation_lag::FirstOrderLag;
use backlash::Backlash;
use command_deadzone::CommandDeadZone;
use command_quantisation::CommandQuantisation;
use gain_by_direction::GainByDirection;
use jerk_limit::JerkLimit;
use rate_limit::RateLimit;
use second_order_servo::SecondOrderServo;
use velocity_gain::VelocityGain;
use velocity_saturation::VelocitySaturation;
use zero_cross_pause::ZeroCrossingPause;

/// A stage of one axis: takes the mean velocity over a step and returns the mean velocity over it.
#[derive(Clone, Debug)]
pub enum AxisStage {
    /// Rounding of the command.
    Rounding(CommandQuantisation),
    /// Dead zone of the command.
    DeadZone(CommandDeadZone),
    /// Gain of a command by its direction.
    Direction(GainByDirection),
    /// First-order lag.
    Lag(FirstOrderLag),
    /// Second-order response, well damped or not.
    Servo(SecondOrderServo),
    /// Pause at a zero crossing.
    Pause(ZeroCrossingPause),
    /// Limit of the acceleration.
    Rate(RateLimit),
    /// Limit of the jerk.
    Jerk(JerkLimit),
    /// Limit of the velocity.
    Saturation(VelocitySaturation),
    /// Gain.
    Gain(VelocityGain),
    /// Play of the drive.
    Backlash(Backlash),
}

impl AxisStage {
    /// Whether it acts on a command when it is sent, before the transport delay.
    pub fn is_of_the_command(&self) -> bool {
        matches!(
            self,
            Self::Rounding(_) | Self::DeadZone(_) | Self::Direction(_)
        )
    }

    /// One step.
    pub fn advance(&mut self, velocity: f64) -> f64 {
        match self {
            Self::Rounding(stage) => stage.apply(velocity),
            Self::DeadZone(stage) => stage.apply(velocity),
            Self::Direction(stage) => stage.apply(velocity),
            Self::Lag(stage) => stage.advance(velocity),
            Self::Servo(stage) => stage.advance(velocity),
            Self::Pause(stage) => stage.advance(velocity),
            Self::Rate(stage) => stage.advance(velocity),
            Self::Jerk(stage) => stage.advance(velocity),
            Self::Saturation(stage) => stage.apply(velocity),
            Self::Gain(stage) => stage.apply(velocity),
            Self::Backlash(stage) => stage.advance(velocity),
        }
    }
}
