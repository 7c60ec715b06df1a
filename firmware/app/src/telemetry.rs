//! Telemetry: each cycle goes to a recorder on the network, with what a replay needs besides.
//!
//! ```text
//! robot task             encoder task                           network task
//! RecordQueue --slots--> encode: postcard, parts --datagrams--> transmit: UDP
//! ```
//!
//! The cycle never waits. Its cost is bounded: [`RecordQueue`] copies one record (about 1.3 kB) into a free slot and takes two
//! short locks, in which only indices are read and written; without a free slot it counts and returns. That happens after the
//! robot has its answer; it takes a few µs at 480 MHz (estimated, not measured). All else happens in two tasks that may run at a
//! lower priority: [`encode`] makes datagrams, [`transmit`] hands them to the network stack. They may run on two executors. If
//! the network is slow, `transmit` waits for it, `encode` for `transmit`, and the slots fill up; records without room are counted
//! in one place, and the count is sent to the recorder.
//!
//! A message is a record or the announcement. It travels in one or more datagrams
//! ([`MessagePart`] has the layout), each small enough for an Ethernet frame. Datagrams are
//! numbered, so that the recorder knows what the network lost.

mod datagram;
mod message;
mod queue;
mod stream;
mod tasks;

pub use datagram::{
    DATAGRAM_MAX_BYTES, Datagram, DatagramError, HEADER_BYTES, Kind, MAGIC, MessagePart,
    PAYLOAD_MAX_BYTES, VERSION,
};
pub use message::{
    Announcement, MESSAGE_MAX_BYTES, MessageError, read_machine, read_record, schema,
};
pub use queue::{RecordQueue, Slot};
pub use stream::{MessageParts, Stream};
pub use tasks::{ANNOUNCE_PERIOD_US, encode, transmit};
