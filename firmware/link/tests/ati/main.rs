//! The ATI driver against the simulated sensor, on simulated time.
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
