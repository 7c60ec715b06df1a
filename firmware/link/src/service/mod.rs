//! The parameter service on a serial line: settings, status and commands of a board.
//!
//! ```text
//! 0x00 COBS( header | payload | CRC-32 ) 0x00
//! ```
//!
//! `frame` puts messages on a line on which bytes may be lost or changed, `message` says what they
//! mean, `health` and `machine` what is looked at before a test, `self_test` what a new board does. The host asks, the board answers; nothing comes
//! unasked. An answer bears the sequence
//! number of its request. A host that gets no answer sends the same request again, and the board,
//! which knows it by its number and checksum, answers again without doing anything twice.

mod frame;
mod health;
mod machine;
mod message;
mod self_test;

pub use frame::{
    ENCODED_MAX_BYTES, Frame, FrameError, FrameReader, HEADER_BYTES, Kind, PAYLOAD_MAX_BYTES,
};
pub use health::{FlashSlot, Health, RobotHealth, SensorHealth};
pub use machine::{
    ANSWER_BINS, AnswerTimes, EthernetHealth, InputStatistics, Machine, StackUse, Work,
};
pub use message::{
    ARRAY_MAX, Answer, Counters, Entry, Form, Hello, LINE_BYTES, LINES_MAX, LogLine, Origin,
    PROTOCOL, Refusal, Request, Status, Text, Value, WORDS_MAX, Word,
};
pub use self_test::{LAMPS_S, LoopBack, SelfTest};
