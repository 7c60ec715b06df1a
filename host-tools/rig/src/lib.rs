//! The simulated docking rig, and the controller board on this computer: in virtual time beside the
//! rig, as a process in real time, and in QEMU; the rig in real time as a peer of a board elsewhere; and the simulated sensor on EtherCAT.

pub mod board;
pub mod ethercat;
pub mod firmware;
pub mod peer;
pub mod rig;
