//! CAN frames and the force/torque sensors that speak them.
//!
//! A [`CanSensor`] is a [`SensorDriver`](crate::sensor::SensorDriver) of either.
//!
//! | file | |
//! |---|---|
//! | `frame` | CAN 2.0 frames |
//! | `sensor` | the driver behind which the sensors look alike |
//! | [`ati`] | ATI NETCANOEM: polled, with status bits |
//! | [`sri`] | SRI M8123B2: streaming, without status |

pub mod ati;
mod frame;
mod sensor;
pub mod sri;

pub use frame::{Frame, FrameError, Id};
pub use sensor::CanSensor;
