//! CAN frames and the force/torque sensors that speak them.
//!
//! A [`CanSensor`] is a [`SensorDriver`](crate::sensor::SensorDriver) of either.
//!
//! | file | |
//! |---|---|
//! | `frame` | CAN 2.0 frames |
//! | `bit_timing` | where a bit is sampled |
//! | `sensor` | the driver behind which the sensors look alike |
//! | [`ati`] | ATI NETCANOEM: polled, with status bits |
//! | [`sri`] | SRI M8123B2: streaming, without status |

pub mod ati;
mod bit_timing;
mod frame;
mod sensor;
pub mod sri;

pub use bit_timing::{BitTiming, SAMPLE_POINT_PER_MILLE};
pub use frame::{Frame, FrameError, Id};
pub use sensor::CanSensor;
