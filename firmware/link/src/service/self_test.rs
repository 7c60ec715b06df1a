//! What a new board is asked to do at its first power-on, beside what it tells at any time.

use serde::{Deserialize, Serialize};

/// Time after which LEDs that a test has lit say again what they have to, s.
pub const LAMPS_S: u16 = 60;

/// What it is to do. Not while the robot moves or may begin to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SelfTest {
    /// Send CAN frames to itself inside of the controller: the bus sees nothing of them.
    Can,
    /// Light these LEDs, green, yellow, red, for [`LAMPS_S`] at most; none: what they have to say.
    Lamps(Option<[bool; 3]>),
    /// Nothing any more, with interrupts off: the watchdog has to reset the board.
    Hang,
}

/// Frames that a CAN controller has sent to itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LoopBack {
    /// Sent.
    pub sent: u8,
    /// Of these, received as they were sent.
    pub back: u8,
}
