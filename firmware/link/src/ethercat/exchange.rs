//! Messages between the bus and the driver.

use super::process_data::{INPUT_BYTES, OUTPUT_BYTES};
use crate::sensor::SensorFault;

/// A request of the driver, or the answer to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exchange {
    /// Request: start the SubDevice anew, from INIT to OP.
    StartUp,
    /// Answer: it is operational.
    Ready(Setup),
    /// Answer: it is not, and why.
    Failed(SensorFault),
    /// Request: exchange process data, with these outputs.
    Outputs([u8; OUTPUT_BYTES]),
    /// Answer: a frame came back.
    Inputs {
        /// Working counter of the frame; [`super::WORKING_COUNTER`] if one SubDevice has read and written.
        working_counter: u16,
        /// The SubDevice says that it is in OP.
        operational: bool,
        /// The inputs.
        bytes: [u8; INPUT_BYTES],
    },
}

/// Set-up that the SubDevice reported before it became operational.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Vendor number of its identity.
    pub vendor: u32,
    /// Product code of its identity.
    pub product: u32,
    /// Code of its force unit.
    pub force_unit: u8,
    /// Code of its torque unit.
    pub torque_unit: u8,
    /// Counts per unit of force.
    pub counts_per_force: i32,
    /// Counts per unit of torque.
    pub counts_per_torque: i32,
}

/// A step of the start-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartUp {
    /// Its EEPROM and registers: INIT to PRE-OP.
    PreOp,
    /// Its mapping of process data: PRE-OP to SAFE-OP.
    SafeOp,
    /// SAFE-OP to OP.
    Op,
}
