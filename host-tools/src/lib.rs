//! Host side of softdock: the simulated rig, the board on the host, recordings, models and their
//! comparison, reports, and the command line.

pub mod bench;
pub mod board;
pub mod catalogue;
pub mod check;
pub mod cli;
pub mod commission;
pub mod compare;
pub mod diagnose;
pub mod experiment;
pub mod firmware;
pub mod fit;
pub mod identity;
pub mod import;
pub mod input;
pub mod model;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rig;
pub mod robot_config;
pub mod statistics;
pub mod telemetry;
