//! `softdock check` against simulations with plants that share no code with it.

mod files;
mod grid;
#[path = "../../firmware/control/tests/delay_laws/rig.rs"]
#[allow(dead_code)] // The laws' own tests use more of it.
mod rig;
