//! The host program of softdock: its commands, and what they need beyond the simulated rig
//! (`softdock-rig`) and the analysis of recordings (`softdock-analysis`).

pub mod bench;
pub mod campaign;
pub mod catalogue;
pub mod check;
pub mod cli;
pub mod experiment;
pub mod pages;
pub mod robot_config;
