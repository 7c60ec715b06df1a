//! The integration tests: one program, a folder per kind.
//!
//! What takes long is ignored with a reason that begins with `long:`; `tests/run --all` runs that too.
#![allow(clippy::print_stderr, reason = "a test says what it measured")]

mod campaigns;
mod check;
mod cli;
mod commissioning;
mod delay_laws;
mod delay_predictor;
mod diagnosis;
mod ethercat;
mod faults;
mod fuzz;
mod known_answers;
mod peers;
mod qemu;
mod recordings;
mod reports;
mod scalars;
mod telemetry;
mod workbench;
