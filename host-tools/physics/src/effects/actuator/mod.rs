//! From the commanded velocity of an axis to the executed one, in this order: rounding of the
//! command, transport delay, then lag, servo or structural mode, then the pause at a zero crossing,
//! then limits of acceleration, jerk and velocity, at last gain and play of the drive.

pub mod actuation_delay;
pub mod actuation_lag;
pub mod backlash;
pub mod command_quantisation;
pub mod jerk_limit;
pub mod rate_limit;
pub mod second_order_servo;
pub mod structural_resonance;
pub mod velocity_gain;
pub mod velocity_saturation;
pub mod zero_cross_pause;
