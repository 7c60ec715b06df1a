//! The firmware's tasks on the host: in virtual time inside this process ([`virtual_time`]), or
//! as a process of its own with real sockets in real time ([`process`]); and the firmware itself
//! in QEMU ([`qemu`]).

// Links the implementation of critical sections that what tasks share needs.
use critical_section as _;

mod block_on;
pub mod cycle_driver;
pub mod flash;
pub mod process;
pub mod qemu;
mod simulated_segment;
mod simulated_sensor;
mod tasks;
mod time_driver;
pub mod virtual_time;
mod world;

pub(crate) use simulated_segment::ReadingSampler;
pub(crate) use simulated_sensor::SimulatedSensor;
