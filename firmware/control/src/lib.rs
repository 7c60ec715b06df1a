//! Physics and the one control cycle of a docking test rig.
//!
//! Nothing in here does I/O, reads a clock, allocates, formats, blocks or panics: the cycle is a
//! function of (state, settings, one sensor sample, one robot telegram) to (state, motion,
//! trace). A recording can therefore be replayed bit for bit, on the host or on the board.
//!
//! Where to look:
//! - [`frames`]: poses, twists, wrenches and the drawing of all named frames,
//! - [`cycle`]: the step that runs with each telegram of the robot,
//! - [`wrench`], [`dynamics`], [`delay`], [`limits`], [`modes`]: its phases in their order,
//! - [`settings`]: what a person writes; `validation` declares the range of each field.
#![cfg_attr(not(test), no_std)]

mod bodies;
pub mod checked;
pub mod cost;
pub mod cycle;
pub mod delay;
pub mod described;
pub mod dynamics;
mod fault;
pub mod flags;
pub mod frames;
pub mod health;
pub mod io;
pub mod jog;
pub mod limits;
pub mod manipulator;
pub mod modes;
pub mod range;
pub mod robot;
mod run;
pub mod scalar;
pub mod settings;
mod sum;
mod validation;
pub mod wrench;
pub mod zero;
