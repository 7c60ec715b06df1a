//! Host side of softdock: the simulated rig, the board on the host, recordings, models and their
//! comparison, reports, and the command line.

pub mod board;
pub mod cli;
pub mod compare;
pub mod experiment;
pub mod identity;
pub mod input;
pub mod model;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rig;
pub mod robot_config;
