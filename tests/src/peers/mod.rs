//! Peers of a board process: a robot in lock step, a sensor behind SLCAN, a simulated rig that is both,
//! and those in Python.

mod board;
pub mod python;
mod qemu;
mod rig;
mod robot;
mod sensor;

pub use board::{BUSY_COMPUTER, Board, counted, text};
pub use qemu::QemuBoard;
pub use rig::{LockStepRig, Motion};
pub use robot::{Answer, Robot, counts};
pub use sensor::Sensor;
