//! The host program of softdock: its commands, and the pages that they write.

pub mod catalogue;
pub mod cli;
pub mod pages;
pub mod robot_config;
