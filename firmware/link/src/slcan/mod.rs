//! SLCAN: the serial-line protocol of Lawicel's CAN adapters, spoken by python-can, slcand and many tools.
//!
//! ASCII lines that end with a carriage return, case-sensitive. The client opens the channel (`O`), puts frames on the
//! bus (`t`, `T`, `r`, `R`) and gets the frames of the bus in the same form. The adapter answers a command with a
//! carriage return, a refused one with BEL.
//!
//! Source: Lawicel CANUSB and CAN232 manuals.
//!
//! | file | |
//! |---|---|
//! | `line` | a frame as a line |
//! | `adapter` | the adapter's side: bytes from the client into actions |
//! | `client` | the client's side: opens the channel, an adapter's bytes into frames |

mod adapter;
mod client;
mod line;

pub use adapter::{Slcan, SlcanEvent};
pub use client::{AdapterEvent, AdapterLines, CLOSING, OPENING};
pub use line::{MAX_LINE_BYTES, SlcanError, encode_frame_line, parse_frame_line};
