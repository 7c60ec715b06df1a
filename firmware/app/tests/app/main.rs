//! The firmware's tasks against a simulated robot and a simulated sensor, in virtual time.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a helper of a test fails the test"
)]

mod bench;
mod sensor;
mod world;

mod bus_off;
mod operator;
mod process_data;
mod queue;
mod recorder;
mod sampling;
mod senders;
mod sensor_faults;
mod sensor_start;
mod sequence;
mod silence;
mod slcan_bus;
mod telemetry;
