//! The parameter service on a serial line: settings, status and commands of a board.
//!
//! ```text
//! 0x00 COBS( header | payload | CRC-32 ) 0x00
//! ```
//!
//! `frame` carries messages over a line that may lose or change bytes. `message` defines the messages, `health` and `machine` the
//! data that are checked before a test, `self_test` the tests of a new board. The host asks and the board answers; the board
//! never sends unasked. An answer has the sequence number of its request. A host that gets no answer sends the same request
//! again; the board recognises it by its number and checksum, and answers again without doing anything twice.

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
