//! Host side of softdock: the simulated rig, the board on the host, recordings, models and their
//! comparison, reports, and the command line.

pub mod board;
pub mod compare;
pub mod identity;
pub mod input;
pub mod model;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rig;
