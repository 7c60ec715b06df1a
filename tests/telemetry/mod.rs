//! The recorder's side of the telemetry: datagrams in, recordings out.

pub(crate) mod board;
mod files;
mod losses;
mod socket;
mod strangers;
mod whole;
