//! The unmodelled dynamics of the actuator, by simulation: delays, pauses and limits are no terms of a regression.
//!
//! The velocities that were sent are free of noise, so the simulated execution is. Every stage of
//! [`Stage::ALL`](softdock_physics::model::stage::Stage::ALL) is tried alone, with its parameters searched; if none reaches the noise, pairs
//! are searched jointly, and more are added as long as the evidence over all logs rises.

mod alone;
mod candidate;
mod cost;
mod dead_zone;
mod finding;
mod forms;
mod grid;
mod intervals;
mod pairs;
mod refine;
mod search;
mod steps;
mod tried;

pub(crate) use candidate::{Candidate, Search, level};
pub(crate) use cost::{Cost, LogCost, Term};
pub(crate) use finding::{ActuatorFinding, actuator_stage};
