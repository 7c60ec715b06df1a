//! What all microcontrollers share: [`clock`], [`udp`], [`telemetry`] and [`service`] over Embassy,
//! [`start`], which puts robot and network together, and [`boot`] and [`watch`] for the log.
//!
//! The log is defmt's: the board sends numbers, the text stays in the ELF file, and the host puts
//! them together. Nothing of the control cycle writes a log; a task of low priority looks at the
//! shared state instead.

pub mod boot;
pub mod clock;
pub mod service;
pub mod start;
pub mod telemetry;
pub mod udp;
pub mod watch;
