//! Recordings through their public functions: files, text, replay.

#![allow(clippy::unwrap_used)] // Helpers of tests are not `#[test]` functions themselves.

mod recording_csv;
mod recording_damage;
mod recording_file;
mod replay;
mod sample;
