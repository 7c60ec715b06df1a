//! `softdock check` against simulations with plants that share no code with it.

#![allow(clippy::unwrap_used)] // Helpers of tests are not `#[test]` functions themselves.

#[path = "../../../firmware/control/tests/delay_laws/case.rs"]
#[allow(dead_code)] // The laws' own tests use more of it.
mod case;
#[path = "../../../firmware/control/tests/closed_loop/mod.rs"]
#[allow(dead_code)] // Likewise.
mod closed_loop;
mod files;
mod grid;
