//! ATI force/torque sensors with the NETCANOEM interface, CAN 2.0A.
//!
//! The sensor is polled and sends no time stamp and no counter. Identifier: `(base << 4) | opcode`; multi-byte values
//! are big-endian. The wrench is `M * gauges / counts per unit`; the sensor has no tare, so the bias is left in.
//!
//! Sources: ATI manual 9610-05-1030; the public drivers `KITrobotics/ati_force_torque` and
//! `griloHBG/ati-netcanoem-cpp`.
//!
//! | file | |
//! |---|---|
//! | `protocol` | requests and answers as frames |
//! | `calibration` | units, matrix, gauges into a wrench |
//! | `start_up` | reading the calibration from the sensor |
//! | `driver` | polling, timeouts, pairing |
//! | `device` | the sensor's side, for simulated sensors |

mod calibration;
mod device;
mod driver;
mod protocol;
mod start_up;

pub use calibration::{AtiCalibration, ForceUnit, TorqueUnit};
pub use device::{AtiDevice, AtiDeviceError};
pub use driver::{AtiConfig, AtiDriver};
pub use start_up::AtiIdentity;
