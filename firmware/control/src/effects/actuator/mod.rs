//! From the commanded velocity of an axis to the executed one, in this order: transport delay, then
//! lag or servo, then the pause at a zero crossing, then limits of acceleration and velocity.

pub mod first_order_lag;
pub mod rate_limit;
pub mod second_order_servo;
pub mod transport_delay;
pub mod velocity_saturation;
pub mod zero_crossing_pause;
