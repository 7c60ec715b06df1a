//! Peers of a board process: a robot in lock step, a sensor behind SLCAN, a simulated rig that is both, and peers in Python.

mod board;
mod patience;
mod proxy;
pub mod python;
mod qemu;
mod rig;
mod robot;
mod running_robot;
mod sensor;
mod served;

pub use board::{Board, counted, text};
pub use patience::{BUSY_COMPUTER, PATIENCE, patient, without_noise};
pub use proxy::{Fault, Proxy};
pub use qemu::{Cable, QemuBoard};
pub use rig::{LockStepRig, Motion};
pub use robot::{Answer, Robot, counts};
pub use running_robot::RunningRobot;
pub use sensor::Sensor;
pub use served::{Served, params, serve, serve_emulated};
