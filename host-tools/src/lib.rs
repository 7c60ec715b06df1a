//! Host side of softdock: the simulated rig, the board on the host, recordings, models and their
//! comparison, reports, and the command line.

pub mod input;
pub mod report;
pub mod rig;
