//! The unmodelled dynamics of the actuator, found by simulation, as delays, pauses and limits are not linear in any parameter.
//!
//! The velocities that were sent are free of noise, and so is the simulated execution. Every stage of
//! [`Stage::ALL`](softdock_physics::model::stage::Stage::ALL) is tried alone with its best parameters. If none reaches the noise,
//! pairs are searched jointly, and more stages are added as long as the evidence over all logs rises.

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
