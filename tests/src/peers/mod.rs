//! Peers of a board process: a robot in lock step, a sensor behind SLCAN, and those in Python.

mod board;
pub mod python;
mod robot;
mod sensor;

pub use board::{BUSY_COMPUTER, Board, counted, text};
pub use robot::{Answer, Robot, counts};
pub use sensor::Sensor;
