//! The ATI driver with the simulated sensor, in simulated time.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a helper of a test fails the test"
)]

mod bench;
mod faults;
mod pairing;
mod start_up;
