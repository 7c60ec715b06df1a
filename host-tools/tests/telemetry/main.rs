//! The recorder's side of the telemetry: datagrams in, recordings out.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a helper of a test fails the test"
)]

mod board;

mod files;
mod losses;
mod socket;
mod strangers;
