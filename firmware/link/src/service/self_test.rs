//! Tests of a new board at its first power-on.

use serde::{Deserialize, Serialize};

/// Time after which LEDs lit by a test show the state again, s.
pub const LAMPS_S: u16 = 60;

/// A test. Refused while the robot moves or may begin to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SelfTest {
    /// Internal loop-back of CAN frames in the controller: nothing appears on the bus.
    Can,
    /// Light these LEDs (green, yellow, red) for at most [`LAMPS_S`]; `None`: they show the state again.
    Lamps(Option<[bool; 3]>),
    /// Hang with interrupts off: the watchdog has to reset the board.
    Hang,
}

/// Result of a loop-back test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LoopBack {
    /// Sent.
    pub sent: u8,
    /// Of these, received unchanged.
    pub back: u8,
}
