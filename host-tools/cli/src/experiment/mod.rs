//! Experiments on the simulated rig: scenarios, the impacts found in them, the paper's figures,
//! and the guided demonstration.

pub mod demo;
pub mod diagnosis;
pub mod impact_table;
pub mod impacts;
pub mod jog_rehearsal;
pub mod record_file;
pub mod rehearsal;
pub mod reproduce;
pub mod reproduce_page;
pub mod run;
pub mod scenario;
pub mod spring_rod;
pub mod starter;
