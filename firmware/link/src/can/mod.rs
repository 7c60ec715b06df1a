//! CAN frames and the force/torque sensors that speak them.
//!
//! A sensor driver is a state machine that owns no bus and no clock: the caller sends what
//! [`SensorDriver::poll_transmit`] hands out, gives every received frame to [`SensorDriver::receive`], and calls again
//! at [`SensorDriver::next_deadline_us`]. Times are microseconds of any monotonic clock.
//!
//! | file | |
//! |---|---|
//! | `frame` | CAN 2.0 frames |
//! | `reading` | one reading of any sensor |
//! | `sensor` | the driver behind which the sensors look alike |
//! | [`ati`] | ATI NETCANOEM: polled, with status bits |
//! | [`sri`] | SRI M8123B2: streaming, without status |

pub mod ati;
mod frame;
mod reading;
mod sensor;
pub mod sri;

pub use frame::{Frame, FrameError, Id};
pub use reading::{ReadingFlags, SensorReading};
pub use sensor::{SensorCounters, SensorDriver, SensorFault, SensorState};
