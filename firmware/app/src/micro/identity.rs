//! Identity of the firmware.

use crate::processor::Processor;
use core::fmt;

/// Identity of the firmware.
#[derive(Clone, Copy, Debug)]
pub struct Identity {
    /// Version of the firmware.
    pub version: &'static str,
    /// Git hash, and whether there were changes.
    pub git: &'static str,
    /// Board and chip.
    pub board: &'static str,
    /// What its processor can compute.
    pub processor: Processor,
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "softdock {} ({}) on {}",
            self.version, self.git, self.board
        )
    }
}
