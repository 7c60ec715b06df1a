//! The simulated docking rig, and the controller board on this computer: in virtual time beside the
//! rig, as a process in real time, and in QEMU.

pub mod board;
pub mod firmware;
pub mod rig;
