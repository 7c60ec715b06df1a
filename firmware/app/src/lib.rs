//! The Embassy tasks of the docking-rig controller, generic over their board.
//!
//! Two tasks share little: [`sensor`] keeps the newest force sample up to date, [`robot`] answers
//! each telegram of the robot with one control cycle. Two more bring the record of each cycle to a
//! recorder ([`telemetry`]). The robot is the clock; nothing here starts
//! a cycle by a timer. What the tasks need from a board is four small traits, whose methods are
//! contracts ([`board`]); a microcontroller, a process with sockets, and a simulation in virtual
//! time implement them, and the tasks run unchanged on all three.
//!
//! What all microcontrollers share of their implementation is here as well: a CAN bus behind a
//! serial line ([`slcan_bus`]), and with the feature `micro` clock, network and log (`micro`).
#![cfg_attr(not(test), no_std)]

pub mod arrivals;
pub mod auto_start;
pub mod board;
pub mod can_queue;
mod checksum;
pub mod emulated_flash;
#[cfg(feature = "ethercat")]
pub mod ethercat;
pub mod ethernet_dma;
pub mod image;
pub mod leds;
pub mod loop_back;
pub mod meter;
#[cfg(feature = "micro")]
pub mod micro;
pub mod parameters;
pub mod phy;
pub mod processor;
pub mod record;
pub mod robot;
pub mod robot_cycle;
pub mod robot_link;
pub mod robot_protocol;
pub mod rsi;
mod schema;
pub mod sensor;
pub mod service;
pub mod settings;
pub mod shared;
pub mod slcan_bus;
pub mod store;
pub mod telemetry;
#[cfg(feature = "ethercat")]
pub mod w5500;
pub mod watchdog;
