//! What all microcontrollers share: [`clock`], [`ethernet_link`], [`stamped`], [`udp`], [`telemetry`] and [`service`] over
//! Embassy;
//! [`start`], which puts network, robot and telemetry together; [`boot`] and [`monitor`] for the log.
//! A board adds its clocks, pins and drivers, and the tasks that name their types.
//!
//! The log is defmt's: the board sends numbers, the texts stay in the ELF file, and the host combines them. Nothing of the
//! control cycle writes to the log; a task of low priority watches the shared state instead.

pub mod boot;
pub mod clock;
pub mod ethernet_link;
pub mod identity;
pub mod monitor;
pub mod service;
pub mod stamped;
pub mod start;
pub mod telemetry;
pub mod udp;

use crate::shared::Shared;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;

/// State that the tasks of all priorities share.
pub static SHARED: Shared<CriticalSectionRawMutex> = Shared::new();
